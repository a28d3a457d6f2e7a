import { button, el } from "../dom";
import type { Help } from "../help";
import type { Theme } from "../theme";
import { compressSection } from "./compress_section";
import { editSection } from "./edit_section";
import { fileSection } from "./file_section";
import { historySection } from "./history_section";
import { levelSection } from "./level_section";
import type { Panel } from "./panel";
import { showSection } from "./show_section";

export function buildPanel(panel: Panel, theme: Theme, help: Help): HTMLElement {
    const head = el(
        "header",
        {},
        el("h1", {}, "relief"),
        theme.button,
        button("?", () => help.toggle(), {
            class: "quiet",
            "aria-label": "Help",
            title: "Keyboard and pointer (?)",
        }),
    );
    const sections = [
        fileSection,
        levelSection,
        showSection,
        editSection,
        compressSection,
        historySection,
    ];
    return el(
        "aside",
        { class: "panel", "aria-label": "Tools" },
        head,
        el("div", { class: "sections" }, ...sections.map((build) => build(panel))),
    );
}
