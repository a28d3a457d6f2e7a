// The page itself: who may see it, bad files, the keyboard alone, help, light and dark, small
// windows.

import assert from "node:assert/strict";
import { request } from "node:http";
import { writeFileSync } from "node:fs";
import { test } from "node:test";
import { Browser, relief, Scratch } from "./driver.mjs";

const browser = new Browser();
const scratch = new Scratch();

function terrain() {
    return scratch.file("hills.tif", (path) => relief("sample", "ridged", path, "--size", 65));
}

function status(url, headers = {}) {
    return new Promise((resolve, reject) => {
        request(url, { headers }, (response) => {
            response.resume();
            resolve(response.statusCode);
        })
            .on("error", reject)
            .end();
    });
}

test("a wrong token and a foreign origin are refused", async () => {
    const allowed = /WebSocket|Failed to load resource/;
    await browser.view(
        [terrain()],
        async (editor) => {
            const { page, url } = editor;
            const wrong = url.replace(/[0-9a-f]{32}/, "0".repeat(32));
            assert.equal(await status(url), 200);
            assert.equal(await status(wrong), 404);
            assert.equal(await status(url, { Origin: "http://example.org" }), 403);
            assert.equal((await page.context().request.get(wrong)).status(), 404);
            const opened = (address) =>
                page.evaluate(
                    (target) =>
                        new Promise((resolve) => {
                            const socket = new WebSocket(target);
                            socket.onopen = () => resolve(true);
                            socket.onerror = () => resolve(false);
                        }),
                    address,
                );
            const socket = (base) => `${base.replace("http", "ws")}socket`;
            assert.equal(await opened(socket(url)), true);
            assert.equal(await opened(socket(wrong)), false);
            // A page of another site, which knows the address, gets nowhere.
            await page.goto("data:text/html,<title>another site</title>");
            assert.equal(await opened(socket(url)), false);
        },
        { allowed },
    );
});

test("a second page watches, and takes over when the first one closes", async () => {
    await browser.view([terrain()], async (editor) => {
        const watcher = await editor.another();
        assert.equal(await watcher.state((e) => e.file.writer), false);
        assert.ok(await watcher.page.getByText("Another page edits this file").isVisible());
        await editor.showNet(3);
        const point = await editor.state((e) => e.counts.netPoints >> 1);
        await editor.select(point);
        await editor.moveBy({ z: 30 });
        await watcher.page.waitForFunction(() => window.editor.state.history.done === 1);
        assert.equal((await watcher.hash()).surface, (await editor.hash()).surface);
    });
});

test("bad files are answered by a message, and what is open stays", async () => {
    const bad = scratch.file("bad.tif", (path) => writeFileSync(path, "no raster at all"));
    const damaged = scratch.file("damaged.relief", (path) =>
        writeFileSync(
            path,
            Buffer.concat([Buffer.from("RELIEF\x89", "latin1"), Buffer.alloc(100)]),
        ),
    );
    await browser.view(
        [terrain()],
        async (editor) => {
            const before = await editor.hash();
            await editor.drop(bad, "bad.tif");
            const [first, ...others] = await editor.messages();
            assert.match(first, /bad\.tif/);
            assert.deepEqual(others, []);
            assert.doesNotMatch(first, /tmp|undefined/);
            await editor.page.getByRole("button", { name: "Dismiss" }).click();
            await editor.drop(damaged, "damaged.relief");
            const [second] = await editor.messages();
            assert.match(second, /damaged\.relief/);
            await editor.screenshot("bad-file");
            await editor.drop(bad, "bad.png", "Drape");
            assert.equal((await editor.messages()).length, 2);
            assert.equal(await editor.state((e) => e.state.drape), "none");
            assert.deepEqual(await editor.hash(), before);
            assert.equal(await editor.state((e) => e.file.name), "hills.tif");
            // A good file takes the messages away.
            await editor.drop(terrain(), "other.tif");
            await editor.page.waitForFunction(() => window.editor.file.name === "other.tif");
            assert.deepEqual(await editor.messages(), []);
        },
        { allowed: /Failed to load resource/ },
    );
});

test("unsaved changes are not lost by opening another file", async () => {
    await browser.view([terrain()], async (editor) => {
        await editor.press("ArrowRight");
        await editor.press("Alt+ArrowUp");
        assert.equal((await editor.history()).done, 1);
        assert.match(await editor.page.title(), /^• hills\.tif/);
        await editor.drop(terrain(), "other.tif");
        await editor.page.getByText("unsaved changes").waitFor();
        await editor.page.keyboard.press("Escape");
        assert.equal(await editor.state((e) => e.file.name), "hills.tif");
        await editor.drop(terrain(), "other.tif");
        await editor.page.getByRole("dialog").getByRole("button", { name: "Open" }).click();
        await editor.page.waitForFunction(() => window.editor.file.name === "other.tif");
        assert.equal((await editor.history()).done, 0);
    });
});

