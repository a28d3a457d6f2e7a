import { describe, expect, it } from "vitest";
import { decodeFrame, FrameError } from "../src/frame";
import type { RasterInfo } from "../src/protocol";
import { buildTile, patchTile } from "../src/tile_geometry";
import { frameOf, type Source } from "./frames";

const raster: RasterInfo = { rows: 9, cols: 9, tile: 4, coarsest: 1, spacing: [10, 10] };

function tileFrame(head: object, height: number[], more: Record<string, [Source, number]> = {}) {
    const normal = new Int16Array(4 * height.length);
    for (let i = 0; i < height.length; ++i) normal[4 * i + 2] = 32767;
    return decodeFrame(
        frameOf(
            {
                what: "tile",
                tile: [0, 0, 0],
                rows: 5,
                cols: 5,
                x0: 100,
                y0: 200,
                x1: 140,
                y1: 160,
                dx: 10,
                dy: -10,
                ...head,
            },
            { height: [Float32Array.from(height), 1], normal: [normal, 4], ...more },
        ),
    );
}

const plane = Array.from({ length: 25 }, (_, i) => (i % 5) + 2 * Math.floor(i / 5));

function point(tile: { position: Float32Array }, vertex: number): number[] {
    return [...tile.position.subarray(3 * vertex, 3 * vertex + 3)];
}

describe("a tile", () => {
    it("has its samples in page coordinates", () => {
        const tile = buildTile(tileFrame({}, plane), raster);
        expect(point(tile, 0)).toEqual([100, 200, 0]);
        expect(point(tile, 7)).toEqual([120, 190, 4]);
        expect(point(tile, 24)).toEqual([140, 160, 12]);
        expect([...tile.lattice.subarray(14, 16)]).toEqual([2, 1]);
    });

    it("has two triangles a cell that look upwards, and skirts towards its neighbours only", () => {
        const tile = buildTile(tileFrame({}, plane), raster);
        // Two inner sides (below and to the right) of 5 samples, so 8 skirt cells.
        expect(tile.skirt.length).toBe(10);
        expect(tile.index.length).toBe(3 * (2 * 16 + 2 * 8));
        for (let t = 0; t < 3 * 32; t += 3) {
            const [a, b, c] = [0, 1, 2].map((i) => point(tile, tile.index[t + i]));
            const area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            expect(area).toBe(100);
        }
    });

    it("has skirts of no depth at straight borders, and of three times the bend elsewhere", () => {
        const flat = buildTile(tileFrame({}, plane), raster);
        flat.skirt.forEach((sample, i) => expect(point(flat, 25 + i)).toEqual(point(flat, sample)));
        const bent = buildTile(
            tileFrame(
                {},
                plane.map((z, i) => (i === 22 ? z + 8 : z)),
            ),
            raster,
        );
        bent.skirt.forEach((sample, i) => {
            // At the raster's own border, samples 4 and 20, skirts end in a point.
            const depth = sample === 4 || sample === 20 ? 0 : 24;
            expect(point(bent, 25 + i)[2]).toBe(point(bent, sample)[2] - depth);
        });
    });

    it("at the end of the raster has no skirts there", () => {
        expect(buildTile(tileFrame({ tile: [0, 1, 1] }, plane), raster).skirt.length).toBe(10);
        expect(buildTile(tileFrame({ tile: [1, 0, 0] }, plane), raster).skirt.length).toBe(0);
    });

    it("ends with the last row and column, however near they are", () => {
        const uneven: RasterInfo = { ...raster, rows: 8, cols: 8 };
        const tile = buildTile(tileFrame({ tile: [1, 0, 0], x1: 135, y1: 165 }, plane), uneven);
        expect(point(tile, 3).slice(0, 2)).toEqual([130, 200]);
        expect(point(tile, 24).slice(0, 2)).toEqual([135, 165]);
        expect([...tile.lattice.subarray(48, 50)]).toEqual([7, 7]);
        expect(tile.skirt.length).toBe(0);
    });

    it("leaves out triangles at samples that are not valid or not finite", () => {
        const valid = new Uint8Array(25).fill(1);
        valid[12] = 0;
        const holed = buildTile(
            tileFrame({ tile: [1, 0, 0] }, plane, { valid: [valid, 1] }),
            raster,
        );
        // Six triangles meet at an inner sample.
        expect(holed.index.length).toBe(3 * (32 - 6));
        expect(holed.index.includes(12)).toBe(false);
        const broken = buildTile(
            tileFrame(
                { tile: [1, 0, 0] },
                plane.map((z, i) => (i === 12 ? NaN : z)),
            ),
            raster,
        );
        expect([...broken.index]).toEqual([...holed.index]);
        expect(broken.position.every(Number.isFinite)).toBe(true);
    });

    it("takes the points of a parametric surface", () => {
        const position = Float32Array.from({ length: 75 }, (_, i) => i);
        const frame = tileFrame({}, plane, { position: [position, 3] });
        expect(point(buildTile(frame, raster), 3)).toEqual([9, 10, 11]);
    });

    it("is refused when its arrays do not fit its size", () => {
        expect(() => buildTile(tileFrame({ rows: 6 }, plane), raster)).toThrow(FrameError);
        expect(() => buildTile(tileFrame({ rows: 0 }, []), raster)).toThrow("a tile has 0 rows");
        expect(() => buildTile(tileFrame({ rows: 1e9, cols: 1e9 }, plane), raster)).toThrow(
            FrameError,
        );
        expect(() => buildTile(tileFrame({ tile: [0, 0] }, plane), raster)).toThrow(FrameError);
        expect(() => buildTile(tileFrame({ dx: null }, plane), raster)).toThrow(FrameError);
    });
});

describe("a patch of a tile", () => {
    const patch = (rect: number[], height: number[]) =>
        decodeFrame(
            frameOf(
                { what: "patch", tile: [0, 0, 0], rect },
                { height: [Float32Array.from(height), 1] },
            ),
        );

    it("replaces the samples of its rectangle and no others", () => {
        const tile = buildTile(tileFrame({}, plane), raster);
        patchTile(tile, patch([1, 2, 2, 2], [50, 51, 52, 53]));
        const expected = plane.slice();
        [
            [7, 50],
            [8, 51],
            [12, 52],
            [13, 53],
        ].forEach(([i, z]) => {
            expected[i] = z;
        });
        expect(plane.map((_, i) => point(tile, i)[2])).toEqual(expected);
    });

    it("is refused when it reaches beyond the tile or lacks samples", () => {
        const tile = buildTile(tileFrame({}, plane), raster);
        expect(() => patchTile(tile, patch([3, 3, 3, 1], [1, 2, 3]))).toThrow("beyond its tile");
        expect(() => patchTile(tile, patch([0, 0, 2, 2], [1, 2, 3]))).toThrow(FrameError);
    });
});
