// A camera that looks at a target: z is up, angles are in radians.

import type { Vector3 } from "./protocol";

export interface CameraState {
    target: Vector3;
    distance: number;
    /** Direction from the target to the eye: 0 along x, a quarter turn along y. */
    azimuth: number;
    /** Of the eye over the target's horizon. */
    elevation: number;
}

export interface CameraBasis {
    eye: Vector3;
    right: Vector3;
    up: Vector3;
    /** From the target to the eye. */
    back: Vector3;
}

/** Vertical angle of view. */
export const fieldOfView = (35 * Math.PI) / 180;

const quarter = Math.PI / 2;

export function add(a: Vector3, b: Vector3, factor = 1): Vector3 {
    return [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]];
}

export function dot(a: Vector3, b: Vector3): number {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

export function basis({ target, distance, azimuth, elevation }: CameraState): CameraBasis {
    const [sa, ca] = [Math.sin(azimuth), Math.cos(azimuth)];
    const [se, ce] = [Math.sin(elevation), Math.cos(elevation)];
    const back: Vector3 = [ce * ca, ce * sa, se];
    return {
        eye: add(target, back, distance),
        right: [-sa, ca, 0],
        up: [-se * ca, -se * sa, ce],
        back,
    };
}

export function orbited(camera: CameraState, turn: number, rise: number): CameraState {
    const elevation = Math.min(quarter, Math.max(-quarter, camera.elevation + rise));
    return { ...camera, azimuth: camera.azimuth + turn, elevation };
}

/** Scene units that a pixel covers at the target. */
export function unitsPerPixel(camera: CameraState, height: number): number {
    return (2 * camera.distance * Math.tan(fieldOfView / 2)) / height;
}

/** Moves the picture by so many pixels to the right and downwards. */
export function panned(camera: CameraState, dx: number, dy: number, height: number): CameraState {
    const { right, up } = basis(camera);
    const unit = unitsPerPixel(camera, height);
    return { ...camera, target: add(add(camera.target, right, -dx * unit), up, dy * unit) };
}

/**
 * Nearer (factor < 1) or farther; the point of the target's plane that is (dx, dy) pixels from the
 * middle stays.
 */
export function zoomed(
    camera: CameraState,
    factor: number,
    dx: number,
    dy: number,
    height: number,
): CameraState {
    const { right, up } = basis(camera);
    const unit = unitsPerPixel(camera, height) * (1 - factor);
    const target = add(add(camera.target, right, dx * unit), up, -dy * unit);
    return { ...camera, target, distance: camera.distance * factor };
}

/** Looks at a box so that all of it is in the picture, from the same direction. */
export function framed(
    camera: CameraState,
    min: Vector3,
    max: Vector3,
    aspect: number,
): CameraState {
    const target: Vector3 = [(min[0] + max[0]) / 2, (min[1] + max[1]) / 2, (min[2] + max[2]) / 2];
    const { right, up, back } = basis({ ...camera, target });
    const tangent = Math.tan(fieldOfView / 2);
    let distance = 0;
    for (let corner = 0; corner < 8; ++corner) {
        const p: Vector3 = [
            corner & 1 ? max[0] : min[0],
            corner & 2 ? max[1] : min[1],
            corner & 4 ? max[2] : min[2],
        ];
        const from = add(p, target, -1);
        const high = Math.abs(dot(from, up)) / tangent;
        const wide = Math.abs(dot(from, right)) / (tangent * aspect);
        distance = Math.max(distance, dot(from, back) + 1.06 * Math.max(high, wide));
    }
    return { ...camera, target, distance: distance || 1 };
}
