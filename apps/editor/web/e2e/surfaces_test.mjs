// The other kinds of surfaces in the page: meshes, splines over quads and triangles, surfaces in
// space.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { test } from "node:test";
import { Browser, relief, Scratch } from "./driver.mjs";
import { readGlb, readObj, readPly, readRaster } from "./read_back.mjs";

const browser = new Browser();
const scratch = new Scratch();

/** An icosahedron that was subdivided three times: 642 vertices, 4 levels. */
function icosahedron() {
    const base = scratch.file("icosahedron.obj", (path) => relief("sample", "icosahedron", path));
    return scratch.file("ball.obj", (path) =>
        relief("subdivide", base, path, "--scheme", "loop", "--levels", 3),
    );
}

/** Heights over 16 x 16 parallelograms. */
function quads() {
    const side = 17;
    const lines = [];
    for (let r = 0; r < side; ++r)
        for (let c = 0; c < side; ++c)
            lines.push(`v ${c + r / 4} ${r} ${Math.sin(c / 4) * Math.cos(r / 5)}`);
    for (let r = 0; r + 1 < side; ++r)
        for (let c = 0; c + 1 < side; ++c) {
            const v = r * side + c + 1;
            lines.push(`f ${v} ${v + 1} ${v + side + 1} ${v + side}`);
        }
    return scratch.file("slanted.obj", (path) => writeFileSync(path, lines.join("\n") + "\n"));
}

/** Franke's function by least squares on triangles, refined once. */
function triangles() {
    const points = scratch.file("franke.csv", (path) =>
        relief("sample", "franke", path, "--size", 33),
    );
    return scratch.file("franke.relief", (path) =>
        relief("fit", points, path, "--vertices", 60, "--levels", 1),
    );
}

/** A torus as a grid of points: a raster of x, y and z. */
function torus() {
    return scratch.file("torus.tif", (path) => relief("sample", "torus", path, "--size", 65));
}

/** Undo and redo give back what was there, and what is saved is what the command line makes. */
async function checkEdits(editor, encoded, before) {
    const edited = await editor.hash();
    assert.notEqual(edited.surface, before.surface);
    const { done, texts } = await editor.history();
    assert.equal(done, texts.length);
    for (let k = 0; k < done; ++k) await editor.press("Control+z");
    assert.deepEqual(await editor.hash(), before);
    for (let k = 0; k < done; ++k) await editor.press("Control+y");
    assert.deepEqual(await editor.hash(), edited);
    const script = await editor.exported("script");
    const replayed = `${script.path}.relief`;
    relief("edit", encoded, replayed, "--script", script.path);
    const exported = await editor.exported("relief");
    assert.ok(readFileSync(exported.path).equals(readFileSync(replayed)));
    return replayed;
}

test("a mesh: levels, a dragged point with falloff, exports", async () => {
    const encoded = scratch.path("ball.relief");
    relief("encode", icosahedron(), encoded);
    await browser.view([encoded], async (editor) => {
        assert.equal(await editor.state((e) => e.kind), "mesh");
        const levels = await editor.state((e) =>
            e.file.levels.map((level) => level.control_points),
        );
        assert.deepEqual(levels, [642, 162, 42, 12]);
        await editor.showNet(2);
        const before = await editor.hash();
        // A point that looks at the viewer.
        const point = await editor.state((e) => {
            const places = [...Array(42).keys()].map((p) => ({ p, ...e.pixelOf(p) }));
            const off = ({ x, y }) => Math.hypot(x - innerWidth / 3, y - innerHeight / 2);
            return places.sort((a, b) => off(a) - off(b))[0].p;
        });
        await editor.select(point);
        const [selected] = await editor.state((e) => e.selection);
        await editor.page.getByLabel("Falloff").check();
        await editor.drag(selected, 40, -40);
        await editor.screenshot("mesh-dragged");
        await editor.moveBy({ x: 0.05, y: 0, z: 0.1 });
        assert.equal((await editor.history()).done, 2);
        const edited = await checkEdits(editor, encoded, before);

        const decoded = scratch.path("ball-1.obj");
        relief("decode", edited, decoded, "--level", 1);
        const expected = readObj(decoded);
        await editor.showLevel(1);
        for (const [format, read] of [
            ["obj", readObj],
            ["ply", readPly],
            ["glb", readGlb],
        ]) {
            const mesh = read((await editor.exported(format)).path);
            assert.equal(mesh.faces, expected.faces, format);
            assert.equal(mesh.vertices.length, expected.vertices.length, format);
            mesh.vertices.forEach((vertex, v) =>
                vertex.forEach((x, axis) =>
                    // 32-bit floats of numbers around 1.
                    assert.ok(
                        Math.abs(x - expected.vertices[v][axis]) <= 2 ** -22,
                        `${format} ${v}`,
                    ),
                ),
            );
        }
        for (const colouring of ["slope", "curvature", "error"]) await editor.colourBy(colouring);
        await editor.screenshot("mesh-error");
        assert.deepEqual(await editor.messages(), []);
    });
});

