// Builds binary messages as docs/protocol.md describes them.

export type Source = Float32Array | Uint32Array | Int16Array | Uint8Array;

function typeOf(data: Source): string {
    if (data instanceof Float32Array) return "f32";
    if (data instanceof Uint32Array) return "u32";
    return data instanceof Int16Array ? "i16" : "u8";
}

export function frameOf(
    head: object,
    arrays: Record<string, [data: Source, width: number]>,
): ArrayBuffer {
    const list = Object.entries(arrays).map(([name, [data, width]]) => ({
        name,
        type: typeOf(data),
        width,
        count: data.length / width,
    }));
    return rawFrame(
        JSON.stringify({ ...head, arrays: list }),
        Object.values(arrays).map(([data]) => data),
    );
}

export function rawFrame(head: string, arrays: Source[]): ArrayBuffer {
    const padded = (bytes: number) => Math.ceil(bytes / 8) * 8;
    const text = new TextEncoder().encode(head.padEnd(padded(8 + head.length) - 8));
    const total = arrays.reduce((sum, data) => sum + padded(data.byteLength), 8 + text.length);
    const bytes = new Uint8Array(total);
    const view = new DataView(bytes.buffer);
    view.setUint32(0, 0x464c4552, true);
    view.setUint32(4, text.length, true);
    bytes.set(text, 8);
    let offset = 8 + text.length;
    for (const data of arrays) {
        bytes.set(new Uint8Array(data.buffer, data.byteOffset, data.byteLength), offset);
        offset += padded(data.byteLength);
    }
    return bytes.buffer;
}
