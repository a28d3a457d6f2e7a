import { describe, expect, it, vi } from "vitest";
import manual from "../../../../docs/editor.md?raw";
import { Help } from "../src/help";
import {
    actionOf,
    belongsToControl,
    keyName,
    shortcutGroups,
    shortcutsMarkdown,
    type KeyPress,
} from "../src/shortcuts";

function press(key: string, modifiers = ""): KeyPress {
    return {
        key,
        ctrlKey: modifiers.includes("c"),
        metaKey: modifiers.includes("m"),
        shiftKey: modifiers.includes("s"),
        altKey: modifiers.includes("a"),
    };
}

const all = shortcutGroups.flatMap((group) => group.shortcuts);

/** As much of a document as the overlay needs: elements that collect the text of their children. */
class Stub {
    readonly children: (Stub | string)[] = [];
    constructor(readonly tag: string) {}
    append(...nodes: (Stub | string)[]) {
        this.children.push(...nodes);
    }
    setAttribute() {}
    toggleAttribute() {}
    addEventListener() {}
    find(tag: string): Stub[] {
        const inner = this.children.flatMap((child) =>
            typeof child === "string" ? [] : child.find(tag),
        );
        return this.tag === tag ? [this, ...inner] : inner;
    }
    get text(): string {
        return this.children
            .map((child) => (typeof child === "string" ? child : child.text))
            .join(" ");
    }
}

describe("the table of shortcuts", () => {
    it("gives no keys and no action twice", () => {
        const keys = all.flatMap((shortcut) => shortcut.keys);
        expect(new Set(keys).size).toBe(keys.length);
        expect(new Set(all.map((shortcut) => shortcut.action)).size).toBe(all.length);
    });

    it("is what the help overlay lists", () => {
        vi.stubGlobal("document", { createElement: (tag: string) => new Stub(tag) });
        const overlay = new Help().element as unknown as Stub;
        vi.unstubAllGlobals();
        const symbols: Record<string, string> = {
            "\u2190": "Left",
            "\u2192": "Right",
            "\u2191": "Up",
            "\u2193": "Down",
            Esc: "Escape",
        };
        const labels = overlay.find("dd").map((element) => element.text);
        const keys = overlay.find("dt").map((element) =>
            element
                .find("span")
                .slice(1)
                .map((caps) =>
                    caps
                        .find("kbd")
                        .map((cap) => symbols[cap.text] ?? cap.text)
                        .join("+"),
                ),
        );
        const listed = keys
            .map((names, i) => [names, labels[i]])
            .filter(([names]) => names.length > 0);
        expect(listed).toEqual(all.map((shortcut) => [shortcut.keys, shortcut.label]));
    });

    it("is what docs/editor.md lists", () => {
        expect(manual).toContain(`\n${shortcutsMarkdown()}\n`);
    });
});

describe("a key press", () => {
    it("has a name that does not depend on the layout of Shift", () => {
        expect(keyName(press("z", "c"))).toBe("Ctrl+Z");
        expect(keyName(press("Z", "cs"))).toBe("Ctrl+Shift+Z");
        expect(keyName(press("z", "m"))).toBe("Ctrl+Z");
        expect(keyName(press("?", "s"))).toBe("?");
        expect(keyName(press("}", "s"))).toBe("}");
        expect(keyName(press("ArrowLeft", "s"))).toBe("Shift+Left");
        expect(keyName(press("+", "as"))).toBe("Alt++");
        expect(keyName(press("PageUp"))).toBe("PageUp");
    });

    it("gives the action of the table", () => {
        expect(actionOf(press("z"))).toBe("undo");
        expect(actionOf(press("Z", "s"))).toBe("redo");
        expect(actionOf(press("["))).toBe("coarser");
        expect(actionOf(press("PageDown"))).toBe("finer");
        expect(actionOf(press("?", "s"))).toBe("help");
        expect(actionOf(press("ArrowUp", "a"))).toBe("moveUp");
        expect(actionOf(press("b"))).toBe("box");
        expect(actionOf(press("q"))).toBeNull();
        expect(actionOf(press("b", "c"))).toBeNull();
    });
});

describe("a control that has the focus", () => {
    const number = { tag: "INPUT", type: "number" };
    const slider = { tag: "INPUT", type: "range" };
    const button = { tag: "BUTTON", type: "" };
    const canvas = { tag: "CANVAS", type: "" };

    it("keeps what it needs itself", () => {
        expect(belongsToControl(press("-"), number)).toBe(true);
        expect(belongsToControl(press("ArrowUp"), number)).toBe(true);
        expect(belongsToControl(press("ArrowUp"), slider)).toBe(true);
        expect(belongsToControl(press("PageUp"), slider)).toBe(true);
        expect(belongsToControl(press("o"), { tag: "SELECT", type: "" })).toBe(true);
        expect(belongsToControl(press("Enter"), button)).toBe(true);
    });

    it("leaves the rest to the editor", () => {
        expect(belongsToControl(press("z", "c"), number)).toBe(false);
        expect(belongsToControl(press("Escape"), number)).toBe(false);
        expect(belongsToControl(press("n"), slider)).toBe(false);
        expect(belongsToControl(press("n"), button)).toBe(false);
        for (const key of ["n", "ArrowLeft", "PageUp", "Escape"])
            expect(belongsToControl(press(key), canvas)).toBe(false);
    });
});
