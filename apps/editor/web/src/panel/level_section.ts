import { button, el, section } from "../dom";
import * as format from "../format";
import type { LevelInfo } from "../protocol";
import type { Panel } from "./panel";

/** "63 x 63 control points, 4.1 kB of the file". */
export function levelCounts(info: LevelInfo): string {
    const size =
        info.rows && info.cols
            ? `${format.count(info.rows)} \u00d7 ${format.count(info.cols)} control points`
            : format.counted(info.control_points, "control point");
    const faces = info.faces > 0 ? `, ${format.counted(info.faces, "face")}` : "";
    return `${size}${faces}${info.bytes > 0 ? `, ${format.bytes(info.bytes)} of the file` : ""}`;
}

/** The slider runs from the coarsest level to the finest, level 0. */
export function levelSection({ store, actions }: Panel): HTMLElement {
    const slider = el("input", {
        type: "range",
        min: 0,
        step: 1,
        id: "level",
        "aria-label": "Level",
    });
    const counts = el("p", { class: "dim", id: "level-counts" });
    const value = el("output", { for: "level" });
    const coarser = button("Coarser", () => actions.run("coarser"), { title: "PageUp or [" });
    const finer = button("Finer", () => actions.run("finer"), { title: "PageDown or ]" });
    slider.addEventListener("input", () => {
        const levels = store.state.hello?.levels ?? [];
        const info = levels[levels.length - 1 - slider.valueAsNumber];
        if (info) store.set({ level: info.level });
    });
    store.watch(["hello", "level"], ({ hello, level }) => {
        const levels = hello?.levels ?? [];
        const place = levels.findIndex((info) => info.level === level);
        slider.max = String(Math.max(0, levels.length - 1));
        slider.value = String(Math.max(0, levels.length - 1 - place));
        slider.disabled = levels.length < 2;
        coarser.disabled = place < 0 || place === levels.length - 1;
        finer.disabled = place <= 0;
        const text = place < 0 ? "" : levelCounts(levels[place]);
        value.textContent = place < 0 ? "" : `${level}${place === 0 ? ", the finest" : ""}`;
        counts.textContent = text;
        slider.setAttribute("aria-valuetext", `Level ${level}: ${text}`);
    });
    const head = el("div", { class: "label" }, el("span", {}, "Level"), value);
    return section("Level", head, slider, counts, el("div", { class: "row even" }, coarser, finer));
}
