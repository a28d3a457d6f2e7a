// The messages of docs/protocol.md, version 1.

export type Vector3 = [number, number, number];

export type Kind = "raster" | "mesh" | "quads" | "triangles";
export type Shown = "edited" | "original" | "compressed";
export type Extra = "error" | "curvature";
export type Profile = "smooth" | "linear" | "sharp" | "flat";

/** Tile (j, r, c): every 2^j-th sample, in row r and column c of tiles. */
export type TileId = readonly [j: number, r: number, c: number];

export interface LevelInfo {
    level: number;
    control_points: number;
    faces: number;
    bytes: number;
    rows?: number;
    cols?: number;
}

export interface RasterInfo {
    rows: number;
    cols: number;
    tile: number;
    coarsest: number;
    spacing: [number, number];
}

export interface Falloff {
    radius: number;
    profile: Profile;
}

export interface Move {
    do: "move";
    level: number;
    points: number[];
    delta: number | Vector3;
    falloff?: Falloff;
}

export interface Tilt {
    do: "tilt";
    level: number;
    points: number[];
    slope: [number, number];
    falloff?: Falloff;
}

export type Edit = Move | Tilt;

export interface History {
    done: number;
    entries: { text: string }[];
}

export interface Hello {
    event: "hello";
    protocol: number;
    version: string;
    name: string;
    kind: Kind;
    writer: boolean;
    revision: number;
    levels: LevelInfo[];
    scheme: string;
    order: number;
    components: number;
    parametric: boolean;
    origin: Vector3;
    min: Vector3;
    max: Vector3;
    unit: string;
    crs: string;
    bound: number | null;
    bytes: number;
    save: string;
    raster?: RasterInfo;
    history: History;
}

export interface Changed {
    event: "changed";
    revision: number;
    history: History;
    min: Vector3;
    max: Vector3;
    touched: number;
    cause: number;
}

export type ServerEvent =
    | Hello
    | Changed
    | { event: "progress"; id: number; fraction: number }
    | { event: "notice"; message: string }
    | { event: "closing" };

export interface Failure {
    code: string;
    message: string;
    where?: string;
}

export interface Answer {
    id: number;
    ok: boolean;
    error?: Failure;
}

export interface PlaceAnswer extends Answer {
    value: number | number[] | null;
    gradient: [number, number] | null;
    slope: number | null;
    x: number | null;
    y: number | null;
}

export interface CompressAnswer extends Answer {
    bytes: number;
    kept: number;
    coefficients: number;
    max_error: number;
    rms_error: number;
}

export interface ErrorsAnswer extends Answer {
    max_error: number;
    rms_error: number;
    place: Vector3 | null;
}

export interface SaveAnswer extends Answer {
    path: string;
    bytes: number;
}

/**
 * Whether control points move up and down only: their other coordinates are fixed by the lattice or
 * the mesh.
 */
export function movesOnlyUp(hello: Hello): boolean {
    return !hello.parametric && hello.components !== 3;
}

export function tileKey(tile: TileId): string {
    return `${tile[0]}/${tile[1]}/${tile[2]}`;
}

/** "what, where": the words of a failure in one line. */
export function failureText(failure: Failure | undefined): string {
    if (!failure) return "The server gave no reason.";
    return failure.where ? `${failure.message} (${failure.where})` : failure.message;
}
