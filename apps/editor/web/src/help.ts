// The overlay that lists all keys.

import { button, el } from "./dom";
import { shortcutGroups } from "./shortcuts";

const symbols: Record<string, string> = {
    Left: "\u2190",
    Right: "\u2192",
    Up: "\u2191",
    Down: "\u2193",
    Escape: "Esc",
};

const mouse: readonly [string, string][] = [
    ["Drag", "Orbit; drag a point or an arrow to move the selection"],
    ["Right or Shift drag", "Pan"],
    ["Wheel", "Zoom; while dragging points: radius of the falloff"],
    ["Click, Shift click", "Select a point, add or remove one"],
    ["Ctrl while dragging", "Move by whole steps"],
    ["Double click", "Look at this place"],
];

function keyCaps(keys: string): HTMLElement {
    const caps = el("span", { class: "caps" });
    for (const part of keys.split(/(?<=[^+])\+/)) caps.append(el("kbd", {}, symbols[part] ?? part));
    return caps;
}

function group(title: string, rows: readonly [Node, string][]): HTMLElement {
    const list = el("dl", {});
    for (const [keys, label] of rows) list.append(el("dt", {}, keys), el("dd", {}, label));
    return el("section", {}, el("h3", {}, title), list);
}

export class Help {
    readonly element = el("dialog", { class: "help", "aria-labelledby": "help-title" });

    constructor() {
        const groups = shortcutGroups.map(({ title, shortcuts }) =>
            group(
                title,
                shortcuts.map(({ keys, label }) => {
                    const caps = el("span", { class: "keys" }, ...keys.map(keyCaps));
                    return [caps, label] as [Node, string];
                }),
            ),
        );
        const pointer = group(
            "Pointer",
            mouse.map(([keys, label]) => [el("span", { class: "keys" }, keys), label]),
        );
        const head = el(
            "header",
            {},
            el("h2", { id: "help-title" }, "Keyboard and pointer"),
            button("\u00d7", () => this.element.close(), { class: "quiet", "aria-label": "Close" }),
        );
        this.element.append(head, el("div", { class: "columns" }, ...groups, pointer));
        this.element.addEventListener("click", (event) => {
            if (event.target === this.element) this.element.close();
        });
    }

    toggle(): void {
        if (this.element.open) this.element.close();
        else this.element.showModal();
    }
}
