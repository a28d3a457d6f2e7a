import { describe, expect, it } from "vitest";
import {
    add,
    basis,
    dot,
    fieldOfView,
    framed,
    orbited,
    panned,
    unitsPerPixel,
    zoomed,
    type CameraState,
} from "../src/camera";
import type { Vector3 } from "../src/protocol";

const camera: CameraState = { target: [3, -2, 5], distance: 40, azimuth: 0.7, elevation: 0.4 };

/** The place in a picture of height 2, as the formulas of perspective give it. */
function project(c: CameraState, p: Vector3): [number, number, number] {
    const { eye, right, up, back } = basis(c);
    const from = add(p, eye, -1);
    const depth = -dot(from, back);
    const scale = 1 / (depth * Math.tan(fieldOfView / 2));
    return [dot(from, right) * scale, dot(from, up) * scale, depth];
}

describe("the camera", () => {
    it("has three perpendicular axes of length 1, also when it looks straight down", () => {
        for (const elevation of [0, 0.4, Math.PI / 2, -Math.PI / 2]) {
            const { right, up, back } = basis({ ...camera, elevation });
            for (const [a, b, expected] of [
                [right, right, 1],
                [up, up, 1],
                [back, back, 1],
                [right, up, 0],
                [up, back, 0],
                [back, right, 0],
            ] as const) {
                expect(dot(a, b)).toBeCloseTo(expected, 14);
            }
        }
    });

    it("seen from above from the south has x to the right and y upwards", () => {
        const { right, up } = basis({ ...camera, azimuth: -Math.PI / 2, elevation: Math.PI / 2 });
        [1, 0, 0].forEach((v, i) => expect(right[i]).toBeCloseTo(v, 14));
        [0, 1, 0].forEach((v, i) => expect(up[i]).toBeCloseTo(v, 14));
    });

    it("does not turn over", () => {
        expect(orbited(camera, 0, 10).elevation).toBe(Math.PI / 2);
        expect(orbited(camera, 0, -10).elevation).toBe(-Math.PI / 2);
        expect(orbited(camera, 1, 0)).toEqual({ ...camera, azimuth: 1.7 });
    });

    it("moves the target by the pixels it is panned", () => {
        const height = 700;
        const [x, y] = project(panned(camera, 70, -35, height), camera.target);
        // The picture has height 2 here: 70 of 700 pixels are 0.2.
        expect(x).toBeCloseTo(0.2, 12);
        expect(y).toBeCloseTo(0.1, 12);
    });

    it("keeps the place under the pointer when it zooms", () => {
        const height = 600;
        const { right, up } = basis(camera);
        const unit = unitsPerPixel(camera, height);
        const under = add(add(camera.target, right, 90 * unit), up, -45 * unit);
        const [x, y] = project(zoomed(camera, 0.5, 90, 45, height), under);
        expect(x).toBeCloseTo(0.3, 12);
        expect(y).toBeCloseTo(-0.15, 12);
        expect(zoomed(camera, 0.5, 90, 45, height).distance).toBe(20);
    });

    it("frames all corners of a box, and not from much farther than needed", () => {
        for (const aspect of [0.5, 1, 2.5]) {
            const c = framed(camera, [0, 0, 0], [10, 4, 1], aspect);
            let widest = 0;
            for (let corner = 0; corner < 8; ++corner) {
                const [x, y, depth] = project(c, [
                    corner & 1 ? 10 : 0,
                    corner & 2 ? 4 : 0,
                    corner & 4 ? 1 : 0,
                ]);
                expect(depth).toBeGreaterThan(0);
                widest = Math.max(widest, Math.abs(x) / aspect, Math.abs(y));
            }
            expect(widest).toBeLessThanOrEqual(1);
            expect(widest).toBeGreaterThan(0.9);
        }
    });
});
