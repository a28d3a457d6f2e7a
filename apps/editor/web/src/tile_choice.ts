// Which tiles of a terrain to draw and which to ask for.

import { tileKey, type RasterInfo, type TileId } from "./protocol";

export interface TileView {
    /** Pixels between two samples of the tile at its nearest point. */
    pixels(tile: TileId): number;
    visible(tile: TileId): boolean;
    loaded(tile: TileId): boolean;
}

export interface TileLimits {
    /** Tiles whose samples are farther apart on the screen are replaced by finer ones. */
    pixels: number;
    /** At most so many tiles are drawn. */
    tiles: number;
}

export interface TileChoice {
    draw: TileId[];
    /** To be loaded, most needed first. */
    want: TileId[];
}

/** Rows and columns of tiles at j. */
export function tileCounts(raster: RasterInfo, j: number): { rows: number; cols: number } {
    const along = (samples: number) =>
        Math.max(1, Math.ceil((samples - 1) / (raster.tile * 2 ** j)));
    return { rows: along(raster.rows), cols: along(raster.cols) };
}

/** The tiles one step finer that cover the same samples. */
export function children(raster: RasterInfo, [j, r, c]: TileId): TileId[] {
    if (j === 0) return [];
    const { rows, cols } = tileCounts(raster, j - 1);
    const found: TileId[] = [];
    for (let row = 2 * r; row < Math.min(2 * r + 2, rows); ++row) {
        for (let col = 2 * c; col < Math.min(2 * c + 2, cols); ++col) found.push([j - 1, row, col]);
    }
    return found;
}

export function parent([j, r, c]: TileId): TileId {
    return [j + 1, r >> 1, c >> 1];
}

/**
 * Splits the tile with the coarsest samples on the screen until all are fine enough or there are
 * too many. A tile is drawn until all its visible children are loaded, so there are never holes.
 */
export function chooseTiles(raster: RasterInfo, view: TileView, limits: TileLimits): TileChoice {
    const root: TileId = [raster.coarsest, 0, 0];
    if (!view.loaded(root)) return { draw: [], want: [root] };
    const want: { tile: TileId; pixels: number }[] = [];
    const draw: TileId[] = [];
    const open = [{ tile: root, pixels: view.pixels(root) }];
    while (open.length > 0) {
        open.sort((a, b) => a.pixels - b.pixels);
        const { tile, pixels } = open.pop() as { tile: TileId; pixels: number };
        const finer = children(raster, tile).filter((child) => view.visible(child));
        const full = draw.length + open.length + finer.length > limits.tiles;
        if (pixels <= limits.pixels || finer.length === 0 || full) {
            draw.push(tile);
            continue;
        }
        const missing = finer.filter((child) => !view.loaded(child));
        if (missing.length > 0) {
            draw.push(tile);
            want.push(...missing.map((child) => ({ tile: child, pixels: view.pixels(child) })));
        } else {
            open.push(...finer.map((child) => ({ tile: child, pixels: view.pixels(child) })));
        }
    }
    want.sort((a, b) => b.pixels - a.pixels || (tileKey(a.tile) < tileKey(b.tile) ? -1 : 1));
    return { draw, want: want.map(({ tile }) => tile) };
}
