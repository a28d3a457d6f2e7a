// Numbers as people read them.

const thin = "\u2009";
const minus = "\u2212";

/** Whole number with its digits in groups of three. */
export function count(value: number): string {
    return Math.round(value)
        .toString()
        .replace(/\B(?=(\d{3})+$)/g, thin)
        .replace("-", minus);
}

/** A count and its noun: "1 point", "2 points". */
export function counted(value: number, noun: string): string {
    return `${count(value)} ${noun}${value === 1 ? "" : "s"}`;
}

/** Bytes in decimal units. */
export function bytes(value: number): string {
    const units = ["B", "kB", "MB", "GB", "TB"];
    let unit = 0;
    while (value >= 999.5 && unit < units.length - 1) {
        value /= 1000;
        ++unit;
    }
    return `${unit === 0 || value >= 100 ? value.toFixed(0) : value.toPrecision(3)} ${units[unit]}`;
}

/** A number to so many digits, without trailing zeros. */
export function number(value: number, digits = 4): string {
    if (value === 0 || !Number.isFinite(value)) return value === 0 ? "0" : "\u2013";
    const size = Math.abs(value);
    const text =
        size >= 1e7 || size < 1e-4
            ? value.toExponential(digits - 1).replace(/\.?0+e/, "e")
            : plain(value, digits);
    return text.replace(/-/g, minus);
}

function plain(value: number, digits: number): string {
    const whole = Math.floor(Math.log10(Math.abs(value))) + 1;
    const text = value.toFixed(Math.max(0, Math.min(12, digits - whole)));
    return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

/** What a number field holds: as short as it can be, with a plain minus and a point. */
export function field(value: number, digits = 6): string {
    return String(Number(value.toPrecision(digits)));
}

/** A value with its unit, if one is known. */
export function measured(value: number, unit: string, digits = 4): string {
    return unit ? `${number(value, digits)} ${unit}` : number(value, digits);
}

/** A coordinate system by its code or the name in its WKT; nothing if it has none. */
export function crs(text: string): string {
    if (!text.includes("[")) return text;
    const name = /"([^"]*)"/.exec(text)?.[1] ?? "";
    return name === "unnamed" || name === "unknown" ? "" : name;
}

/** 1, 2 or 5 times a power of ten, the first from `value` on. */
export function roundUp(value: number): number {
    if (!(value > 0)) return 1;
    const power = 10 ** Math.floor(Math.log10(value));
    const step = [1, 2, 5, 10].find((factor) => factor * power >= value * (1 - 1e-12)) ?? 10;
    return Number((step * power).toPrecision(1));
}

/** Round numbers in [low, high], at most `most` of them. */
export function ticks(low: number, high: number, most: number): number[] {
    if (!(high > low)) return [low];
    const step = roundUp((high - low) / most);
    const found: number[] = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) {
        found.push(Number((i * step).toPrecision(12)));
    }
    return found;
}
