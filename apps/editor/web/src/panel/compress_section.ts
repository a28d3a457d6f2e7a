import { el, numberField, ratioSlider, section } from "../dom";
import * as format from "../format";
import { roundUp } from "../format";
import type { State } from "../store";
import type { Panel } from "./panel";

/** The slider's value is sent when it has rested so long. */
const restMilliseconds = 180;

function results({ compressed, hello }: State): [string, string][] {
    if (!compressed || !hello) return [];
    const share =
        compressed.coefficients > 0 ? (100 * compressed.kept) / compressed.coefficients : 0;
    const kept = ` (${format.number(share, 3)} %)`;
    const ratio =
        hello.bytes > 0
            ? ` (${format.number((100 * compressed.bytes) / hello.bytes, 3)} % of the file)`
            : "";
    return [
        ["Size", `${format.bytes(compressed.bytes)}${ratio}`],
        [
            "Kept",
            `${format.count(compressed.kept)} of ${format.count(compressed.coefficients)}${kept}`,
        ],
        ["Largest error", format.measured(compressed.max_error, hello.unit)],
        ["Rms error", format.measured(compressed.rms_error, hello.unit)],
    ];
}

export function compressSection({ store, actions }: Panel): HTMLElement {
    let timer = 0;
    const chosen = (bound: number) => {
        store.set({ bound });
        window.clearTimeout(timer);
        timer = window.setTimeout(() => actions.compress(), restMilliseconds);
    };
    const field = numberField("Error bound", chosen, { min: 0, id: "bound" });
    const slider = ratioSlider("Error bound", chosen);
    slider.input.id = "bound-slider";
    const table = el("dl", { id: "compressed" });
    const hint = el(
        "p",
        { class: "dim" },
        "Move the slider to see what a bound costs and how it looks.",
    );
    store.watch(["hello"], ({ hello }) => {
        const height = hello ? hello.max[2] - hello.min[2] : 1;
        const most = roundUp((height || 1) / 10);
        slider.setRange(most / 1e5, most);
        slider.input.disabled = field.input.disabled = !hello;
        (field.element.firstChild as HTMLElement).textContent =
            `Error bound${hello?.unit ? ` (${hello.unit})` : ""}`;
    });
    store.watch(["hello", "bound"], ({ bound, hello }) => {
        field.show(format.field(bound));
        slider.show(bound, format.measured(bound, hello?.unit ?? ""));
    });
    store.watch(["compressed"], (state) => {
        hint.hidden = state.compressed !== null;
        table.replaceChildren(
            ...results(state).flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)]),
        );
    });
    return section("Compress", field.element, slider.input, hint, table);
}
