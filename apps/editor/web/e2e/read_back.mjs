// Reads exported files back, as other programs would: enough of each format for what is written.

import { spawnSync } from "node:child_process";
import { readFileSync } from "node:fs";

/** The vertices of an OBJ and how many faces it has. */
export function readObj(path) {
    const lines = readFileSync(path, "utf8").split("\n");
    const vertices = lines
        .filter((line) => line.startsWith("v "))
        .map((line) => line.trim().split(/\s+/).slice(1, 4).map(Number));
    return { vertices, faces: lines.filter((line) => line.startsWith("f ")).length };
}

const plySizes = { float: 4, float32: 4, double: 8, float64: 8 };

/** The vertices of a PLY whose vertices are numbers, and how many faces it has. */
export function readPly(path) {
    const bytes = readFileSync(path);
    const end = bytes.indexOf("end_header\n") + "end_header\n".length;
    const header = bytes.toString("latin1", 0, end).split("\n");
    const count = (name) =>
        Number(header.find((line) => line.startsWith(`element ${name} `)).split(" ")[2]);
    const first = header.findIndex((line) => line.startsWith("element vertex"));
    const types = [];
    for (let k = first + 1; header[k].startsWith("property"); ++k)
        types.push(header[k].split(" ")[1]);
    if (!header.includes("format binary_little_endian 1.0")) throw new Error("not a binary PLY");
    const stride = types.reduce((sum, type) => sum + plySizes[type], 0);
    const number = (type, at) =>
        plySizes[type] === 8 ? bytes.readDoubleLE(at) : bytes.readFloatLE(at);
    const vertices = Array.from({ length: count("vertex") }, (_, v) =>
        [0, 1, 2].map((axis) => {
            const before = types.slice(0, axis).reduce((sum, type) => sum + plySizes[type], 0);
            return number(types[axis], end + v * stride + before);
        }),
    );
    return { vertices, faces: count("face") };
}

/** A place turned by a quaternion x, y, z, w: p + 2 q x (q x p + w p). */
function turned(p, [x, y, z, w]) {
    const cross = (a, b) => [0, 1, 2].map((k) => a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
    const q = [x, y, z];
    const inner = cross(q, p).map((value, k) => value + w * p[k]);
    return cross(q, inner).map((value, k) => p[k] + 2 * value);
}

/** The positions of the first mesh of a GLB, moved by its node, and how many triangles it has. */
export function readGlb(path) {
    const bytes = readFileSync(path);
    if (bytes.toString("latin1", 0, 4) !== "glTF" || bytes.readUInt32LE(8) !== bytes.length)
        throw new Error("not a GLB");
    const length = bytes.readUInt32LE(12);
    const gltf = JSON.parse(bytes.toString("utf8", 20, 20 + length));
    const data = bytes.subarray(20 + length + 8);
    const primitive = gltf.meshes[0].primitives[0];
    const accessor = gltf.accessors[primitive.attributes.POSITION];
    const at = (gltf.bufferViews[accessor.bufferView].byteOffset ?? 0) + (accessor.byteOffset ?? 0);
    const node = gltf.nodes.find((candidate) => candidate.mesh === 0);
    const { rotation = [0, 0, 0, 1], translation = [0, 0, 0] } = node;
    const vertices = Array.from({ length: accessor.count }, (_, v) => {
        const place = [0, 1, 2].map((axis) => data.readFloatLE(at + 12 * v + 4 * axis));
        return turned(place, rotation).map((value, axis) => value + translation[axis]);
    });
    return { vertices, faces: gltf.accessors[primitive.indices].count / 3 };
}

/** The samples of a raster, row by row, through GDAL. */
export function readRaster(path, band = 1) {
    const done = spawnSync(
        "gdal_translate",
        ["-q", "-b", band, "-of", "XYZ", path, "/vsistdout/"],
        {
            encoding: "utf8",
            maxBuffer: 1 << 28,
        },
    );
    if (done.status !== 0) throw new Error(done.stderr);
    return done.stdout
        .trim()
        .split("\n")
        .map((line) => Number(line.split(" ")[2]));
}
