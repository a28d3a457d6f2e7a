// A height field in the page: levels, editing, errors, files, images.

import assert from "node:assert/strict";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { test } from "node:test";
import { Browser, relief, reliefJson, Scratch } from "./driver.mjs";
import { readGlb, readObj, readPly, readRaster } from "./read_back.mjs";

const browser = new Browser();
const scratch = new Scratch();
const side = 129;

/** A copy of the terrain, so that what tests save beside it is theirs. */
function terrain(name) {
    const original = scratch.file("ridged.tif", (path) =>
        relief("sample", "ridged", path, "--size", side),
    );
    return scratch.file(name, (path) => writeFileSync(path, readFileSync(original)));
}

/** The control point in the middle of a level. */
function middle(editor, level) {
    return editor.state((e, l) => {
        const { rows, cols } = e.file.levels[l];
        return (rows >> 1) * cols + (cols >> 1);
    }, level);
}

test("levels down and up again give the same picture", async () => {
    await browser.view([terrain("levels.tif")], async (editor) => {
        const before = await editor.hash();
        const levels = await editor.state((e) => e.file.levels.length);
        assert.ok(levels >= 4);
        await editor.showLevel(3);
        const coarse = await editor.hash();
        assert.notEqual(coarse.surface, before.surface);
        await editor.screenshot("terrain-level-3");
        await editor.showLevel(0);
        assert.deepEqual(await editor.hash(), before);
        // Scenes that are computed without a graphics card stay small.
        assert.ok((await editor.state((e) => e.counts.triangles)) <= 50000);
    });
});

test("a dragged point moves, and undo and redo give back every bit", async () => {
    await browser.view([terrain("drag.tif")], async (editor) => {
        await editor.showNet(3);
        const before = await editor.hash();
        const point = await middle(editor, 3);
        await editor.select(point);
        assert.deepEqual(await editor.state((e) => e.selection), [point]);
        await editor.drag(point, 0, -60);
        const moved = await editor.hash();
        assert.notEqual(moved.surface, before.surface);
        assert.notEqual(moved.net, before.net);
        assert.deepEqual(await editor.history(), { done: 1, texts: ["move 1 point of level 3"] });
        await editor.screenshot("terrain-dragged");
        await editor.press("Control+z");
        assert.deepEqual(await editor.hash(), before);
        await editor.press("Control+Shift+z");
        assert.deepEqual(await editor.hash(), moved);
        // Escape takes a drag back that has not ended.
        const { x, y } = await editor.pixelOf(point);
        await editor.page.mouse.move(x, y);
        await editor.page.mouse.down();
        await editor.page.mouse.move(x, y + 80, { steps: 4 });
        await editor.idle();
        assert.notEqual((await editor.hash()).surface, moved.surface);
        await editor.page.keyboard.press("Escape");
        await editor.page.mouse.up();
        assert.deepEqual(await editor.hash(), moved);
        assert.equal((await editor.history()).done, 1);
        // The list of commands goes to any of them.
        await editor.page.locator("#history button").first().click();
        assert.deepEqual(await editor.hash(), before);
        await editor.page.locator("#history button").last().click();
        assert.deepEqual(await editor.hash(), moved);
    });
});

test("what is saved is what the command line makes of the script", async () => {
    const dem = terrain("saved.tif");
    await browser.view([dem], async (editor) => {
        await editor.showNet(3);
        const point = await middle(editor, 3);
        await editor.select(point);
        await editor.page.getByLabel("Falloff").check();
        await editor.moveBy({ z: 40 });
        await editor.press("Alt+ArrowUp");
        await editor.showNet(2);
        await editor.select(await middle(editor, 2));
        await editor.moveBy({ z: -25.5 });
        const edited = await editor.hash();
        await editor.save();
        const saved = scratch.path("saved-edited.relief");
        assert.deepEqual(await editor.messages(), [`Saved ${saved}.`]);

        const script = await editor.exported("script");
        const plain = scratch.path("plain.relief");
        const replayed = scratch.path("replayed.relief");
        relief("encode", dem, plain, "--profile", "fast");
        relief("edit", plain, replayed, "--script", script.path);
        assert.ok(readFileSync(replayed).equals(readFileSync(saved)));

        // Opened again, it looks the same.
        await editor.page.locator("#open-file").setInputFiles(saved);
        await editor.page.waitForFunction(() => window.editor.file.name === "saved-edited.relief");
        await editor.showNet(2);
        assert.deepEqual(await editor.hash(), edited);
        assert.equal((await editor.history()).done, 0);
    });
});

