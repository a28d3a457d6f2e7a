// All keys, in one table: what handles them, the help overlay and the documentation read it.

export type Action =
    | "frame"
    | "top"
    | "front"
    | "side"
    | "home"
    | "zoomIn"
    | "zoomOut"
    | "orbitLeft"
    | "orbitRight"
    | "orbitUp"
    | "orbitDown"
    | "panLeft"
    | "panRight"
    | "panUp"
    | "panDown"
    | "finer"
    | "coarser"
    | "netFiner"
    | "netCoarser"
    | "surface"
    | "wireframe"
    | "net"
    | "original"
    | "drape"
    | "colour"
    | "box"
    | "all"
    | "none"
    | "grow"
    | "left"
    | "right"
    | "up"
    | "down"
    | "moveLeft"
    | "moveRight"
    | "moveUp"
    | "moveDown"
    | "raise"
    | "lower"
    | "tilt"
    | "falloff"
    | "wider"
    | "narrower"
    | "undo"
    | "redo"
    | "open"
    | "save"
    | "picture"
    | "help"
    | "theme";

export interface Shortcut {
    action: Action;
    keys: readonly string[];
    label: string;
}

export interface ShortcutGroup {
    title: string;
    shortcuts: readonly Shortcut[];
}

export const shortcutGroups: readonly ShortcutGroup[] = [
    {
        title: "View",
        shortcuts: [
            { action: "frame", keys: ["F"], label: "Frame the selection, or everything" },
            { action: "home", keys: ["Home"], label: "First view" },
            { action: "top", keys: ["7"], label: "From above" },
            { action: "front", keys: ["1"], label: "From the south" },
            { action: "side", keys: ["3"], label: "From the east" },
            { action: "orbitLeft", keys: ["Shift+Left"], label: "Orbit to the left" },
            { action: "orbitRight", keys: ["Shift+Right"], label: "Orbit to the right" },
            { action: "orbitUp", keys: ["Shift+Up"], label: "Orbit upwards" },
            { action: "orbitDown", keys: ["Shift+Down"], label: "Orbit downwards" },
            { action: "panLeft", keys: ["Ctrl+Left"], label: "Pan to the left" },
            { action: "panRight", keys: ["Ctrl+Right"], label: "Pan to the right" },
            { action: "panUp", keys: ["Ctrl+Up"], label: "Pan upwards" },
            { action: "panDown", keys: ["Ctrl+Down"], label: "Pan downwards" },
            { action: "zoomIn", keys: ["+", "="], label: "Zoom in" },
            { action: "zoomOut", keys: ["-"], label: "Zoom out" },
        ],
    },
    {
        title: "File",
        shortcuts: [
            { action: "open", keys: ["Ctrl+O"], label: "Open a file" },
            { action: "save", keys: ["Ctrl+S"], label: "Save" },
            { action: "picture", keys: ["P"], label: "Save a picture (PNG)" },
            { action: "help", keys: ["?", "F1"], label: "This help" },
        ],
    },
    {
        title: "Show",
        shortcuts: [
            { action: "finer", keys: ["PageDown", "]"], label: "Finer level" },
            { action: "coarser", keys: ["PageUp", "["], label: "Coarser level" },
            { action: "netFiner", keys: ["}"], label: "Control net of a finer level" },
            { action: "netCoarser", keys: ["{"], label: "Control net of a coarser level" },
            { action: "surface", keys: ["S"], label: "Surface" },
            { action: "wireframe", keys: ["W"], label: "Wireframe" },
            { action: "net", keys: ["N"], label: "Control net" },
            { action: "original", keys: ["O"], label: "Original, and back" },
            { action: "drape", keys: ["I"], label: "Draped image" },
            { action: "colour", keys: ["C"], label: "Next colouring" },
            { action: "theme", keys: ["Shift+T"], label: "Light or dark" },
        ],
    },
    {
        title: "Select",
        shortcuts: [
            { action: "left", keys: ["Left"], label: "Neighbour on the left" },
            { action: "right", keys: ["Right"], label: "Neighbour on the right" },
            { action: "up", keys: ["Up"], label: "Neighbour above" },
            { action: "down", keys: ["Down"], label: "Neighbour below" },
            { action: "box", keys: ["B"], label: "Select by a box" },
            { action: "all", keys: ["A"], label: "Select all" },
            { action: "grow", keys: ["G"], label: "Grow the selection" },
            { action: "none", keys: ["Escape"], label: "End a drag, close, or select none" },
        ],
    },
    {
        title: "Edit",
        shortcuts: [
            { action: "raise", keys: ["Alt++", "Alt+="], label: "Raise by the step" },
            { action: "lower", keys: ["Alt+-"], label: "Lower by the step" },
            { action: "moveLeft", keys: ["Alt+Left"], label: "Move by \u2212x, or tilt" },
            { action: "moveRight", keys: ["Alt+Right"], label: "Move by +x, or tilt" },
            { action: "moveUp", keys: ["Alt+Up"], label: "Move by +y, or tilt; raise heights" },
            {
                action: "moveDown",
                keys: ["Alt+Down"],
                label: "Move by \u2212y, or tilt; lower heights",
            },
            { action: "tilt", keys: ["T"], label: "Move or tilt control triangles" },
            { action: "falloff", keys: ["R"], label: "Falloff" },
            { action: "wider", keys: ["."], label: "Wider falloff" },
            { action: "narrower", keys: [","], label: "Narrower falloff" },
            { action: "undo", keys: ["Ctrl+Z", "Z"], label: "Undo" },
            { action: "redo", keys: ["Ctrl+Shift+Z", "Shift+Z", "Ctrl+Y"], label: "Redo" },
        ],
    },
];

