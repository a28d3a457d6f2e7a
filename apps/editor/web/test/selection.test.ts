import { describe, expect, it } from "vitest";
import { adjacency } from "../src/falloff";
import {
    boxOf,
    grown,
    neighbourTowards,
    placesInBox,
    placeUnder,
    toggled,
    united,
} from "../src/selection";

/**
 * Nine points at the pixels (100, 200, 300) x (100, 200, 300), row by row, at depth 10; number 8
 * behind the camera.
 */
const projected = Float32Array.from({ length: 27 }, (_, i) => {
    const p = Math.floor(i / 3);
    return [100 * (1 + (p % 3)), 100 * (1 + Math.floor(p / 3)), p === 8 ? NaN : 10][i % 3];
});
const net = adjacency(
    9,
    Uint32Array.of(0, 1, 1, 2, 3, 4, 4, 5, 6, 7, 7, 8, 0, 3, 3, 6, 1, 4, 4, 7, 2, 5, 5, 8),
);

describe("a selection", () => {
    it("is changed by making another one", () => {
        const before = new Set([1, 2]);
        expect([...toggled(before, 2)]).toEqual([1]);
        expect([...toggled(before, 3)]).toEqual([1, 2, 3]);
        expect([...united(before, [2, 5])]).toEqual([1, 2, 5]);
        expect([...before]).toEqual([1, 2]);
    });

    it("by a box takes what is inside, and nothing behind the camera", () => {
        expect(boxOf({ x: 5, y: 1 }, { x: 2, y: 7 })).toEqual({
            left: 2,
            top: 1,
            right: 5,
            bottom: 7,
        });
        expect(placesInBox(projected, boxOf({ x: 350, y: 350 }, { x: 150, y: 150 }))).toEqual([
            4, 5, 7,
        ]);
        expect(placesInBox(projected, boxOf({ x: 0, y: 0 }, { x: 99, y: 99 }))).toEqual([]);
    });

    it("grows by the neighbours", () => {
        expect(grown(net, [0])).toEqual([0, 1, 3]);
        expect(grown(net, [0, 8])).toEqual([0, 1, 3, 5, 7, 8]);
        expect(grown(net, [])).toEqual([]);
    });
});

describe("the point under the pointer", () => {
    it("is the nearest within reach", () => {
        expect(placeUnder(projected, { x: 204, y: 197 }, 9)).toBe(4);
        expect(placeUnder(projected, { x: 215, y: 197 }, 9)).toBe(-1);
        expect(placeUnder(projected, { x: 300, y: 300 }, 9)).toBe(-1);
        expect(placeUnder(projected, { x: 290, y: 290 }, Infinity)).toBe(5);
    });

    it("is the front one of several on a pixel, in any order", () => {
        expect(
            placeUnder(Float32Array.of(50, 50, 9, 50, 50, 3, 50, 50, 6), { x: 51, y: 50 }, 9),
        ).toBe(1);
        expect(placeUnder(Float32Array.of(50, 50, 3, 50, 50, 9), { x: 51, y: 50 }, 9)).toBe(0);
    });

    it("may not lie behind what hides it", () => {
        expect(placeUnder(Float32Array.of(50, 50, 9, 55, 50, 3), { x: 50, y: 50 }, 9, 5)).toBe(1);
        expect(placeUnder(Float32Array.of(50, 50, 9), { x: 50, y: 50 }, 9, 5)).toBe(-1);
    });
});

describe("arrow keys", () => {
    it("go to the neighbour in their direction", () => {
        expect(neighbourTowards(net, projected, 4, { x: -1, y: 0 })).toBe(3);
        expect(neighbourTowards(net, projected, 4, { x: 1, y: 0 })).toBe(5);
        expect(neighbourTowards(net, projected, 4, { x: 0, y: -1 })).toBe(1);
        expect(neighbourTowards(net, projected, 4, { x: 0, y: 1 })).toBe(7);
    });

    it("stay where there is none", () => {
        expect(neighbourTowards(net, projected, 0, { x: -1, y: 0 })).toBe(-1);
        expect(neighbourTowards(net, projected, 5, { x: 0, y: 1 })).toBe(-1);
    });
});
