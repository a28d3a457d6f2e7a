// Drives the real page in Chromium against the real server.
//
// The environment names the program (RELIEF), a folder with playwright-core installed
// (EDITOR_PACKAGES), where pictures are kept (EDITOR_SCREENSHOTS), and optionally the browser
// (CHROMIUM). A test program that lacks one of them says so and exits with 77: skipped.

import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { after, before } from "node:test";

const { RELIEF, EDITOR_PACKAGES, EDITOR_SCREENSHOTS } = process.env;
const chromiumPath = process.env.CHROMIUM ?? "/usr/bin/chromium";

function skip(reason) {
    console.log(`skipped: ${reason}`);
    process.exit(77);
}

function loadPlaywright() {
    const folder = EDITOR_PACKAGES ?? "";
    if (!existsSync(join(folder, "node_modules/playwright-core")))
        skip(`playwright-core is not in ${folder || "EDITOR_PACKAGES"}: npm ci installs it`);
    return createRequire(join(folder, "package.json"))("playwright-core");
}

if (!RELIEF || !existsSync(RELIEF)) skip("RELIEF does not name the program");
if (!existsSync(chromiumPath)) skip(`there is no ${chromiumPath}: run tools/setup`);
const { chromium } = loadPlaywright();

/** Runs the program and returns what it printed; throws with its message if it fails. */
export function relief(...words) {
    const done = spawnSync(RELIEF, words.map(String), { encoding: "utf8" });
    if (done.status !== 0) throw new Error(`relief ${words.join(" ")}: ${done.stderr}`);
    return done.stdout;
}

/** The one JSON object that a run prints. */
export function reliefJson(...words) {
    return JSON.parse(relief(...words, "--json"));
}

/** A folder for the files of a test program; it is removed at the end. */
export class Scratch {
    constructor() {
        this.folder = mkdtempSync(join(tmpdir(), "relief-page-"));
        after(() => rmSync(this.folder, { recursive: true, force: true }));
    }

    path(name) {
        return join(this.folder, name);
    }

    /** Makes a file with `make(path)`, once. */
    file(name, make) {
        const path = this.path(name);
        if (!existsSync(path)) make(path);
        return path;
    }
}

/** A running `relief view`. */
class Server {
    constructor(words) {
        this.process = spawn(RELIEF, ["view", ...words.map(String), "--no-browser", "--json"], {
            stdio: ["ignore", "pipe", "inherit"],
        });
    }

    async url() {
        for await (const line of createInterface({ input: this.process.stdout }))
            return JSON.parse(line).url;
        throw new Error("relief view ended before it served a page");
    }

    stop() {
        this.process.kill("SIGKILL");
    }
}

/** An opened editor. Members of `window.editor` are read with `state`. */
export class Editor {
    constructor(page, url) {
        this.page = page;
        this.url = url;
    }

    /** A second page of the same server. */
    async another() {
        const context = await this.page.context().browser().newContext();
        const page = await context.newPage();
        await page.goto(this.url);
        const editor = new Editor(page, this.url);
        await editor.idle();
        return editor;
    }

    /** Everything is answered and drawn. */
    idle() {
        return this.page.evaluate(() => window.editor.idle());
    }

    /** `read(window.editor)`, evaluated in the page once it is idle. */
    async state(read, argument) {
        await this.idle();
        return this.page.evaluate(`(${read})(window.editor, ${JSON.stringify(argument)})`);
    }

    async hash() {
        return this.state((editor) => editor.hash);
    }

    async history() {
        return this.state((editor) => ({
            done: editor.state.history.done,
            texts: editor.state.history.entries.map((entry) => entry.text),
        }));
    }

    /** Presses keys that belong to the viewport, as somebody would who has the focus there. */
    async press(...keys) {
        await this.page.focus("#canvas");
        for (const key of keys) await this.page.keyboard.press(key);
        await this.idle();
    }

    /** Shows a level with the slider, which goes from the coarsest to 0. */
    async showLevel(level) {
        const coarsest = await this.state((editor) => editor.file.levels.length - 1);
        await this.page.locator("#level").fill(String(coarsest - level));
        await this.idle();
    }

    async showNet(level) {
        await this.page.selectOption("#net-level", String(level));
        const shown = this.page.getByLabel("Control net", { exact: true });
        if (!(await shown.isChecked())) await shown.check();
        await this.idle();
    }

    /** Clicks on a control point. */
    async select(point) {
        const { x, y } = await this.pixelOf(point);
        await this.page.mouse.click(x, y);
        await this.idle();
    }

