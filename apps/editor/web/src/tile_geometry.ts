// The samples of a tile as vertices and triangles, with skirts that hide cracks between tiles of
// different fineness.

import {
    FrameError,
    headCounts,
    headNumber,
    optionalArray,
    requiredArray,
    type Frame,
} from "./frame";
import type { RasterInfo, TileId } from "./protocol";

export interface Tile {
    id: TileId;
    rows: number;
    cols: number;
    /** x, y, z of the samples row by row, then those of the skirts. */
    position: Float32Array;
    normal: Int16Array;
    /** Error or curvature, if asked for. */
    value: Float32Array | null;
    /** Place of each vertex on the raster's lattice: column, row. */
    lattice: Float32Array;
    valid: Uint8Array | null;
    /** For each vertex of a skirt the sample above it. */
    skirt: Uint32Array;
    /**
     * 0 for vertices of skirts at the raster's own border, where they would be seen from outside;
     * else 1.
     */
    hang: Uint8Array;
    index: Uint16Array | Uint32Array;
}

const maxSide = 4097;

/** Which sides of a tile lie inside the raster and so border on other tiles. */
interface InnerSides {
    top: boolean;
    left: boolean;
    bottom: boolean;
    right: boolean;
}

function innerSides(raster: RasterInfo, [j, r, c]: TileId, rows: number, cols: number): InnerSides {
    const step = 2 ** j;
    return {
        top: r > 0,
        left: c > 0,
        bottom: (r * raster.tile + rows - 1) * step < raster.rows - 1,
        right: (c * raster.tile + cols - 1) * step < raster.cols - 1,
    };
}

/**
 * Samples along the inner sides, one after another; each side begins where its number in `starts`
 * says.
 */
function skirtSamples(
    rows: number,
    cols: number,
    sides: InnerSides,
): { samples: number[]; starts: number[] } {
    const samples: number[] = [];
    const starts: number[] = [];
    const side = (inner: boolean, length: number, sample: (i: number) => number) => {
        if (!inner) return;
        starts.push(samples.length);
        for (let i = 0; i < length; ++i) samples.push(sample(i));
    };
    side(sides.top, cols, (i) => i);
    side(sides.left, rows, (i) => i * cols);
    side(sides.bottom, cols, (i) => (rows - 1) * cols + i);
    side(sides.right, rows, (i) => i * cols + cols - 1);
    return { samples, starts };
}

/** Triangles of samples that are all valid, and of the skirts. */
function triangles(
    rows: number,
    cols: number,
    valid: Uint8Array | null,
    skirt: number[],
    starts: number[],
): number[] {
    const index: number[] = [];
    const add = (a: number, b: number, c: number) => {
        if (!valid || (valid[a] && valid[b] && valid[c])) index.push(a, b, c);
    };
    for (let row = 0; row + 1 < rows; ++row) {
        for (let col = 0; col + 1 < cols; ++col) {
            const a = row * cols + col;
            add(a, a + cols, a + cols + 1);
            add(a, a + cols + 1, a + 1);
        }
    }
    const below = rows * cols;
    for (let i = 0; i + 1 < skirt.length; ++i) {
        const [a, b] = [skirt[i], skirt[i + 1]];
        if (starts.includes(i + 1) || (valid && !(valid[a] && valid[b]))) continue;
        index.push(a, below + i, below + i + 1, a, below + i + 1, b);
    }
    return index;
}

/**
 * A crack beside a tile of half as many samples is as deep as samples lie off the line between
 * their neighbours. Three times this is enough where the neighbour is still coarser or smoother.
 */
function skirtDepth({ position, skirt, cols }: Tile): number {
    const z = (i: number) => position[3 * skirt[i] + 2];
    const step = (i: number) => skirt[i + 1] - skirt[i];
    let depth = 0;
    for (let i = 1; i + 1 < skirt.length; ++i) {
        const alongOneSide = step(i) === step(i - 1) && (step(i) === 1 || step(i) === cols);
        if (alongOneSide) depth = Math.max(depth, Math.abs(z(i) - (z(i - 1) + z(i + 1)) / 2));
    }
    return 3 * depth;
}

/** Copies what the samples say to the skirts below them. */
export function hangSkirts(tile: Tile): void {
    const depth = skirtDepth(tile);
    const below = tile.rows * tile.cols;
    tile.skirt.forEach((sample, i) => {
        const vertex = below + i;
        tile.position.copyWithin(3 * vertex, 3 * sample, 3 * sample + 3);
        tile.position[3 * vertex + 2] -= depth * tile.hang[i];
        tile.normal.copyWithin(4 * vertex, 4 * sample, 4 * sample + 4);
        tile.lattice.copyWithin(2 * vertex, 2 * sample, 2 * sample + 2);
        if (tile.value) tile.value[vertex] = tile.value[sample];
    });
}

function sizeOf(frame: Frame): { rows: number; cols: number } {
    const rows = headNumber(frame, "rows");
    const cols = headNumber(frame, "cols");
    const fits = (side: number) => Number.isInteger(side) && side >= 1 && side <= maxSide;
    if (!fits(rows) || !fits(cols))
        throw new FrameError(`a tile has ${rows} rows and ${cols} columns`);
    return { rows, cols };
}

export function tileIdOf(frame: Frame): TileId {
    return headCounts(frame, "tile", 3) as unknown as TileId;
}

