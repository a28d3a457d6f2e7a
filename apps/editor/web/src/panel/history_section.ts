import { button, el, section } from "../dom";
import type { Panel } from "./panel";

export function historySection({ store, actions }: Panel): HTMLElement {
    const undo = button("Undo", () => actions.run("undo"), { title: "Ctrl+Z" });
    const redo = button("Redo", () => actions.run("redo"), { title: "Ctrl+Shift+Z" });
    const list = el("ol", { class: "history", id: "history", "aria-label": "History" });
    store.watch(["history", "hello", "connected"], ({ history, hello, connected }) => {
        const locked = !hello?.writer || !connected;
        undo.disabled = locked || history.done === 0;
        redo.disabled = locked || history.done === history.entries.length;
        const texts = ["As opened", ...history.entries.map((entry) => entry.text)];
        const items = texts.map((text, done) => {
            const item = button(text, () => actions.goTo(done), {
                class: done > history.done ? "undone" : "",
                disabled: locked,
            });
            if (done === history.done) item.setAttribute("aria-current", "step");
            return el("li", {}, item);
        });
        list.replaceChildren(...items);
        // Not scrollIntoView: this would also scroll the panel away from what is being used.
        list.scrollTop = items[history.done].offsetTop - list.clientHeight / 2;
    });
    return section("History", el("div", { class: "row even" }, undo, redo), list);
}
