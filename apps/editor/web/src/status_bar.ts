// The line at the bottom: the value under the pointer, its place in the file's coordinates, level
// and counts.

import { el } from "./dom";
import * as format from "./format";
import type { PlaceAnswer, Vector3 } from "./protocol";
import type { Point2 } from "./selection";
import type { Session } from "./session";
import type { Store } from "./store";
import type { Viewport } from "./viewport";

/** Under the pointer nothing is looked up before it has rested so long. */
const restMilliseconds = 40;

export class StatusBar {
    private readonly value = el("span", { class: "value", id: "status-value" });
    private readonly place = el("span", { id: "status-place" });
    private readonly busy = el("span", { class: "busy", role: "status" });
    private readonly counts = el("span", { class: "counts", id: "status-counts" });
    readonly element = el(
        "footer",
        { class: "status", "aria-label": "Status" },
        this.value,
        this.place,
        this.busy,
        this.counts,
    );
    private timer = 0;
    private wanted: Point2 | null = null;
    private asking = false;

    constructor(
        private readonly store: Store,
        private readonly session: Session,
        private readonly viewport: Viewport,
    ) {
        store.watch(["busy"], (state) => {
            this.busy.textContent = state.busy;
        });
        store.watch(["hello", "level", "revision"], () => this.showCounts());
        session.onGeometry(() => this.showCounts());
    }

    /** Shows what lies under the pointer, soon. */
    follow(pointer: Point2 | null): void {
        this.wanted = pointer;
        window.clearTimeout(this.timer);
        if (!pointer) this.clear();
        else this.timer = window.setTimeout(() => void this.ask(), restMilliseconds);
    }

    private clear(): void {
        this.value.textContent = "";
        this.place.textContent = "";
    }

    private async ask(): Promise<void> {
        const { hello } = this.store.state;
        if (this.asking || !this.wanted || !hello || !this.session.shape) return;
        const hit = this.viewport.hit(this.wanted, this.session.shape.object);
        if (!hit) {
            this.clear();
            return;
        }
        if (hello.kind === "mesh" || hello.parametric) {
            this.showPlace(hit);
            return;
        }
        this.asking = true;
        this.wanted = null;
        const answer = await this.session.send<PlaceAnswer>({ ask: "at", x: hit[0], y: hit[1] });
        this.asking = false;
        if (answer) this.showAnswer(answer);
        if (this.wanted) void this.ask();
    }

    private showPlace(hit: Vector3): void {
        const origin = this.store.state.hello?.origin ?? [0, 0, 0];
        const texts = hit.map((p, i) => `${"xyz"[i]} ${format.number(p + origin[i], 7)}`);
        this.value.textContent = "";
        this.place.textContent = texts.join("  ");
    }

    private showAnswer({ value, slope, x, y }: PlaceAnswer): void {
        const { hello } = this.store.state;
        if (value === null || !hello) {
            this.clear();
            return;
        }
        const values = (Array.isArray(value) ? value : [value])
            .map((v) => format.number(v, 6))
            .join(", ");
        const steep = slope === null ? "" : `  slope ${format.number(slope, 3)}\u00b0`;
        this.value.textContent = `${values}${hello.unit ? ` ${hello.unit}` : ""}${steep}`;
        const where =
            x === null || y === null ? "" : `x ${format.number(x, 9)}  y ${format.number(y, 9)}`;
        this.place.textContent = `${where}  ${format.crs(hello.crs)}`;
    }

    private showCounts(): void {
        const { hello, level } = this.store.state;
        const info = hello?.levels.find((entry) => entry.level === level);
        if (!info) {
            this.counts.textContent = "";
            return;
        }
        const faces = info.faces > 0 ? ` \u00b7 ${format.counted(info.faces, "face")}` : "";
        const points = format.counted(info.control_points, "control point");
        this.counts.textContent = `Level ${level} \u00b7 ${points}${faces}`;
    }
}
