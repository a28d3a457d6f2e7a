// Binary messages: a head in JSON and typed arrays that lie behind it.

export type NumberArray = Float32Array | Uint32Array | Int16Array | Uint8Array;

export interface FrameArray {
    data: NumberArray;
    width: number;
    count: number;
}

export interface Frame {
    what: string;
    id: number | null;
    head: Record<string, unknown>;
    arrays: Map<string, FrameArray>;
}

/** A binary message that is not what docs/protocol.md says. */
export class FrameError extends Error {}

const magic = 0x464c4552;
const maxWidth = 16;

const arrayTypes = {
    f32: Float32Array,
    u32: Uint32Array,
    i16: Int16Array,
    u8: Uint8Array,
} as const;

function padded(bytes: number): number {
    return Math.ceil(bytes / 8) * 8;
}

function isCount(value: unknown): value is number {
    return Number.isSafeInteger(value) && (value as number) >= 0;
}

function parseHead(buffer: ArrayBuffer): { head: Record<string, unknown>; end: number } {
    if (buffer.byteLength < 8) throw new FrameError(`${buffer.byteLength} bytes are no message`);
    const view = new DataView(buffer);
    if (view.getUint32(0, true) !== magic)
        throw new FrameError("the message does not begin with RELF");
    const end = 8 + view.getUint32(4, true);
    if (end > buffer.byteLength) throw new FrameError("the head is longer than the message");
    if (end % 8 !== 0) throw new FrameError("the head is not padded to a multiple of 8 bytes");
    let head: unknown;
    try {
        head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, end - 8)));
    } catch {
        throw new FrameError("the head is not JSON");
    }
    if (typeof head !== "object" || head === null || Array.isArray(head))
        throw new FrameError("the head is no object");
    return { head: head as Record<string, unknown>, end };
}

/** Reads a message. Its arrays are views of `buffer`, not copies. Throws FrameError. */
export function decodeFrame(buffer: ArrayBuffer): Frame {
    const { head, end } = parseHead(buffer);
    if (typeof head.what !== "string") throw new FrameError("the head does not say what it is");
    if (!Array.isArray(head.arrays)) throw new FrameError("the head lists no arrays");
    const arrays = new Map<string, FrameArray>();
    let offset = end;
    for (const entry of head.arrays as Record<string, unknown>[]) {
        const { name, type, width, count } = entry ?? {};
        if (typeof name !== "string" || arrays.has(name))
            throw new FrameError("an array has no name of its own");
        if (typeof type !== "string" || !Object.hasOwn(arrayTypes, type)) {
            throw new FrameError(`array ${name} is of unknown type ${String(type)}`);
        }
        if (!isCount(width) || width < 1 || width > maxWidth || !isCount(count)) {
            throw new FrameError(
                `array ${name} has width ${String(width)} and count ${String(count)}`,
            );
        }
        const arrayType = arrayTypes[type as keyof typeof arrayTypes];
        const bytes = width * count * arrayType.BYTES_PER_ELEMENT;
        if (bytes > buffer.byteLength - offset)
            throw new FrameError(`array ${name} is longer than the message`);
        arrays.set(name, { data: new arrayType(buffer, offset, width * count), width, count });
        offset += padded(bytes);
    }
    return { what: head.what, id: isCount(head.id) ? head.id : null, head, arrays };
}

type TypeName = keyof typeof arrayTypes;
type ArrayOf<T extends TypeName> = InstanceType<(typeof arrayTypes)[T]>;

/**
 * The array `name` of that type and width, or null if there is none. Throws FrameError if it is of
 * another shape.
 */
export function optionalArray<T extends TypeName>(
    frame: Frame,
    name: string,
    type: T,
    width: number,
    count?: number,
): ArrayOf<T> | null {
    const array = frame.arrays.get(name);
    if (!array) return null;
    if (!(array.data instanceof arrayTypes[type]) || array.width !== width) {
        throw new FrameError(`array ${name} of ${frame.what} is not ${type} of width ${width}`);
    }
    if (count !== undefined && array.count !== count) {
        throw new FrameError(
            `array ${name} of ${frame.what} has ${array.count} elements instead of ${count}`,
        );
    }
    return array.data as ArrayOf<T>;
}

/** As optionalArray, but it must be there. */
export function requiredArray<T extends TypeName>(
    frame: Frame,
    name: string,
    type: T,
    width: number,
    count?: number,
): ArrayOf<T> {
    const array = optionalArray(frame, name, type, width, count);
    if (!array) throw new FrameError(`${frame.what} has no array ${name}`);
    return array;
}

/** Throws FrameError unless all numbers are below `limit`. */
export function checkIndices(what: string, indices: Uint32Array, limit: number): void {
    for (const index of indices) {
        if (index >= limit) throw new FrameError(`${what} names element ${index} of ${limit}`);
    }
}

/** `count` whole numbers from 0 in the head. Throws FrameError. */
export function headCounts(frame: Frame, name: string, count: number): number[] {
    const value = frame.head[name];
    if (!Array.isArray(value) || value.length !== count || !value.every(isCount)) {
        throw new FrameError(`${name} of ${frame.what} is not ${count} whole numbers`);
    }
    return value as number[];
}

/** A finite number in the head. Throws FrameError. */
export function headNumber(frame: Frame, name: string): number {
    const value = frame.head[name];
    if (typeof value !== "number" || !Number.isFinite(value)) {
        throw new FrameError(`${name} of ${frame.what} is not a number`);
    }
    return value;
}
