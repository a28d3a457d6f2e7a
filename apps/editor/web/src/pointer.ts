// The pointer over the viewport: orbit, pan, zoom, select and drag.

import { orbited, panned, zoomed } from "./camera";
import { el } from "./dom";
import type { Editing } from "./editing";
import type { Gizmo } from "./gizmo";
import { boxOf, type Point2 } from "./selection";
import type { Session } from "./session";
import type { Store } from "./store";
import type { Viewport } from "./viewport";

type Mode = "idle" | "pressed" | "orbit" | "pan" | "box" | "drag" | "pinch";

const clickPixels = 4;
const radiansPerPixel = 0.006;

export class Pointer {
    private mode: Mode = "idle";
    private start: Point2 = { x: 0, y: 0 };
    private last: Point2 = { x: 0, y: 0 };
    private pressedPlace = -1;
    private readonly touches = new Map<number, Point2>();
    private readonly rubber = el("div", { class: "rubber", hidden: true });
    private readonly watchers: ((pointer: Point2 | null) => void)[] = [];

    constructor(
        private readonly viewport: Viewport,
        private readonly store: Store,
        private readonly session: Session,
        private readonly editing: Editing,
        private readonly gizmo: Gizmo,
    ) {
        const canvas = viewport.canvas;
        (canvas.parentElement as HTMLElement).append(this.rubber);
        canvas.addEventListener("pointerdown", (event) => this.down(event));
        canvas.addEventListener("pointermove", (event) => this.move(event));
        canvas.addEventListener("pointerup", (event) => this.up(event));
        canvas.addEventListener("pointercancel", () => this.cancel());
        canvas.addEventListener("pointerleave", () => this.leave());
        canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
        canvas.addEventListener("dblclick", (event) => this.lookAt(this.at(event)));
        canvas.addEventListener("contextmenu", (event) => event.preventDefault());
        store.watch(["boxSelecting"], (state) =>
            canvas.classList.toggle("crosshair", state.boxSelecting),
        );
    }

    /**
     * Calls with the place of a pointer that rests or moves freely, and with null when it leaves.
     */
    onHover(call: (pointer: Point2 | null) => void): void {
        this.watchers.push(call);
    }

    get busy(): boolean {
        return this.mode !== "idle";
    }

    /** Ends what the pointer does; nothing stays. True if there was something. */
    cancel(): boolean {
        const was = this.mode;
        this.mode = "idle";
        this.rubber.hidden = true;
        this.touches.clear();
        if (was === "drag") this.editing.cancel();
        const boxing = this.store.state.boxSelecting;
        this.store.set({ boxSelecting: false });
        return was === "drag" || was === "box" || boxing;
    }

    private at(event: MouseEvent): Point2 {
        const frame = this.viewport.canvas.getBoundingClientRect();
        return { x: event.clientX - frame.left, y: event.clientY - frame.top };
    }

    private tell(pointer: Point2 | null): void {
        for (const call of this.watchers) call(pointer);
    }

    private leave(): void {
        this.editing.unhover();
        this.tell(null);
    }

    private down(event: PointerEvent): void {
        const pointer = this.at(event);
        this.viewport.canvas.setPointerCapture(event.pointerId);
        this.viewport.canvas.focus({ preventScroll: true });
        this.start = this.last = pointer;
        if (event.pointerType === "touch") {
            this.touches.set(event.pointerId, pointer);
            if (this.touches.size === 2) {
                if (this.mode === "drag") this.editing.cancel();
                this.mode = "pinch";
                return;
            }
        }
        if (event.button === 1 || event.button === 2) this.mode = "pan";
        else if (event.button === 0) this.press(pointer, event.shiftKey);
        if (event.button === 1) event.preventDefault();
    }

    private press(pointer: Point2, shift: boolean): void {
        this.editing.unhover();
        if (this.store.state.boxSelecting) {
            this.mode = "box";
            return;
        }
        const handle = this.gizmo.handleAt(pointer);
        if (handle && this.editing.begin(handle, pointer)) {
            this.mode = "drag";
            return;
        }
        this.pressedPlace = this.editing.placeAt(pointer);
        this.mode = this.pressedPlace >= 0 ? "pressed" : shift ? "pan" : "orbit";
    }