function copied<T extends Float32Array | Int16Array>(target: T, source: T | null): T {
    if (source) target.set(source);
    return target;
}

function onBorder(raster: RasterInfo, col: number, row: number): boolean {
    return col === 0 || row === 0 || col === raster.cols - 1 || row === raster.rows - 1;
}

/** A vertex that has no finite height stands at 0 and is not valid. */
function checkedValid(
    position: Float32Array,
    samples: number,
    valid: Uint8Array | null,
): Uint8Array | null {
    let result = valid;
    for (let i = 0; i < samples; ++i) {
        if (Number.isFinite(position[3 * i] + position[3 * i + 1] + position[3 * i + 2])) continue;
        if (result === valid) result = valid ? valid.slice() : new Uint8Array(samples).fill(1);
        (result as Uint8Array)[i] = 0;
        position.fill(0, 3 * i, 3 * i + 3);
    }
    return result;
}

/**
 * Builds the vertices and triangles of a `tile` message. Throws FrameError. Complexity: O(samples).
 */
export function buildTile(frame: Frame, raster: RasterInfo): Tile {
    const id = tileIdOf(frame);
    const { rows, cols } = sizeOf(frame);
    const samples = rows * cols;
    const valid = optionalArray(frame, "valid", "u8", 1, samples);
    const { samples: skirt, starts } = skirtSamples(rows, cols, innerSides(raster, id, rows, cols));
    const vertices = samples + skirt.length;
    const value =
        optionalArray(frame, "error", "f32", 1, samples) ??
        optionalArray(frame, "curvature", "f32", 1, samples);
    const position = new Float32Array(3 * vertices);
    const lattice = new Float32Array(2 * vertices);
    const step = 2 ** id[0];
    for (let i = 0; i < samples; ++i) {
        lattice[2 * i] = Math.min((id[2] * raster.tile + (i % cols)) * step, raster.cols - 1);
        lattice[2 * i + 1] = Math.min(
            (id[1] * raster.tile + Math.floor(i / cols)) * step,
            raster.rows - 1,
        );
    }
    if (!placePoints(frame, position, rows, cols))
        throw new FrameError("a tile has neither height nor position");
    const shown = checkedValid(position, samples, valid);
    const index = triangles(rows, cols, shown, skirt, starts);
    const tile: Tile = {
        id,
        rows,
        cols,
        position,
        lattice,
        valid: shown,
        normal: copied(
            new Int16Array(4 * vertices),
            requiredArray(frame, "normal", "i16", 4, samples),
        ),
        value: value && copied(new Float32Array(vertices), value),
        skirt: Uint32Array.from(skirt),
        hang: Uint8Array.from(skirt, (sample) =>
            onBorder(raster, lattice[2 * sample], lattice[2 * sample + 1]) ? 0 : 1,
        ),
        index: vertices > 65535 ? Uint32Array.from(index) : Uint16Array.from(index),
    };
    hangSkirts(tile);
    return tile;
}

/**
 * Page coordinates of samples along one side of a tile: in equal steps but for the last, which may
 * be shorter.
 */
function placesAlong(frame: Frame, axis: "x" | "y", count: number): Float64Array {
    const [first, last, step] = [`${axis}0`, `${axis}1`, `d${axis}`].map((name) =>
        headNumber(frame, name),
    );
    return Float64Array.from({ length: count }, (_, i) =>
        i > 0 && i === count - 1 ? last : first + step * i,
    );
}

/** Heights over a lattice, or points of a parametric surface. False if the message has neither. */
function placePoints(frame: Frame, position: Float32Array, rows: number, cols: number): boolean {
    const points = optionalArray(frame, "position", "f32", 3, rows * cols);
    if (points) position.set(points);
    const height = optionalArray(frame, "height", "f32", 1, rows * cols);
    if (points || !height) return points !== null;
    const [x, y] = [placesAlong(frame, "x", cols), placesAlong(frame, "y", rows)];
    height.forEach((z, i) => {
        position[3 * i] = x[i % cols];
        position[3 * i + 1] = y[Math.floor(i / cols)];
        position[3 * i + 2] = z;
    });
    return true;
}

/** Writes the samples of a `patch` message into the tile. Throws FrameError. */
export function patchTile(tile: Tile, frame: Frame): void {
    const [row, col, rows, cols] = headCounts(frame, "rect", 4);
    if (row + rows > tile.rows || col + cols > tile.cols)
        throw new FrameError("a patch reaches beyond its tile");
    const samples = rows * cols;
    const height = optionalArray(frame, "height", "f32", 1, samples);
    const points = optionalArray(frame, "position", "f32", 3, samples);
    const normal = optionalArray(frame, "normal", "i16", 4, samples);
    const value =
        optionalArray(frame, "error", "f32", 1, samples) ??
        optionalArray(frame, "curvature", "f32", 1, samples);
    for (let i = 0; i < samples; ++i) {
        const sample = (row + Math.floor(i / cols)) * tile.cols + col + (i % cols);
        if (height && Number.isFinite(height[i])) tile.position[3 * sample + 2] = height[i];
        const point = points?.subarray(3 * i, 3 * i + 3);
        if (point?.every(Number.isFinite)) tile.position.set(point, 3 * sample);
        if (normal) tile.normal.set(normal.subarray(4 * i, 4 * i + 4), 4 * sample);
        if (value && tile.value) tile.value[sample] = value[i];
    }
    hangSkirts(tile);
}
