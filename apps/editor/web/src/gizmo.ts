// Handles at the selection: arrows that move it along an axis, or knobs that tilt control
// triangles.

import * as THREE from "three";
import { dot, unitsPerPixel } from "./camera";
import type { Vector3 } from "./protocol";
import type { Point2 } from "./selection";
import type { Ray, Viewport } from "./viewport";

export type Handle = "x" | "y" | "z" | "free" | "tilt-x" | "tilt-y";

/** Which handles a selection has. */
export type GizmoKind = "up" | "space" | "tilt";

const axes: Record<string, Vector3> = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
const colours: Record<string, number> = { x: 0xd9483b, y: 0x4f9e3a, z: 0x3a78d9 };
const lengthPixels = 84;
const reachPixels = 10;

export const handlesOf: Record<GizmoKind, Handle[]> = {
    up: ["z"],
    space: ["x", "y", "z"],
    tilt: ["tilt-x", "tilt-y"],
};

/** The axis along which a handle stands, and the letter of its colour. */
function axisName(handle: Handle): string {
    return handle.slice(-1);
}

function arrow(handle: Handle): THREE.Group {
    const name = axisName(handle);
    const material = new THREE.MeshBasicMaterial({
        color: colours[name],
        depthTest: false,
        transparent: true,
    });
    const shaft = new THREE.Mesh(
        new THREE.CylinderGeometry(0.016, 0.016, 0.86, 8).translate(0, 0.43, 0),
        material,
    );
    const tip = handle.startsWith("tilt")
        ? new THREE.SphereGeometry(0.075, 16, 12).translate(0, 0.9, 0)
        : new THREE.ConeGeometry(0.065, 0.2, 20).translate(0, 0.92, 0);
    const group = new THREE.Group();
    group.add(shaft, new THREE.Mesh(tip, material));
    for (const child of group.children) child.renderOrder = 10;
    group.quaternion.setFromUnitVectors(
        new THREE.Vector3(0, 1, 0),
        new THREE.Vector3(...axes[name]),
    );
    return group;
}

/** The parameter of the point of the line (point, direction) that is nearest to the ray. */
function alongAxis(point: Vector3, direction: Vector3, ray: Ray): number {
    const between = point.map((p, i) => p - ray.origin[i]) as Vector3;
    const cosine = dot(direction, ray.direction);
    return (cosine * dot(between, ray.direction) - dot(between, direction)) / (1 - cosine * cosine);
}

export class Gizmo {
    readonly object = new THREE.Group();
    private readonly parts = new Map<Handle, THREE.Group>();
    private kind: GizmoKind = "space";
    private place: Vector3 = [0, 0, 0];
    private grabbed: { handle: Handle; at: Vector3; pointer: Point2; value: Vector3 } | null = null;

    constructor(private readonly viewport: Viewport) {
        for (const handle of ["x", "y", "z", "tilt-x", "tilt-y"] as Handle[]) {
            const part = arrow(handle);
            this.parts.set(handle, part);
            this.object.add(part);
        }
        this.object.visible = false;
    }

    get visible(): boolean {
        return this.object.visible;
    }

    get scale(): number {
        const distance = Math.hypot(
            ...this.viewport.ray({ x: 0, y: 0 }).origin.map((o, i) => o - this.scenePlace[i]),
        );
        return (
            lengthPixels *
            unitsPerPixel({ ...this.viewport.camera, distance }, this.viewport.height)
        );
    }

    /** Stands at a place in page coordinates; null hides it. */
    show(place: Vector3 | null, kind: GizmoKind): void {
        this.object.visible = place !== null;
        if (place) this.place = place;
        this.kind = kind;
        for (const [handle, part] of this.parts) part.visible = handlesOf[kind].includes(handle);
        this.viewport.invalidate();
    }

    /** Keeps its size on the screen. */
    prepare(): void {
        if (!this.object.visible) return;
        this.object.position.set(...this.scenePlace);
        this.object.scale.setScalar(this.scale);
    }

