// What terrain and meshes have in common: a surface that is shown in the scene.

import type * as THREE from "three";
import type { Frame } from "./frame";

export interface Shape {
    readonly object: THREE.Object3D;
    readonly triangles: number;
    /** Takes a frame that belongs to the shape; false if it does not. Throws FrameError. */
    take(frame: Frame): boolean;
    /** Asks for the geometry anew: another level or another surface is shown. */
    refresh(): void;
    /** Called before each picture. */
    prepare(): void;
    setEdges(visible: boolean, colour: number): void;
    setFaces(visible: boolean): void;
    /** Largest |value| of the loaded vertices, for scales. */
    largestValue(): number;
    /** Hash of the positions shown. */
    hash(): string;
    dispose(): void;
}

/** FNV-1a over the bytes of arrays, in order, as 8 hexadecimal digits. */
export function hashArrays(arrays: Iterable<ArrayBufferView>): string {
    let hash = 0x811c9dc5;
    for (const array of arrays) {
        for (const byte of new Uint8Array(array.buffer, array.byteOffset, array.byteLength)) {
            hash = Math.imul(hash ^ byte, 0x01000193);
        }
    }
    return (hash >>> 0).toString(16).padStart(8, "0");
}

/** A large |value| that a few outliers do not set: the 99th percentile of those that are finite. */
export function typicalLargest(values: Iterable<ArrayLike<number>>): number {
    const sizes: number[] = [];
    for (const array of values) {
        const step = Math.max(1, Math.floor(array.length / 4096));
        for (let i = 0; i < array.length; i += step) {
            if (Number.isFinite(array[i])) sizes.push(Math.abs(array[i]));
        }
    }
    sizes.sort((a, b) => a - b);
    return sizes.length > 0 ? sizes[Math.floor(0.99 * (sizes.length - 1))] : 0;
}