test("a spline over quads: levels, points that move up", async () => {
    const encoded = scratch.path("slanted.relief");
    relief("encode", quads(), encoded);
    await browser.view([encoded], async (editor) => {
        assert.equal(await editor.state((e) => e.kind), "quads");
        const levels = await editor.state((e) => e.file.levels.length);
        assert.ok(levels >= 3, levels);
        const fine = await editor.hash();
        await editor.showLevel(1);
        assert.notEqual((await editor.hash()).surface, fine.surface);
        await editor.showLevel(0);
        await editor.showNet(levels - 2);
        const before = await editor.hash();
        const point = await editor.state((e) => e.counts.netPoints >> 1);
        await editor.select(point);
        const [selected] = await editor.state((e) => e.selection);
        await editor.drag(selected, 0, -50);
        await checkEdits(editor, encoded, before);
        await editor.colourBy("curvature");
        await editor.screenshot("quads-dragged");
        assert.deepEqual(await editor.messages(), []);
    });
});

test("a Powell-Sabin spline: control triangles are raised and tilted", async () => {
    await browser.view([triangles()], async (editor) => {
        assert.equal(await editor.state((e) => e.kind), "triangles");
        assert.equal(await editor.state((e) => e.file.levels.length), 2);
        await editor.showNet(1);
        const before = await editor.hash();
        const point = await editor.state((e) => {
            const names = [...Array(e.counts.netPoints).keys()];
            const off = ({ x, y }) => Math.hypot(x - innerWidth / 3, y - innerHeight / 2);
            return names.sort((a, b) => off(e.pixelOf(a)) - off(e.pixelOf(b)))[0];
        });
        await editor.select(point);
        const [selected] = await editor.state((e) => e.selection);
        await editor.drag(selected, 0, -40);
        const raised = await editor.hash();
        assert.notEqual(raised.surface, before.surface);
        await editor.press("t");
        await editor.fill("step", 0.5);
        await editor.press("Alt+ArrowRight");
        assert.notEqual((await editor.hash()).surface, raised.surface);
        assert.equal((await editor.history()).done, 2);
        await editor.screenshot("triangles-tilted");
        await checkEdits(editor, triangles(), before);
        assert.deepEqual(await editor.messages(), []);
    });
});

test("points are interpolated when they are opened", async () => {
    const points = scratch.file("few.csv", (path) => relief("sample", "franke", path, "--size", 9));
    await browser.view([points], async (editor) => {
        assert.equal(await editor.state((e) => e.kind), "triangles");
        assert.equal(await editor.state((e) => e.file.levels[0].control_points), 81);
    });
});

test("a grid of points in space: edited at levels 1 and 2 with its control mesh", async () => {
    const encoded = scratch.path("torus.relief");
    relief("encode", torus(), encoded, "--profile", "fast");
    await browser.view([encoded], async (editor) => {
        assert.deepEqual(
            await editor.state((e) => [e.kind, e.file.parametric, e.file.components]),
            ["raster", true, 3],
        );
        await editor.showNet(1);
        const fine = await editor.hash();
        for (const level of [1, 2]) {
            await editor.showLevel(level);
            await editor.showNet(level);
            const { rows, cols } = await editor.state((e, l) => e.file.levels[l], level);
            assert.equal(await editor.state((e) => e.counts.netPoints), rows * cols);
            const before = await editor.hash();
            const point = await editor.state((e) => {
                const names = [...Array(e.counts.netPoints).keys()];
                const depth = (name) => e.pixelOf(name).y;
                return names.sort((a, b) => depth(b) - depth(a))[0];
            });
            await editor.select(point);
            const [selected] = await editor.state((e) => e.selection);
            await editor.drag(selected, -30, 40);
            assert.notEqual((await editor.hash()).surface, before.surface);
            assert.notEqual((await editor.hash()).net, before.net);
            await editor.screenshot(`torus-level-${level}`);
        }
        await editor.showLevel(0);
        await editor.showNet(1);
        const edited = await checkEdits(editor, encoded, fine);
        const decoded = `${edited}.tif`;
        relief("decode", edited, decoded);
        const tif = await editor.exported("tif");
        for (const band of [1, 2, 3])
            assert.deepEqual(readRaster(tif.path, band), readRaster(decoded, band));
        const mesh = readObj((await editor.exported("obj")).path);
        const x = readRaster(decoded, 1);
        assert.equal(mesh.vertices.length, x.length);
        mesh.vertices.forEach((vertex, v) => assert.ok(Math.abs(vertex[0] - x[v]) <= 1e-5));
        assert.deepEqual(await editor.messages(), []);
    });
});
