import { describe, expect, it } from "vitest";
import { tileKey, type RasterInfo, type TileId } from "../src/protocol";
import { children, chooseTiles, parent, tileCounts } from "../src/tile_choice";

function raster(rows: number, cols: number, tile = 128): RasterInfo {
    let coarsest = 0;
    while (tile * 2 ** coarsest < Math.max(rows, cols) - 1) ++coarsest;
    return { rows, cols, tile, coarsest, spacing: [1, 1] };
}

const everything = { visible: () => true, loaded: () => true };

/** Lattice rows and columns that a tile covers, from its first sample to its last. */
function extent(r: RasterInfo, [j, row, col]: TileId): [number, number, number, number] {
    const side = r.tile * 2 ** j;
    const span = (index: number, size: number) =>
        [index * side, Math.min((index + 1) * side, size - 1)] as const;
    return [...span(row, r.rows), ...span(col, r.cols)];
}

describe("tiles", () => {
    it("are as many as cover the samples", () => {
        expect(tileCounts(raster(4096, 4096), 0)).toEqual({ rows: 32, cols: 32 });
        expect(tileCounts(raster(4096, 4096), 5)).toEqual({ rows: 1, cols: 1 });
        expect(tileCounts(raster(129, 130), 0)).toEqual({ rows: 1, cols: 2 });
        expect(tileCounts(raster(1, 1), 0)).toEqual({ rows: 1, cols: 1 });
    });

    it.each([
        [257, 258],
        [258, 514],
        [513, 515],
        [1000, 77],
        [4096, 4095],
        [130, 5000],
    ])("of %d x %d samples all have a parent that has them as children", (rows, cols) => {
        const r = raster(rows, cols);
        for (let j = 0; j < r.coarsest; ++j) {
            const counts = tileCounts(r, j);
            for (let row = 0; row < counts.rows; ++row) {
                for (let col = 0; col < counts.cols; ++col) {
                    const id: TileId = [j, row, col];
                    expect(children(r, parent(id)).map(tileKey)).toContain(tileKey(id));
                }
            }
        }
    });
});

describe("the choice of tiles", () => {
    const r = raster(1025, 1025);

    it("asks for the coarsest tile first, and draws nothing without it", () => {
        const choice = chooseTiles(
            r,
            { visible: () => true, loaded: () => false, pixels: () => 100 },
            { pixels: 1, tiles: 100 },
        );
        expect(choice).toEqual({ draw: [], want: [[3, 0, 0]] });
    });

    it("draws the coarsest tile alone when it is fine enough", () => {
        const choice = chooseTiles(
            r,
            { ...everything, pixels: ([j]) => 2 ** j / 4 },
            { pixels: 2, tiles: 100 },
        );
        expect(choice).toEqual({ draw: [[3, 0, 0]], want: [] });
    });

    it("draws a tile until all its children are there", () => {
        const loaded = new Set(["3/0/0", "2/0/0", "2/0/1", "2/1/0"]);
        const view = {
            visible: () => true,
            loaded: (id: TileId) => loaded.has(tileKey(id)),
            pixels: ([j]: TileId) => 2 ** j,
        };
        expect(chooseTiles(r, view, { pixels: 4, tiles: 100 })).toEqual({
            draw: [[3, 0, 0]],
            want: [[2, 1, 1]],
        });
        loaded.add("2/1/1");
        const choice = chooseTiles(r, view, { pixels: 4, tiles: 100 });
        expect(choice.draw.map(tileKey).sort()).toEqual(["2/0/0", "2/0/1", "2/1/0", "2/1/1"]);
        expect(choice.want).toEqual([]);
    });

    it("asks for those tiles first that are coarsest on the screen", () => {
        const view = {
            visible: () => true,
            loaded: (id: TileId) => id[0] === 3,
            pixels: ([j, row, col]: TileId) =>
                2 ** j * (row === 1 && col === 0 ? 10 : 1 + row + col),
        };
        expect(chooseTiles(r, view, { pixels: 1, tiles: 100 }).want.map(tileKey)).toEqual([
            "2/1/0",
            "2/1/1",
            "2/0/1",
            "2/0/0",
        ]);
    });

    it("leaves out what is not visible, and does not wait for it", () => {
        const view = {
            visible: ([, row]: TileId) => row === 0,
            loaded: ([, row]: TileId) => row === 0,
            pixels: ([j]: TileId) => 2 ** j,
        };
        expect(chooseTiles(r, view, { pixels: 4, tiles: 100 }).draw.map(tileKey).sort()).toEqual([
            "2/0/0",
            "2/0/1",
        ]);
    });

    it("keeps to the largest number of tiles, and refines where it matters most", () => {
        const near = ([j, row, col]: TileId) => (2 ** j * 100) / (1 + 2 ** j * (row + col));
        for (const [tiles, first] of [
            [1, "3/0/0"],
            [3, "3/0/0"],
            [4, "2/0/0"],
            [7, "1/0/0"],
            [20, "0/0/0"],
        ] as const) {
            const { draw } = chooseTiles(r, { ...everything, pixels: near }, { pixels: 1, tiles });
            expect(draw.length).toBeLessThanOrEqual(tiles);
            expect(draw.map(tileKey)).toContain(first);
        }
    });

    it.each([
        [1025, 1025],
        [258, 514],
        [700, 300],
        [4096, 129],
    ])("covers all of %d x %d samples once", (rows, cols) => {
        const whole = raster(rows, cols);
        const pixels = ([j, row, col]: TileId) => (2 ** j * 8) / (1 + row + 2 * col);
        const { draw } = chooseTiles(whole, { ...everything, pixels }, { pixels: 1, tiles: 1000 });
        const covered = new Uint8Array((rows - 1) * (cols - 1));
        for (const id of draw) {
            const [top, bottom, left, right] = extent(whole, id);
            for (let row = top; row < bottom; ++row) {
                for (let col = left; col < right; ++col) ++covered[row * (cols - 1) + col];
            }
        }
        expect(covered.every((times) => times === 1)).toBe(true);
    });
});
