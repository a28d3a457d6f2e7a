// What went wrong, and what was done, in a corner of the viewport.

import { button, el } from "./dom";

const noticeMilliseconds = 6000;

export class Messages {
    readonly element = el("div", {
        class: "messages",
        role: "log",
        "aria-label": "Messages",
        "aria-live": "polite",
    });

    /** Stays until it is dismissed. The same message is shown once. */
    error(text: string): void {
        this.add("error", text);
    }

    /** Goes by itself. */
    notice(text: string): void {
        const item = this.add("notice", text);
        setTimeout(() => item.remove(), noticeMilliseconds);
    }

    clear(): void {
        this.element.replaceChildren();
    }

    get texts(): string[] {
        return [...this.element.children].map((item) => item.querySelector("p")?.textContent ?? "");
    }

    private add(kind: "error" | "notice", text: string): HTMLElement {
        for (const item of this.element.children) {
            if (item.querySelector("p")?.textContent === text) item.remove();
        }
        const item = el(
            "div",
            { class: `message ${kind}`, role: kind === "error" ? "alert" : "status" },
            el("p", {}, text),
        );
        item.append(
            button("\u00d7", () => item.remove(), { class: "quiet", "aria-label": "Dismiss" }),
        );
        this.element.append(item);
        return item;
    }
}
