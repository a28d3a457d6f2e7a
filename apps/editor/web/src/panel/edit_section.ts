import { button, checkbox, el, numberField, section, segments, select, type Field } from "../dom";
import * as format from "../format";
import { movesOnlyUp, type Profile } from "../protocol";
import type { Tool } from "../store";
import { levelCounts } from "./level_section";
import type { Panel } from "./panel";

const profiles: readonly [Profile, string][] = [
    ["smooth", "Smooth"],
    ["linear", "Linear"],
    ["sharp", "Sharp"],
    ["flat", "Flat"],
];
const tools: readonly [Tool, string][] = [
    ["move", "Move"],
    ["tilt", "Tilt"],
];

function netLevel({ store }: Panel): HTMLElement {
    const level = select<string>(
        "Points of level",
        [],
        (value) => store.set({ netLevel: Number(value) }),
        "net-level",
    );
    store.watch(["hello"], ({ hello }) => {
        const options = (hello?.levels ?? []).map((info) =>
            el(
                "option",
                { value: info.level, title: levelCounts(info) },
                `${info.level} (${format.count(info.control_points)})`,
            ),
        );
        level.input.replaceChildren(...options);
    });
    store.watch(["hello", "netLevel"], (state) => level.show(String(state.netLevel)));
    return level.element;
}

function selectionRow({ store, actions }: Panel): HTMLElement {
    const text = el("p", { id: "selection" });
    store.watch(["selection"], ({ selection }) => {
        text.textContent =
            selection.size === 0
                ? "Nothing selected"
                : `${format.counted(selection.size, "point")} selected`;
    });
    return el(
        "div",
        { class: "group" },
        text,
        el(
            "div",
            { class: "row even" },
            button("All", () => actions.run("all"), { title: "A" }),
            button("Box", () => actions.run("box"), { title: "B, then drag" }),
            button("Grow", () => actions.run("grow"), { title: "G" }),
            button("None", () => actions.run("none"), { title: "Escape" }),
        ),
    );
}

/**
 * The fields of what a drag moves: they follow the pointer, and what is typed is applied by Enter
 * or the button.
 */
function deltaFields({ store, actions }: Panel): HTMLElement {
    const set = (axis: number, value: number) => {
        const { tool, delta, slope } = store.state;
        const changed = (vector: readonly number[]) =>
            vector.map((v, i) => (i === axis ? value : v));
        if (tool === "tilt") store.set({ slope: changed(slope) as [number, number] });
        else store.set({ delta: changed(delta) as [number, number, number] });
    };
    const fields = ["x", "y", "z"].map(
        (name, axis): Field =>
            numberField(name, (value) => set(axis, value), { id: `delta-${name}` }),
    );
    const apply = button("Apply", () => actions.applyFields(), { id: "apply" });
    for (const { input } of fields) {
        input.addEventListener("keydown", (event) => {
            if (event.key !== "Enter") return;
            input.dispatchEvent(new Event("change"));
            actions.applyFields();
        });
    }
    const title = el("span", {});
    store.watch(["delta", "slope", "tool"], ({ delta, slope, tool }) => {
        const shown = tool === "tilt" ? [...slope, 0] : delta;
        fields.forEach((field, i) => field.show(format.field(shown[i])));
    });
    store.watch(["hello", "tool"], ({ hello, tool }) => {
        const onlyUp = !hello || movesOnlyUp(hello);
        title.textContent =
            tool === "tilt" ? "Tilt by slope" : `Move by${hello?.unit ? ` (${hello.unit})` : ""}`;
        fields.forEach((field, i) => {
            field.element.hidden = tool === "tilt" ? i === 2 : onlyUp && i < 2;
        });
    });
    store.watch(["selection", "hello", "connected"], ({ selection, hello, connected }) => {
        apply.disabled = selection.size === 0 || !hello?.writer || !connected;
    });
    return el(
        "div",
        { class: "group", role: "group", "aria-label": "Move by" },
        el("div", { class: "label" }, title),
        el("div", { class: "row vector" }, ...fields.map((field) => field.element), apply),
    );
}

function falloffGroup({ store }: Panel): HTMLElement {
    const on = checkbox("Falloff", (checked) => store.set({ falloff: checked }));
    const radius = numberField("Radius", (value) => store.set({ radius: value }), {
        min: 0,
        id: "radius",
    });
    const profile = select("Profile", profiles, (value) => store.set({ profile: value }));
    store.watch(["falloff", "radius", "profile"], (state) => {
        on.show(String(state.falloff));
        radius.show(format.field(state.radius));
        profile.show(state.profile);
        radius.input.disabled = profile.input.disabled = !state.falloff;
    });
    return el(
        "div",
        { class: "group" },
        on.element,
        el("div", { class: "row" }, radius.element, profile.element),
    );
}

export function editSection(panel: Panel): HTMLElement {
    const { store } = panel;
    const locked = el("p", { class: "dim" }, "Another page edits this file; this one watches.");
    const tool = segments("Tool", tools, (value) => store.set({ tool: value }));
    const step = numberField("Step of keys", (value) => store.set({ step: value }), {
        min: 0,
        id: "step",
    });
    store.watch(["tool"], (state) => tool.show(state.tool));
    store.watch(["step"], (state) => step.show(format.field(state.step)));
    store.watch(["hello"], ({ hello }) => {
        tool.element.hidden = hello?.kind !== "triangles";
        locked.hidden = hello?.writer !== false;
    });
    return section(
        "Edit",
        locked,
        netLevel(panel),
        tool.element,
        selectionRow(panel),
        deltaFields(panel),
        step.element,
        falloffGroup(panel),
    );
}
