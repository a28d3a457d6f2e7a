// Perceptually even colour maps: a few colours joined in OKLab, where equal steps look equal.

export type Rgb = [number, number, number];

export interface ColourMap {
    /** From the lowest to the highest value, evenly spaced, as #rrggbb. */
    stops: readonly string[];
    /** Whether the middle colour stands for zero. */
    diverging: boolean;
}

export const heightMap: ColourMap = {
    stops: ["#17335c", "#2b6272", "#5a8a60", "#a39b4c", "#e0ab68", "#fbd9c4"],
    diverging: false,
};

export const slopeMap: ColourMap = {
    stops: ["#fcfdbf", "#fc9f6f", "#de4968", "#8c2981", "#3b0f70", "#0a0722"],
    diverging: false,
};

export const errorMap: ColourMap = {
    stops: ["#1f5fae", "#7fa9d6", "#f2f1ee", "#df9a85", "#b23a2e"],
    diverging: true,
};

export const curvatureMap: ColourMap = {
    stops: ["#5a3d9a", "#a593cf", "#f2f1ee", "#8fbf94", "#1f7a3d"],
    diverging: true,
};

export function parseColour(text: string): Rgb {
    const bits = parseInt(text.slice(1), 16);
    return [(bits >> 16) & 255, (bits >> 8) & 255, bits & 255];
}

function toLinear(byte: number): number {
    const v = byte / 255;
    return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
}

function toByte(linear: number): number {
    const v = Math.min(1, Math.max(0, linear));
    return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
}

/** sRGB bytes to OKLab (Ottosson 2020). */
export function toOklab([red, green, blue]: Rgb): Rgb {
    const r = toLinear(red);
    const g = toLinear(green);
    const b = toLinear(blue);
    const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
    const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
    const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
    return [
        0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s,
        1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
        0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s,
    ];
}

export function fromOklab([lightness, a, b]: Rgb): Rgb {
    const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
    const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
    const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
    return [
        toByte(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
        toByte(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
        toByte(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
    ];
}

/** The colour at t in [0, 1], as sRGB bytes. */
export function colourAt(map: ColourMap, t: number): Rgb {
    const place = Math.min(1, Math.max(0, t)) * (map.stops.length - 1);
    const first = Math.min(Math.floor(place), map.stops.length - 2);
    const low = toOklab(parseColour(map.stops[first]));
    const high = toOklab(parseColour(map.stops[first + 1]));
    const f = place - first;
    return fromOklab([0, 1, 2].map((i) => low[i] + f * (high[i] - low[i])) as Rgb);
}

/** `size` colours as RGBA bytes, from the first to the last. */
export function colourTable(map: ColourMap, size: number): Uint8Array<ArrayBuffer> {
    const table = new Uint8Array(4 * size);
    for (let i = 0; i < size; ++i) table.set([...colourAt(map, i / (size - 1)), 255], 4 * i);
    return table;
}