    private move(event: PointerEvent): void {
        const pointer = this.at(event);
        const before = this.last;
        this.last = pointer;
        if (this.mode === "pinch") {
            this.pinch(event.pointerId, pointer);
            return;
        }
        const [dx, dy] = [pointer.x - before.x, pointer.y - before.y];
        const camera = this.viewport.camera;
        switch (this.mode) {
            case "idle":
                this.viewport.canvas.classList.toggle("over", this.editing.hover(pointer));
                this.tell(pointer);
                break;
            case "pressed":
                this.dragPoint(pointer, event.shiftKey);
                break;
            case "orbit":
                this.viewport.camera = orbited(camera, -dx * radiansPerPixel, dy * radiansPerPixel);
                break;
            case "pan":
                this.viewport.camera = panned(camera, dx, dy, this.viewport.height);
                break;
            case "box":
                this.stretch(pointer);
                break;
            case "drag":
                this.editing.follow(pointer, event.ctrlKey || event.metaKey);
                break;
        }
    }

    /** A point that is pulled away from where it was pressed is dragged, selected or not. */
    private dragPoint(pointer: Point2, shift: boolean): void {
        if (!this.travelled(pointer)) return;
        if (!this.editing.isSelected(this.pressedPlace))
            this.editing.select(this.pressedPlace, shift);
        const tilting = this.store.state.tool === "tilt";
        const begun = !tilting && this.editing.begin("free", this.start, this.pressedPlace);
        this.mode = begun ? "drag" : "orbit";
    }

    private up(event: PointerEvent): void {
        const pointer = this.at(event);
        this.touches.delete(event.pointerId);
        const mode = this.mode;
        this.mode = "idle";
        if (mode === "pressed") this.editing.select(this.pressedPlace, event.shiftKey);
        if (mode === "orbit" && !this.travelled(pointer) && !event.shiftKey)
            this.editing.selectNone();
        if (mode === "drag") this.editing.commit();
        if (mode === "box") {
            this.rubber.hidden = true;
            this.store.set({ boxSelecting: false });
            this.editing.selectBox(boxOf(this.start, pointer), event.shiftKey);
        }
    }

    private travelled(pointer: Point2): boolean {
        return Math.hypot(pointer.x - this.start.x, pointer.y - this.start.y) > clickPixels;
    }

    private wheel(event: WheelEvent): void {
        event.preventDefault();
        const turns = event.deltaY / (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 3 : 100);
        const factor = 1.15 ** Math.max(-4, Math.min(4, turns));
        if (this.editing.dragging) this.editing.scaleRadius(1 / factor);
        else this.zoom(factor, this.at(event));
    }

    private zoom(factor: number, pointer: Point2): void {
        const { camera, width, height } = this.viewport;
        this.viewport.camera = zoomed(
            camera,
            factor,
            pointer.x - width / 2,
            pointer.y - height / 2,
            height,
        );
    }

    private pinch(id: number, pointer: Point2): void {
        const before = this.touches.get(id);
        const other = [...this.touches].find(([key]) => key !== id)?.[1];
        this.touches.set(id, pointer);
        if (!before || !other) return;
        const distance = (p: Point2) => Math.hypot(p.x - other.x, p.y - other.y) || 1;
        this.zoom(distance(before) / distance(pointer), {
            x: (pointer.x + other.x) / 2,
            y: (pointer.y + other.y) / 2,
        });
        const [dx, dy] = [(pointer.x - before.x) / 2, (pointer.y - before.y) / 2];
        this.viewport.camera = panned(this.viewport.camera, dx, dy, this.viewport.height);
    }

    private stretch(pointer: Point2): void {
        const { left, top, right, bottom } = boxOf(this.start, pointer);
        this.rubber.hidden = false;
        Object.assign(this.rubber.style, {
            left: `${left}px`,
            top: `${top}px`,
            width: `${right - left}px`,
            height: `${bottom - top}px`,
        });
    }

    /** Makes the place under the pointer the middle of the picture. */
    private lookAt(pointer: Point2): void {
        const object = this.session.shape?.object;
        const hit = object && this.viewport.hit(pointer, object);
        if (hit)
            this.viewport.camera = { ...this.viewport.camera, target: this.viewport.toScene(hit) };
    }
}
