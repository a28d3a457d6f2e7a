// Which part of a large control net is loaded: the one around the place that the camera looks at.

import type { Hello, LevelInfo, Vector3 } from "./protocol";

/** First row, first column, rows, columns. */
export type NetWindow = [row: number, col: number, rows: number, cols: number];

/** The server sends so many points without a window. */
const wholeNet = 65536;
const side = 160;

function placeOn(hello: Hello, level: number, target: Vector3): [row: number, col: number] {
    const [dx, dy] = hello.raster?.spacing ?? [1, 1];
    const step = 2 ** level;
    return [(hello.max[1] - target[1]) / (dy * step), (target[0] - hello.min[0]) / (dx * step)];
}

function around(place: number, size: number): [first: number, length: number] {
    const length = Math.min(side, size);
    return [Math.min(Math.max(0, Math.round(place) - side / 2), size - length), length];
}

/** The window around the camera's target, or null if the net comes whole. */
export function netWindow(
    hello: Hello,
    info: LevelInfo | undefined,
    target: Vector3,
): NetWindow | null {
    if (!info?.rows || !info.cols || info.rows * info.cols <= wholeNet) return null;
    const [row, col] = placeOn(hello, info.level, target);
    const [firstRow, rows] = around(row, info.rows);
    const [firstCol, cols] = around(col, info.cols);
    return [firstRow, firstCol, rows, cols];
}

/**
 * Whether the target has come so near to the window's border that another one would show more
 * around it.
 */
export function windowLeft(
    hello: Hello,
    level: number,
    window: NetWindow,
    target: Vector3,
): boolean {
    const info = hello.levels.find((entry) => entry.level === level);
    const next = netWindow(hello, info, target);
    return (
        next !== null &&
        (Math.abs(next[0] - window[0]) > side / 4 || Math.abs(next[1] - window[1]) > side / 4)
    );
}