    /** The handle under the pointer. */
    handleAt(pointer: Point2): Handle | null {
        if (!this.object.visible) return null;
        let best: Handle | null = null;
        let bestDistance = reachPixels;
        for (const handle of handlesOf[this.kind]) {
            const distance = this.pixelsFrom(handle, pointer);
            if (distance < bestDistance) {
                best = handle;
                bestDistance = distance;
            }
        }
        return best;
    }

    /**
     * Begins to drag by a handle, or freely: along z if points only move up, else in the plane of
     * the picture.
     */
    grab(handle: Handle, pointer: Point2, at: Vector3 = this.place): void {
        const kept = handle === "free" && this.kind === "up" ? "z" : handle;
        this.grabbed = { handle: kept, at: this.viewport.toScene(at), pointer, value: [0, 0, 0] };
    }

    release(): void {
        this.grabbed = null;
    }

    /**
     * How far the grabbed place has come: data units in page coordinates, or slopes in x and y when
     * tilting.
     */
    dragged(pointer: Point2): Vector3 {
        const grabbed = this.grabbed;
        if (!grabbed) return [0, 0, 0];
        const { handle, at } = grabbed;
        if (handle === "free")
            return this.viewport.toPage(
                this.inPlane(at, pointer).map((p, i) => p - at[i]) as Vector3,
            );
        const tilting = handle.startsWith("tilt");
        const axis = tilting ? axes.z : axes[axisName(handle)];
        const moved = this.along(at, axis, pointer) - this.along(at, axis, grabbed.pointer);
        if (!tilting) return this.viewport.toPage(axis.map((a) => a * moved) as Vector3);
        const slope = moved / this.viewport.exaggeration / this.scale;
        return axes[axisName(handle)].map((a) => a * slope) as Vector3;
    }

    private get scenePlace(): Vector3 {
        return this.viewport.toScene(this.place);
    }

    private along(at: Vector3, axis: Vector3, pointer: Point2): number {
        const ray = this.viewport.ray(pointer);
        const middle = this.viewport.ray({
            x: this.viewport.width / 2,
            y: this.viewport.height / 2,
        });
        // Seen along the axis nothing can be aimed at: then the pointer's height counts.
        if (Math.abs(dot(middle.direction, axis)) > 0.97)
            return -pointer.y * unitsPerPixel(this.viewport.camera, this.viewport.height);
        return alongAxis(at, axis, ray);
    }

    private inPlane(at: Vector3, pointer: Point2): Vector3 {
        const facing = this.viewport.ray({
            x: this.viewport.width / 2,
            y: this.viewport.height / 2,
        }).direction;
        const grabbed = this.grabbed as { pointer: Point2 };
        const hit = (where: Point2): Vector3 => {
            const ray = this.viewport.ray(where);
            const t =
                dot(at.map((p, i) => p - ray.origin[i]) as Vector3, facing) /
                dot(ray.direction, facing);
            return ray.origin.map((o, i) => o + t * ray.direction[i]) as Vector3;
        };
        const [now, before] = [hit(pointer), hit(grabbed.pointer)];
        return at.map((p, i) => p + now[i] - before[i]) as Vector3;
    }

    private pixelsFrom(handle: Handle, pointer: Point2): number {
        const axis = axes[axisName(handle)];
        const [from, to] = [
            this.scenePlace,
            this.scenePlace.map((p, i) => p + axis[i] * this.scale) as Vector3,
        ].map((p) => this.viewport.projectPoint(this.viewport.toPage(p)));
        const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        const along =
            ((pointer.x - from[0]) * dx + (pointer.y - from[1]) * dy) / (dx * dx + dy * dy || 1);
        // The root belongs to the point that is selected, not to an arrow.
        if (along < 0.2) return Infinity;
        const t = Math.min(1.05, along);
        return Math.hypot(pointer.x - from[0] - t * dx, pointer.y - from[1] - t * dy);
    }
}
