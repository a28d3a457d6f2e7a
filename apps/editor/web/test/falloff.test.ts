import { describe, expect, it } from "vitest";
import { adjacency, distances, falloffWeights, profileWeight } from "../src/falloff";

/** A row of points at x = 0, 1, 3, 6, 10, .. joined one to the next. */
const triangular = Float32Array.from({ length: 30 }, (_, i) =>
    i % 3 === 0 ? ((i / 3) * (i / 3 + 1)) / 2 : 0,
);
const chain = Uint32Array.from({ length: 18 }, (_, i) => (i >> 1) + (i % 2));

describe("profiles", () => {
    it("are those of the protocol", () => {
        // d / r = 1/2 and 1/4, where all are exact in binary.
        expect(profileWeight("smooth", 1, 2)).toBe(0.5625);
        expect(profileWeight("linear", 1, 2)).toBe(0.5);
        expect(profileWeight("sharp", 1, 2)).toBe(0.25);
        expect(profileWeight("flat", 1, 2)).toBe(1);
        expect(profileWeight("smooth", 1, 4)).toBe(0.87890625);
        expect(profileWeight("sharp", 1, 4)).toBe(0.5625);
    });

    it.each(["smooth", "linear", "sharp", "flat"] as const)(
        "%s is 1 at the point and 0 from the radius on",
        (profile) => {
            expect(profileWeight(profile, 0, 0)).toBe(1);
            expect(profileWeight(profile, 0, 5)).toBe(1);
            expect(profileWeight(profile, 5, 5)).toBe(0);
            expect(profileWeight(profile, Infinity, 5)).toBe(0);
        },
    );
});

describe("distances along the net", () => {
    const net = adjacency(10, chain);

    it("add up along the edges", () => {
        expect([...distances(triangular, net, [0], 100, "edges")]).toEqual([
            0, 1, 3, 6, 10, 15, 21, 28, 36, 45,
        ]);
        expect([...distances(triangular, net, [4], 8, "edges")]).toEqual([
            Infinity,
            Infinity,
            7,
            4,
            0,
            5,
            Infinity,
            Infinity,
            Infinity,
            Infinity,
        ]);
    });

    it("are those from the nearest of several points", () => {
        expect([...distances(triangular, net, [1, 8], 100, "edges")]).toEqual([
            1, 0, 2, 5, 9, 14, 15, 8, 0, 9,
        ]);
    });

    it("go around what is not joined", () => {
        // A horseshoe: the ends are 1 apart, but 5 along the edges.
        const horseshoe = Float32Array.of(0, 0, 0, 0, 2, 0, 1, 2, 0, 1, 0, 0);
        expect(
            distances(
                horseshoe,
                adjacency(4, Uint32Array.of(0, 1, 1, 2, 2, 3)),
                [0],
                100,
                "edges",
            )[3],
        ).toBe(5);
    });

    it("are the shortest ones on a lattice", () => {
        const side = 20;
        const position = Float32Array.from({ length: 3 * side * side }, (_, i) => {
            const point = Math.floor(i / 3);
            return [point % side, Math.floor(point / side), 0][i % 3];
        });
        const line: number[] = [];
        for (let p = 0; p < side * side; ++p) {
            if (p % side < side - 1) line.push(p, p + 1);
            if (p + side < side * side) line.push(p, p + side);
        }
        const found = distances(
            position,
            adjacency(side * side, Uint32Array.from(line)),
            [63, 287],
            1000,
            "edges",
        );
        const city = (p: number, q: number) =>
            Math.abs((p % side) - (q % side)) +
            Math.abs(Math.floor(p / side) - Math.floor(q / side));
        expect([...found]).toEqual(
            Array.from({ length: side * side }, (_, p) => Math.min(city(p, 63), city(p, 287))),
        );
    });

    it("are straight in the plane where they are asked for so", () => {
        const zigzag = Float32Array.of(0, 0, 9, 3, 4, -2, 0, 8, 5, 3, 12, 1);
        const path = adjacency(4, Uint32Array.of(0, 1, 1, 2, 2, 3));
        expect([...distances(zigzag, path, [0], 9, "plane")]).toEqual([0, 5, 8, Infinity]);
        expect([...distances(zigzag, path, [0, 3], 9, "plane")]).toEqual([0, 5, 5, 0]);
    });

    it("give weights", () => {
        const weights = falloffWeights(triangular, net, [0], 6, "linear", "edges");
        expect([...weights]).toEqual([1, 5 / 6, 0.5, 0, 0, 0, 0, 0, 0, 0].map(Math.fround));
    });

    it("take no point without neighbours for a neighbour", () => {
        expect([
            ...distances(new Float32Array(9), adjacency(3, new Uint32Array()), [1], 5, "edges"),
        ]).toEqual([Infinity, 0, Infinity]);
    });
});