test("a bound shows what compression costs, and errors have a scale", async () => {
    const dem = terrain("bound.tif");
    await browser.view([dem], async (editor) => {
        const before = await editor.hash();
        await editor.fill("bound", 2.5);
        await editor.page.waitForFunction(() => window.editor.state.compressed !== null);
        const report = await editor.state((e) => e.state.compressed);
        assert.ok(report.max_error <= 2.5 && report.max_error > 0.5, report.max_error);
        assert.equal(await editor.state((e) => e.state.shown), "compressed");
        assert.notEqual((await editor.hash()).surface, before.surface);
        const expected = scratch.path("bound.relief");
        const encoded = reliefJson(
            "encode",
            dem,
            expected,
            "--profile",
            "fast",
            "--max-error",
            2.5,
        );
        assert.equal(report.bytes, encoded.bytes);
        assert.equal(report.kept, encoded.kept);
        const exported = await editor.exported("relief");
        assert.ok(readFileSync(exported.path).equals(readFileSync(expected)));

        await editor.colourBy("error");
        const errors = await editor.state((e) => e.state.errors);
        assert.equal(errors.max_error, report.max_error);
        const legend = await editor.page.locator(".legend").isVisible();
        assert.ok(legend);
        await editor.screenshot("terrain-errors");
        await editor.page.getByRole("button", { name: "Go there" }).click();
        await editor.idle();
        // Another bound gives other numbers.
        await editor.fill("bound", 10);
        await editor.page.waitForFunction(
            (bytes) => (window.editor.state.compressed?.bytes ?? bytes) < bytes,
            report.bytes,
        );
        const label = editor.page.locator("label", { hasText: "Edited" });
        await label.click();
        assert.deepEqual(await editor.hash(), before);
    });
});

test("exports hold the level that is shown", async () => {
    const dem = terrain("exports.tif");
    const encoded = scratch.path("exports.relief");
    relief("encode", dem, encoded, "--profile", "fast");
    const decoded = scratch.path("exports-1.tif");
    relief("decode", encoded, decoded, "--level", 1);
    const heights = readRaster(decoded);
    const sideOfLevel = (side + 1) / 2;
    assert.equal(heights.length, sideOfLevel ** 2);
    await browser.view([dem], async (editor) => {
        await editor.showLevel(1);
        const tif = await editor.exported("tif");
        assert.equal(tif.name, "exports.tif");
        assert.deepEqual(readRaster(tif.path), heights);
        // Heights are z, but in GLB, where y is up.
        for (const [format, read, quads, up] of [
            ["obj", readObj, 1, 2],
            ["ply", readPly, 1, 2],
            ["glb", readGlb, 2, 1],
        ]) {
            const mesh = read((await editor.exported(format)).path);
            assert.equal(mesh.faces, quads * (sideOfLevel - 1) ** 2, format);
            const largest = Math.max(...heights.map(Math.abs));
            mesh.vertices.forEach((vertex, k) =>
                // 32-bit floats.
                assert.ok(Math.abs(vertex[up] - heights[k]) <= 2 ** -22 * largest, `${format} ${k}`),
            );
        }
        assert.deepEqual(await editor.messages(), []);
    });
});

/** A PNG of a picture that the program itself draws. */
function picture() {
    return scratch.file("drape.png", (path) =>
        relief("render", terrain("drawn.tif"), path, "--width", 200),
    );
}

test("an image is laid over terrain, and what is seen is saved", async () => {
    await browser.view([terrain("drape.tif")], async (editor) => {
        const pixels = async () => (await editor.page.screenshot()).toString("base64");
        const bare = await pixels();
        await editor.page.locator("#drape-file").setInputFiles(picture());
        await editor.page.waitForFunction(() => window.editor.state.drape === "shown");
        await editor.screenshot("terrain-draped");
        const draped = await pixels();
        assert.notEqual(draped, bare);
        assert.ok(
            !(await editor.page.locator(".legend").isVisible()),
            "no legend of hidden colours",
        );
        await editor.press("i");
        assert.equal(await editor.state((e) => e.state.drape), "hidden");
        await editor.press("i");
        const saved = await editor.downloaded(() => editor.press("p"));
        assert.equal(saved.name, "drape.png");
        const png = readFileSync(saved.path);
        assert.equal(png.toString("latin1", 1, 4), "PNG");
        const canvas = await editor.page.locator("#canvas").boundingBox();
        assert.deepEqual(
            [png.readUInt32BE(16), png.readUInt32BE(20)],
            [canvas.width, canvas.height],
        );
        // Dropped on the other zone, the image is opened in place of the terrain.
        await editor.drop(picture(), "drape.png", "Drape");
        await editor.page.waitForFunction(() => window.editor.state.drape === "shown");
        assert.equal(await editor.state((e) => e.file.name), "drape.tif");
    });
});

test("nothing is written until it is asked for", () => {
    assert.ok(!existsSync(scratch.path("levels-edited.relief")));
    assert.ok(!existsSync(scratch.path("drag-edited.relief")));
});
