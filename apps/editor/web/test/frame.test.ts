import { describe, expect, it } from "vitest";
import {
    checkIndices,
    decodeFrame,
    FrameError,
    headCounts,
    headNumber,
    optionalArray,
    requiredArray,
} from "../src/frame";
import { frameOf, rawFrame } from "./frames";

const sample = () =>
    frameOf(
        { what: "surface", id: 7, revision: 4, level: 0 },
        {
            position: [Float32Array.of(1, 2, 3, 4, 5, 6, 7, 8, 9), 3],
            valid: [Uint8Array.of(1, 0, 1), 1],
            normal: [Int16Array.of(0, 0, 32767, 0, -32767, 0, 0, 0, 1, 2, 3, 0), 4],
            index: [Uint32Array.of(0, 1, 2), 1],
        },
    );

describe("a frame", () => {
    it("gives its head and its arrays", () => {
        const frame = decodeFrame(sample());
        expect(frame.what).toBe("surface");
        expect(frame.id).toBe(7);
        expect(frame.head.revision).toBe(4);
        expect([...requiredArray(frame, "position", "f32", 3)]).toEqual([
            1, 2, 3, 4, 5, 6, 7, 8, 9,
        ]);
        expect([...requiredArray(frame, "valid", "u8", 1)]).toEqual([1, 0, 1]);
        expect([...requiredArray(frame, "normal", "i16", 4)]).toEqual([
            0, 0, 32767, 0, -32767, 0, 0, 0, 1, 2, 3, 0,
        ]);
        expect([...requiredArray(frame, "index", "u32", 1, 3)]).toEqual([0, 1, 2]);
        expect(optionalArray(frame, "error", "f32", 1)).toBeNull();
    });

    it("has arrays that are views of its bytes", () => {
        const buffer = sample();
        expect(requiredArray(decodeFrame(buffer), "position", "f32", 3).buffer).toBe(buffer);
    });

    it("may have no id and empty arrays", () => {
        const frame = decodeFrame(frameOf({ what: "patch" }, { at: [new Uint32Array(), 1] }));
        expect(frame.id).toBeNull();
        expect(requiredArray(frame, "at", "u32", 1).length).toBe(0);
    });
});

describe("a malformed frame", () => {
    it("is refused wherever it is cut", () => {
        const whole = sample();
        // The last array needs 12 of its 16 padded bytes; any shorter message lacks something.
        for (let length = 0; length < whole.byteLength - 4; ++length) {
            expect(() => decodeFrame(whole.slice(0, length)), `cut at ${length}`).toThrow(
                FrameError,
            );
        }
    });

    it("never throws anything but FrameError when bytes are changed", () => {
        const whole = new Uint8Array(sample());
        for (let i = 0; i < whole.length; ++i) {
            for (const bit of [1, 0x80]) {
                const changed = whole.slice();
                changed[i] ^= bit;
                try {
                    decodeFrame(changed.buffer);
                } catch (error) {
                    expect(error).toBeInstanceOf(FrameError);
                }
            }
        }
    });

    const heads: [string, string][] = [
        ["no object", "[1]"],
        ["null", "null"],
        ["no JSON", "{what"],
        ["without what", `{"arrays":[]}`],
        ["without arrays", `{"what":"net"}`],
        [
            "an array of unknown type",
            `{"what":"net","arrays":[{"name":"a","type":"f64","width":1,"count":0}]}`,
        ],
        [
            "a type from the prototype",
            `{"what":"net","arrays":[{"name":"a","type":"constructor","width":1,"count":0}]}`,
        ],
        [
            "a negative count",
            `{"what":"net","arrays":[{"name":"a","type":"u8","width":1,"count":-1}]}`,
        ],
        ["a fraction", `{"what":"net","arrays":[{"name":"a","type":"u8","width":1,"count":0.5}]}`],
        ["a width of 0", `{"what":"net","arrays":[{"name":"a","type":"u8","width":0,"count":1}]}`],
        [
            "a huge count",
            `{"what":"net","arrays":[{"name":"a","type":"f32","width":16,"count":900719925474099}]}`,
        ],
        [
            "two arrays of one name",
            `{"what":"net","arrays":[${Array(2).fill(`{"name":"a","type":"u8","width":1,"count":0}`)}]}`,
        ],
        ["null as an array", `{"what":"net","arrays":[null]}`],
    ];
    it.each(heads)("is refused with %s", (_, head) => {
        expect(() => decodeFrame(rawFrame(head, []))).toThrow(FrameError);
    });

    it("is refused where arrays have another shape than expected", () => {
        const frame = decodeFrame(sample());
        expect(() => requiredArray(frame, "position", "f32", 1)).toThrow("is not f32 of width 1");
        expect(() => requiredArray(frame, "position", "u32", 3)).toThrow("is not u32 of width 3");
        expect(() => requiredArray(frame, "position", "f32", 3, 4)).toThrow(
            "has 3 elements instead of 4",
        );
        expect(() => requiredArray(frame, "height", "f32", 1)).toThrow(
            "surface has no array height",
        );
        expect(() => checkIndices("a triangle", Uint32Array.of(0, 3), 3)).toThrow(
            "a triangle names element 3 of 3",
        );
        expect(() => headCounts(frame, "tile", 3)).toThrow(FrameError);
        expect(() => headNumber(frame, "what")).toThrow(FrameError);
    });
});