    /** Where control point `name` stands, in pixels of the page. */
    async pixelOf(name) {
        const pixel = await this.state((editor, point) => editor.pixelOf(point), name);
        if (!pixel) throw new Error(`control point ${name} is not loaded`);
        const box = await this.page.locator("#canvas").boundingBox();
        return { x: box.x + pixel.x, y: box.y + pixel.y };
    }

    /** Drags a control point by so many pixels, in a few moves. */
    async drag(point, dx, dy) {
        const { x, y } = await this.pixelOf(point);
        await this.page.mouse.move(x, y);
        await this.page.mouse.down();
        for (let k = 1; k <= 5; ++k) await this.page.mouse.move(x + (k * dx) / 5, y + (k * dy) / 5);
        await this.idle();
        await this.page.mouse.up();
        await this.idle();
    }

    /** Fills a number field and confirms it. */
    async fill(id, value) {
        await this.page.fill(`#${id}`, String(value));
        await this.page.keyboard.press("Tab");
        await this.idle();
    }

    /** Moves what is selected by the fields. */
    async moveBy(delta) {
        for (const [axis, value] of Object.entries(delta)) await this.fill(`delta-${axis}`, value);
        await this.page.click("#apply");
        await this.idle();
    }

    async colourBy(name) {
        await this.page.selectOption("#colouring", name);
        await this.idle();
    }

    /** The path of a file that the page gives to the browser when `act` is done. */
    async downloaded(act) {
        const [download] = await Promise.all([this.page.waitForEvent("download"), act()]);
        return { path: await download.path(), name: download.suggestedFilename() };
    }

    async exported(format) {
        await this.page.selectOption("#export-format", format);
        return this.downloaded(() => this.page.getByRole("button", { name: "Export" }).click());
    }

    async save() {
        await this.page.getByRole("button", { name: "Save", exact: true }).click();
        await this.idle();
    }

    /** Drops a file on one of the two zones, as a drag from the desktop does. */
    async drop(path, name, zone = "Open") {
        const bytes = readFileSync(path).toString("base64");
        await this.page.evaluate(
            ([data, fileName, title]) => {
                const content = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
                const transfer = new DataTransfer();
                transfer.items.add(new File([content], fileName));
                const options = { bubbles: true, cancelable: true, dataTransfer: transfer };
                document.body.dispatchEvent(new DragEvent("dragover", options));
                const target = [...document.querySelectorAll(".zone")].find(
                    (element) => element.querySelector("strong").textContent === title,
                );
                target.dispatchEvent(new DragEvent("drop", options));
            },
            [bytes, name, zone],
        );
        await this.idle();
    }

    messages() {
        return this.state((editor) => editor.messages);
    }

    async screenshot(name) {
        if (!EDITOR_SCREENSHOTS) return;
        await this.idle();
        await this.page.screenshot({ path: join(EDITOR_SCREENSHOTS, `${name}.png`) });
    }
}

/** The browser of a test program: started before its tests, ended after them. */
export class Browser {
    constructor() {
        if (EDITOR_SCREENSHOTS) mkdirSync(EDITOR_SCREENSHOTS, { recursive: true });
        before(async () => {
            this.browser = await chromium.launch({
                executablePath: chromiumPath,
                args: [
                    "--headless=new",
                    "--no-sandbox",
                    "--use-angle=swiftshader",
                    "--enable-unsafe-swiftshader",
                    "--disable-background-networking",
                ],
            });
        });
        after(() => this.browser?.close());
    }

    /**
     * Serves a file and calls `work(editor)` with its page. Fails if the page complained of
     * anything on its console, or threw.
     */
    async view(words, work, options = {}) {
        const server = new Server(words);
        const complaints = [];
        try {
            const url = await server.url();
            const context = await this.browser.newContext({
                viewport: { width: 1280, height: 720 },
                ...options,
            });
            const page = await context.newPage();
            page.setDefaultTimeout(120_000); // other tests may have the machine
            page.on("pageerror", (error) => complaints.push(String(error)));
            page.on("console", (message) => {
                if (message.type() === "error") complaints.push(message.text());
            });
            await page.goto(url);
            const editor = new Editor(page, url);
            await editor.idle();
            await work(editor);
            await context.close();
        } finally {
            server.stop();
        }
        const unexpected = complaints.filter((text) => !(options.allowed ?? /^$/).test(text));
        if (unexpected.length > 0) throw new Error(`the page complained: ${unexpected.join("\n")}`);
    }
}
