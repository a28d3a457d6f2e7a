import {
    button,
    checkbox,
    el,
    numberField,
    ratioSlider,
    row,
    section,
    segments,
    select,
} from "../dom";
import * as format from "../format";
import { movesOnlyUp, type Shown } from "../protocol";
import type { Colouring } from "../store";
import type { Panel } from "./panel";

const colourings: readonly [Colouring, string][] = [
    ["plain", "Plain"],
    ["height", "Height"],
    ["slope", "Slope"],
    ["curvature", "Curvature"],
    ["error", "Error"],
];

const shown: readonly [Shown, string][] = [
    ["edited", "Edited"],
    ["original", "Original"],
    ["compressed", "Compressed"],
];

function exaggeration({ store }: Panel): HTMLElement {
    const field = numberField("Exaggeration", (value) => store.set({ exaggeration: value }), {
        min: 1e-6,
        max: 1e6,
        id: "exaggeration",
    });
    const slider = ratioSlider("Vertical exaggeration", (value) =>
        store.set({ exaggeration: value }),
    );
    store.watch(["hello"], ({ exaggeration: start }) =>
        slider.setRange(Math.min(0.1, start / 10), Math.max(20, start * 10)),
    );
    store.watch(["exaggeration"], ({ exaggeration: factor }) => {
        field.show(format.field(factor));
        slider.show(factor, `${format.number(factor)} times`);
    });
    return el("div", { class: "group" }, field.element, slider.input);
}

function errorLine({ store, actions }: Panel): HTMLElement {
    const text = el("p", { class: "dim", id: "errors" });
    const go = button("Go there", () => actions.goToLargestError(), { class: "quiet" });
    const line = el("div", { class: "row spread" }, text, go);
    store.watch(["errors", "colouring", "hello"], ({ errors, colouring, hello }) => {
        line.hidden = colouring !== "error";
        const unit = hello?.unit ?? "";
        text.textContent = errors
            ? [
                  "Largest ",
                  format.measured(errors.max_error, unit),
                  ", rms ",
                  format.measured(errors.rms_error, unit),
              ].join("")
            : "Measuring \u2026";
        go.hidden = !errors?.place || errors.max_error === 0;
    });
    return line;
}

export function showSection(panel: Panel): HTMLElement {
    const { store } = panel;
    const surface = checkbox("Surface", (checked) => store.set({ surface: checked }));
    const wireframe = checkbox("Wireframe", (checked) => store.set({ wireframe: checked }));
    const net = checkbox("Control net", (checked) => store.set({ net: checked }));
    const image = checkbox("Image", (checked) =>
        store.set({ drape: checked ? "shown" : "hidden" }),
    );
    const which = segments("Surface shown", shown, (value) => store.set({ shown: value }));
    const colour = select(
        "Colour by",
        colourings,
        (value) => store.set({ colouring: value }),
        "colouring",
    );
    const stretch = exaggeration(panel);
    store.watch(["surface", "wireframe", "net", "drape"], (state) => {
        surface.show(String(state.surface));
        wireframe.show(String(state.wireframe));
        net.show(String(state.net));
        image.show(String(state.drape === "shown"));
        image.element.hidden = state.drape === "none";
    });
    store.watch(["shown", "compressed"], (state) => {
        which.show(state.shown);
        which.enable("compressed", state.compressed !== null || state.shown === "compressed");
    });
    store.watch(["colouring"], ({ colouring }) => colour.show(colouring));
    store.watch(["hello"], ({ hello }) => {
        stretch.hidden = !hello || !movesOnlyUp(hello);
    });
    const checks = el(
        "div",
        { class: "checks" },
        surface.element,
        wireframe.element,
        net.element,
        image.element,
    );
    return section("Show", which.element, checks, row(colour.element), errorLine(panel), stretch);
}
