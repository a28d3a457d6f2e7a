import { describe, expect, it } from "vitest";
import * as format from "../src/format";

describe("numbers", () => {
    it("are grouped, rounded and signed as people write them", () => {
        expect(format.count(16777216)).toBe("16\u2009777\u2009216");
        expect(format.count(-1234)).toBe("\u22121\u2009234");
        expect(format.count(999)).toBe("999");
        expect(format.counted(1, "point")).toBe("1 point");
        expect(format.counted(0, "point")).toBe("0 points");
        expect(format.number(0)).toBe("0");
        expect(format.number(1250)).toBe("1250");
        expect(format.number(-0.25)).toBe("\u22120.25");
        expect(format.number(3.14159)).toBe("3.142");
        expect(format.number(100)).toBe("100");
        expect(format.number(123456.789)).toBe("123457");
        expect(format.number(0.00001)).toBe("1e\u22125");
        expect(format.number(NaN)).toBe("\u2013");
        expect(format.measured(2.5, "m")).toBe("2.5 m");
        expect(format.measured(2.5, "")).toBe("2.5");
        expect(format.field(0.1 + 0.2)).toBe("0.3");
        expect(format.field(-12000)).toBe("-12000");
    });

    it("name coordinate systems", () => {
        expect(format.crs("EPSG:32611")).toBe("EPSG:32611");
        expect(format.crs("")).toBe("");
        expect(format.crs('PROJCRS["NAD83 / UTM zone 11N",BASEGEOGCRS["NAD83"]]')).toBe(
            "NAD83 / UTM zone 11N",
        );
        expect(format.crs('ENGCRS["unnamed",EDATUM[""],CS[Cartesian,2]]')).toBe("");
    });

    it("of bytes have three digits", () => {
        expect(format.bytes(0)).toBe("0 B");
        expect(format.bytes(999)).toBe("999 B");
        expect(format.bytes(1000)).toBe("1.00 kB");
        expect(format.bytes(70113)).toBe("70.1 kB");
        expect(format.bytes(999600)).toBe("1.00 MB");
        expect(format.bytes(4.1e9)).toBe("4.10 GB");
    });
});

describe("scales", () => {
    it("round up to 1, 2 or 5 times a power of ten", () => {
        const pairs = [
            [1, 1],
            [1.01, 2],
            [2.5, 5],
            [7, 10],
            [87.3, 100],
            [0.031, 0.05],
            [0.1, 0.1],
            [1e-9, 1e-9],
            [0, 1],
            [NaN, 1],
        ];
        for (const [value, rounded] of pairs) expect(format.roundUp(value)).toBe(rounded);
    });

    it("have round ticks inside their range", () => {
        expect(format.ticks(0, 60, 5)).toEqual([0, 20, 40, 60]);
        expect(format.ticks(350, 2100, 5)).toEqual([500, 1000, 1500, 2000]);
        expect(format.ticks(-0.05, 0.05, 5)).toEqual(
            [-0.04, -0.02, 0, 0.02, 0.04].map((t) => t || 0),
        );
        expect(format.ticks(3, 3, 5)).toEqual([3]);
    });
});
