// Takes the pictures of docs/editor.md: run by tools/make_screenshots, which names a terrain (DEM).

import { spawnSync } from "node:child_process";
import { test } from "node:test";
import { Browser, relief, Scratch } from "./driver.mjs";

const browser = new Browser();
const scratch = new Scratch();
const terrain = process.env.DEM;

/** The control point that is drawn nearest to a place of the viewport, in parts of its sides. */
function pointNear(editor, across, down) {
    return editor.state(
        (e, [right, below]) => {
            const { clientWidth, clientHeight } = document.getElementById("canvas");
            const off = (name) => {
                const { x, y } = e.pixelOf(name);
                return Math.hypot(x - right * clientWidth, y - below * clientHeight);
            };
            const names = [...Array(e.counts.netPoints).keys()];
            return names.reduce((best, name) => (off(name) < off(best) ? name : best));
        },
        [across, down],
    );
}

/** Nothing is hovered over in a picture. */
async function take(editor, name) {
    await editor.page.mouse.move(1, 1);
    await editor.page.evaluate(() => document.activeElement.blur());
    await editor.page.waitForTimeout(300);
    await editor.screenshot(name);
}

test("slopes", () =>
    browser.view([terrain], async (editor) => {
        await editor.colourBy("slope");
        await take(editor, "editor-slope");
    }));

test("drape", () =>
    browser.view([terrain], async (editor) => {
        const image = scratch.file("image.png", (path) =>
            relief("render", terrain, path, "--style", "colour", "--width", 800),
        );
        await editor.page.locator("#drape-file").setInputFiles(image);
        await editor.page.waitForFunction(() => window.editor.state.drape === "shown");
        await take(editor, "editor-drape");
    }));

test("mesh", async () => {
    const base = scratch.file("torus.obj", (path) => relief("sample", "torus", path, "--size", 8));
    const fine = scratch.path("ring.obj");
    relief("subdivide", base, fine, "--scheme", "catmull-clark", "--levels", 4);
    const file = scratch.path("ring.relief");
    relief("encode", fine, file);
    await browser.view([file], async (editor) => {
        await editor.showNet(4);
        await editor.select(await pointNear(editor, 0.458, 0.7));
        await editor.moveBy({ x: 0, y: 0, z: 2 });
        await take(editor, "editor-mesh");
    });
});

test("control triangles", async () => {
    const points = scratch.file("franke.csv", (path) =>
        relief("sample", "franke", path, "--size", 33),
    );
    const file = scratch.path("franke.relief");
    relief("fit", points, file, "--vertices", 40, "--levels", 1);
    await browser.view([file], async (editor) => {
        await editor.showNet(1);
        await editor.press("t");
        await editor.select(await pointNear(editor, 0.5, 0.5));
        await take(editor, "editor-triangles");
    });
});

test("errors", () =>
    browser.view([terrain], async (editor) => {
        await editor.fill("bound", 100);
        await editor.page.waitForFunction(() => window.editor.state.compressed !== null);
        await editor.colourBy("error");
        await editor.page.locator("#bound-slider").scrollIntoViewIfNeeded();
        await take(editor, "editor-errors");
    }));

test("dark", () =>
    browser.view(
        [terrain],
        async (editor) => {
            await editor.showNet(5);
            await editor.select(await pointNear(editor, 0.45, 0.5));
            await take(editor, "editor-dark");
        },
        { colorScheme: "dark" },
    ));

test("bases", async () => {
    const flat = scratch.path("flat.tif");
    const size = ["-outsize", 65, 65, "-a_ullr", 0, 65, 65, 0].map(String);
    spawnSync("gdal_create", ["-q", "-ot", "Float32", "-burn", "0", ...size, flat]);
    for (const order of [1, 2]) {
        const file = scratch.path(`order-${order}.relief`);
        relief("encode", flat, file, "--scheme", "box", "--order", order, "--levels", 4);
        await browser.view([file], async (editor) => {
            await editor.showNet(3);
            const { rows, cols } = await editor.state((e) => e.file.levels[3]);
            const middle = (rows >> 1) * cols + (cols >> 1);
            await editor.select(middle);
            await editor.moveBy({ z: 8 });
            await editor.colourBy("slope");
            await editor.press(...Array(4).fill("Shift+ArrowDown"));
            await take(editor, `bases-${order}`);
        });
    }
});