export interface KeyPress {
    key: string;
    ctrlKey: boolean;
    metaKey: boolean;
    shiftKey: boolean;
    altKey: boolean;
}

const byKeys = new Map(
    shortcutGroups.flatMap((group) =>
        group.shortcuts.flatMap((s) => s.keys.map((keys) => [keys, s.action] as const)),
    ),
);

/** The press as the table writes it: "Ctrl+Shift+Z", "?", "PageUp". */
export function keyName(press: KeyPress): string {
    const named = press.key.replace(/^Arrow/, "");
    const letter = /^[a-z]$/i.test(named);
    // Shift is part of how "?" or "}" are typed, and says nothing more.
    const shift = press.shiftKey && (letter || named.length > 1);
    return [
        press.ctrlKey || press.metaKey ? "Ctrl+" : "",
        press.altKey ? "Alt+" : "",
        shift ? "Shift+" : "",
        letter ? named.toUpperCase() : named,
    ].join("");
}

export function actionOf(press: KeyPress): Action | null {
    return byKeys.get(keyName(press)) ?? null;
}

/** Whether a press belongs to the control that has the focus rather than to the editor. */
export function belongsToControl(press: KeyPress, control: { tag: string; type: string }): boolean {
    const name = keyName(press);
    if (name === "Escape" || name === "F1" || /^Ctrl\+(Shift\+)?[A-Z]$/.test(name)) {
        return name === "Ctrl+Z" && control.type === "text";
    }
    if (control.tag === "SELECT" || control.tag === "TEXTAREA") return true;
    if (
        control.tag === "INPUT" &&
        !["checkbox", "radio", "range", "button", "file"].includes(control.type)
    )
        return true;
    const plainKey = press.key.length > 1 && !press.ctrlKey && !press.altKey;
    return plainKey && ["INPUT", "BUTTON", "A", "SUMMARY"].includes(control.tag);
}

/** The table as Markdown, for docs/editor.md. */
export function shortcutsMarkdown(): string {
    const rows = shortcutGroups.flatMap((group) => [
        `| **${group.title}** | |`,
        ...group.shortcuts.map(
            ({ keys, label }) => `| ${keys.map((key) => `\`${key}\``).join(", ")} | ${label} |`,
        ),
    ]);
    return ["| keys | |", "|---|---|", ...rows].join("\n");
}
