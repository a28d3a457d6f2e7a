import { describe, expect, it } from "vitest";
import {
    colourAt,
    colourTable,
    curvatureMap,
    errorMap,
    fromOklab,
    heightMap,
    parseColour,
    slopeMap,
    toOklab,
    type Rgb,
} from "../src/colour_maps";

const lightness = (rgb: Rgb) => toOklab(rgb)[0];
const distance = (a: Rgb, b: Rgb) => {
    const [p, q] = [toOklab(a), toOklab(b)];
    return Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
};

describe("OKLab", () => {
    it("has white at 1, black at 0 and no colour in greys", () => {
        expect(toOklab([255, 255, 255])[0]).toBeCloseTo(1, 6);
        expect(toOklab([0, 0, 0])).toEqual([0, 0, 0]);
        // The constants of the transform have 10 digits.
        for (const channel of toOklab([128, 128, 128]).slice(1))
            expect(Math.abs(channel)).toBeLessThan(1e-6);
    });

    it("of red is what Ottosson's article gives", () => {
        const [l, a, b] = toOklab([255, 0, 0]);
        expect(l).toBeCloseTo(0.627955, 5);
        expect(a).toBeCloseTo(0.224863, 5);
        expect(b).toBeCloseTo(0.125846, 5);
    });

    it("comes back to the same bytes", () => {
        for (let i = 0; i < 512; ++i) {
            const rgb: Rgb = [(i * 37) % 256, (i * 91) % 256, (i * 53) % 256];
            expect(fromOklab(toOklab(rgb))).toEqual(rgb);
        }
    });
});

describe("colour maps", () => {
    const maps = { heightMap, slopeMap, errorMap, curvatureMap };

    it.each(Object.entries(maps))("%s passes through its stops and ends there", (_, map) => {
        map.stops.forEach((stop, i) =>
            expect(colourAt(map, i / (map.stops.length - 1))).toEqual(parseColour(stop)),
        );
        expect(colourAt(map, -1)).toEqual(parseColour(map.stops[0]));
        expect(colourAt(map, 2)).toEqual(parseColour(map.stops[map.stops.length - 1]));
        const table = colourTable(map, 256);
        expect([...table.subarray(0, 4)]).toEqual([...parseColour(map.stops[0]), 255]);
        expect([...table.subarray(1020)]).toEqual([
            ...parseColour(map.stops[map.stops.length - 1]),
            255,
        ]);
    });

    it("of heights become lighter and of slopes darker, all the way", () => {
        for (let i = 1; i < 64; ++i) {
            expect(lightness(colourAt(heightMap, i / 63))).toBeGreaterThan(
                lightness(colourAt(heightMap, (i - 1) / 63)),
            );
            expect(lightness(colourAt(slopeMap, i / 63))).toBeLessThan(
                lightness(colourAt(slopeMap, (i - 1) / 63)),
            );
        }
    });

    it.each([
        ["heights", heightMap],
        ["slopes", slopeMap],
    ] as const)("of %s have even steps", (_, map) => {
        const steps = map.stops
            .slice(1)
            .map((stop, i) => distance(parseColour(stop), parseColour(map.stops[i])));
        const mean = steps.reduce((a, b) => a + b) / steps.length;
        // Chosen by hand: no step is half as large again as the mean, or much smaller than it.
        for (const step of steps) {
            expect(step / mean).toBeLessThan(1.5);
            expect(step / mean).toBeGreaterThan(0.6);
        }
    });

    it.each([
        ["errors", errorMap],
        ["curvatures", curvatureMap],
    ] as const)("of %s have two equal arms and a light middle", (_, map) => {
        expect(map.diverging).toBe(true);
        for (const t of [0, 0.25]) {
            // A few hundredths of lightness are hardly seen.
            expect(
                Math.abs(lightness(colourAt(map, t)) - lightness(colourAt(map, 1 - t))),
            ).toBeLessThan(0.08);
        }
        const [, a, b] = toOklab(colourAt(map, 0.5));
        expect(lightness(colourAt(map, 0.5))).toBeGreaterThan(0.93);
        expect(Math.hypot(a, b)).toBeLessThan(0.02);
    });
});