test("everything by keyboard alone", async () => {
    await browser.view([terrain()], async (editor) => {
        const { keyboard } = editor.page;
        const focused = () =>
            editor.page.evaluate(() => {
                const { id, tagName, textContent } = document.activeElement;
                return id || `${tagName} ${textContent}`;
            });
        // Tab reaches every control that is not disabled, and comes back.
        const reached = new Set();
        for (let k = 0; k < 60; ++k) {
            await keyboard.press("Tab");
            reached.add(await focused());
        }
        for (const id of [
            "canvas",
            "theme",
            "level",
            "colouring",
            "exaggeration",
            "net-level",
            "bound",
        ])
            assert.ok(reached.has(id), `${id} is not among ${[...reached].join(", ")}`);
        const before = await editor.hash();
        await editor.press("ArrowUp");
        const [first] = await editor.state((e) => e.selection);
        assert.ok(await editor.state((e) => e.state.net), "selecting shows the net");
        await editor.press("ArrowRight");
        const [second] = await editor.state((e) => e.selection);
        assert.notEqual(second, first);
        await editor.press("ArrowLeft");
        assert.deepEqual(await editor.state((e) => e.selection), [first]);
        await editor.press("g");
        assert.ok((await editor.state((e) => e.selection.length)) > 3);
        await editor.press("Alt+ArrowUp", "Alt+ArrowUp", "Alt+-");
        assert.equal((await editor.history()).done, 3);
        const raised = await editor.hash();
        assert.notEqual(raised.surface, before.surface);
        await editor.press("z", "z", "z");
        assert.equal((await editor.hash()).surface, before.surface);
        await editor.press("Shift+Z", "Shift+Z", "Control+y");
        assert.deepEqual(await editor.hash(), raised);
        await editor.press("Escape");
        assert.deepEqual(await editor.state((e) => e.selection), []);
        await editor.press("PageUp");
        assert.equal(await editor.state((e) => e.level), 1);
        await editor.press("[");
        assert.equal(await editor.state((e) => e.level), 2);
        await editor.press("PageDown", "]");
        assert.equal(await editor.state((e) => e.level), 0);
        assert.equal((await editor.hash()).surface, raised.surface);
        await editor.press("{");
        const netLevel = await editor.state((e) => e.state.netLevel);
        await editor.press("}");
        assert.equal(await editor.state((e) => e.state.netLevel), netLevel - 1);
        await editor.press("a");
        assert.ok((await editor.state((e) => e.selection.length)) > 10);
        const view = await editor.state((e) => e.camera);
        await editor.press("Shift+ArrowLeft", "Control+ArrowUp", "+", "7");
        assert.notDeepEqual(await editor.state((e) => e.camera), view);
        await editor.press("Home", "c", "w", "s", "s");
        assert.equal(await editor.state((e) => e.state.colouring), "slope");
        assert.equal(await editor.state((e) => e.state.wireframe), true);
        // Letters typed into a field stay there.
        await editor.page.focus("#step");
        await keyboard.press("z");
        assert.equal((await editor.history()).done, 3);
        assert.deepEqual(await editor.messages(), []);
    });
});

test("the help lists the keys and closes again", async () => {
    await browser.view([terrain()], async (editor) => {
        await editor.press("?");
        const help = editor.page.getByRole("dialog");
        assert.ok(await help.isVisible());
        for (const text of ["Undo", "Select by a box", "Control net of a coarser level"])
            assert.ok(await help.getByText(text, { exact: true }).isVisible(), text);
        await editor.screenshot("help");
        const box = await help.boundingBox();
        assert.ok(
            box.x >= 0 && box.y >= 0 && box.x + box.width <= 1280 && box.y + box.height <= 720,
        );
        await editor.page.keyboard.press("Escape");
        assert.ok(!(await help.isVisible()));
        await editor.press("F1");
        assert.ok(await help.isVisible());
        await editor.page.getByRole("button", { name: "Close" }).click();
        assert.ok(!(await help.isVisible()));
    });
});

const background = () => getComputedStyle(document.body).backgroundColor;
const brightness = (colour) => Math.max(...colour.match(/\d+/g).slice(0, 3).map(Number));

test("light and dark, by the system or by choice", async () => {
    for (const colorScheme of ["light", "dark"]) {
        await browser.view(
            [terrain()],
            async (editor) => {
                const dark = colorScheme === "dark";
                const level = brightness(await editor.page.evaluate(background));
                assert.ok(dark ? level < 80 : level > 200, `${colorScheme}: ${level}`);
                await editor.screenshot(`theme-${colorScheme}`);
                await editor.press("Shift+T"); // light
                assert.ok(brightness(await editor.page.evaluate(background)) > 200);
                await editor.press("Shift+T"); // dark
                assert.ok(brightness(await editor.page.evaluate(background)) < 80);
                await editor.press("Shift+T"); // as the system says
                assert.equal(brightness(await editor.page.evaluate(background)), level);
            },
            { colorScheme },
        );
    }
});

test("nothing is cut off in small and large windows", async () => {
    for (const viewport of [
        { width: 1280, height: 720 },
        { width: 1920, height: 1080 },
    ]) {
        await browser.view(
            [terrain()],
            async (editor) => {
                await editor.press("ArrowUp", "r");
                const cut = await editor.page.evaluate(() => {
                    const { scrollWidth, scrollHeight, clientWidth, clientHeight } =
                        document.documentElement;
                    const wide = [...document.querySelectorAll(".panel *")].filter(
                        (element) =>
                            element.clientWidth > 1 &&
                            getComputedStyle(element).overflowX !== "visible" &&
                            !["INPUT", "SELECT"].includes(element.tagName) &&
                            element.scrollWidth > element.clientWidth + 1,
                    );
                    const page = scrollWidth > clientWidth || scrollHeight > clientHeight;
                    return [...(page ? ["page"] : []), ...wide.map((element) => element.outerHTML)];
                });
                assert.deepEqual(cut, []);
                const panel = await editor.page.locator(".panel").boundingBox();
                assert.ok(panel.x + panel.width <= viewport.width);
                const canvas = await editor.page.locator("#canvas").boundingBox();
                assert.ok(canvas.width >= 0.6 * viewport.width, "the surface has most of the room");
                await editor.screenshot(`window-${viewport.width}`);
            },
            { viewport },
        );
    }
});
