// Light or dark: as the system says, until the user says otherwise.

import { button } from "./dom";

type Choice = "auto" | "light" | "dark";

const storageKey = "relief-theme";
const labels: Record<Choice, string> = { auto: "Auto", light: "Light", dark: "Dark" };

export class Theme {
    readonly button = button("", () => this.next(), { class: "quiet", id: "theme" });
    private readonly watchers: (() => void)[] = [];
    private choice: Choice = "auto";

    constructor() {
        const kept = localStorage.getItem(storageKey);
        if (kept === "light" || kept === "dark") this.choice = kept;
        matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.apply());
        this.apply();
    }

    onChange(call: () => void): void {
        this.watchers.push(call);
    }

    next(): void {
        const order: Choice[] = ["auto", "light", "dark"];
        this.choice = order[(order.indexOf(this.choice) + 1) % order.length];
        localStorage.setItem(storageKey, this.choice);
        this.apply();
    }

    private apply(): void {
        const dark =
            this.choice === "auto"
                ? matchMedia("(prefers-color-scheme: dark)").matches
                : this.choice === "dark";
        document.documentElement.dataset.theme = dark ? "dark" : "light";
        this.button.textContent = labels[this.choice];
        this.button.title = "Light or dark (Shift+T)";
        this.button.setAttribute("aria-label", `Theme: ${labels[this.choice]}`);
        for (const call of this.watchers) call();
    }
}
