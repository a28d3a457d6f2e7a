// Selecting control points and moving them.

import type { ControlNet } from "./control_net";
import type { Gizmo, GizmoKind, Handle } from "./gizmo";
import { LatestSender } from "./latest_sender";
import { movesOnlyUp, type Edit, type Falloff, type Vector3 } from "./protocol";
import {
    grown,
    neighbourTowards,
    placesInBox,
    placeUnder,
    toggled,
    united,
    type Box,
    type Point2,
} from "./selection";
import type { Session } from "./session";
import type { Store } from "./store";
import type { Viewport } from "./viewport";

/** Pixels around a point within which the pointer takes it. */
const reach = 9;
/** Control points that are farther away than the surface by this factor count as hidden. */
const behindSurface = 1.02;

interface Drag {
    tilting: boolean;
    start: Vector3;
    moved: boolean;
}

export class Editing {
    private drag: Drag | null = null;
    private readonly drags = new LatestSender<Edit>(({ do: of, ...members }) =>
        this.session.send({ do: "drag", of, ...members }),
    );
    private hovered = -1;
    private netLevel = -1;
    private afterNet: (() => void) | null = null;

    constructor(
        private readonly store: Store,
        private readonly session: Session,
        private readonly viewport: Viewport,
        private readonly net: ControlNet,
        private readonly gizmo: Gizmo,
    ) {
        store.watch(["selection", "falloff", "radius", "profile", "tool", "net", "hello"], () =>
            this.show(),
        );
        store.watch(["selection", "tool"], () => this.resetFields());
        store.watch(["netLevel", "hello"], () => this.forgetNet());
        session.onGeometry(() => this.netArrived());
        viewport.onDraw(() => this.gizmo.prepare());
    }

    get dragging(): boolean {
        return this.drag !== null;
    }

    /** Whether commands are accepted at all. */
    get canEdit(): boolean {
        const { hello, connected } = this.store.state;
        return hello !== null && hello.writer && connected;
    }

    get onlyUp(): boolean {
        const { hello } = this.store.state;
        return hello === null || movesOnlyUp(hello);
    }

    /**
     * The place of the control point under the pointer, or -1. Points before the surface go before
     * those behind.
     */
    placeAt(pointer: Point2, within = reach): number {
        if (this.net.count === 0) return -1;
        const projected = this.viewport.project(this.net.position);
        const nearest = placeUnder(projected, pointer, within);
        const surface = this.session.shape?.object;
        const hit = nearest >= 0 && surface ? this.viewport.hit(pointer, surface) : null;
        if (!hit) return nearest;
        const before = placeUnder(
            projected,
            pointer,
            within,
            behindSurface * this.viewport.projectPoint(hit)[2],
        );
        return before >= 0 ? before : nearest;
    }

    hover(pointer: Point2): boolean {
        const place = this.placeAt(pointer);
        if (place !== this.hovered) {
            this.hovered = place;
            this.show();
        }
        return place >= 0 || this.gizmo.handleAt(pointer) !== null;
    }

    /** The pointer is not over the viewport any more, or does something else. */
    unhover(): void {
        if (this.hovered < 0) return;
        this.hovered = -1;
        this.show();
    }

    select(place: number, adding: boolean): void {
        const name = this.net.names[place];
        this.store.set({
            selection: adding ? toggled(this.store.state.selection, name) : new Set([name]),
        });
    }

    isSelected(place: number): boolean {
        return this.store.state.selection.has(this.net.names[place]);
    }

    selectNone(): void {
        if (this.store.state.selection.size > 0) this.store.set({ selection: new Set() });
    }

    selectAll(): void {
        this.withNet(() => this.store.set({ selection: new Set(this.net.names) }));
    }

    /** The next drag of the pointer draws a box. */
    startBox(): void {
        this.withNet(() => this.store.set({ boxSelecting: true }));
    }

    selectBox(box: Box, adding: boolean): void {
        const places = placesInBox(this.viewport.project(this.net.position), box);
        const names = places.map((place) => this.net.names[place]);
        this.store.set({
            selection: united(adding ? this.store.state.selection : new Set(), names),
        });
    }

    grow(): void {
        const places = grown(this.net.adjacency, this.net.placesOf(this.store.state.selection));
        this.store.set({
            selection: united(
                this.store.state.selection,
                places.map((place) => this.net.names[place]),
            ),
        });
    }

    /**
     * Selects the neighbour in a direction on the screen; the point in the middle if none is
     * selected.
     */
    selectTowards(direction: Point2): void {
        this.withNet(() => {
            const projected = this.viewport.project(this.net.position);
            const selected = this.net.placesOf(this.store.state.selection);
            const middle = { x: this.viewport.width / 2, y: this.viewport.height / 2 };
            const next =
                selected.length > 0
                    ? neighbourTowards(
                          this.net.adjacency,
                          projected,
                          selected[selected.length - 1],
                          direction,
                      )
                    : this.placeAt(middle, Infinity);
            if (next >= 0) this.select(next, false);
        });
    }

    /** Begins to drag the selection by a handle, or by the point at `place`. */
    begin(handle: Handle, pointer: Point2, place = -1): boolean {
        const start = this.net.middle(this.net.placesOf(this.store.state.selection));
        if (!this.canEdit || !start) return false;
        this.gizmo.grab(handle, pointer, place >= 0 ? this.net.pointAt(place) : start);
        this.drag = { tilting: handle.startsWith("tilt"), start, moved: false };
        this.store.set({ dragging: true });
        if (this.store.state.shown !== "edited") this.store.set({ shown: "edited" });
        return true;
    }

    /** Follows the pointer; with `snapping` by whole steps. */
    follow(pointer: Point2, snapping: boolean): void {
        if (!this.drag) return;
        const { step } = this.store.state;
        const moved = this.gizmo
            .dragged(pointer)
            .map((d) => (snapping ? Math.round(d / step) * step : d)) as Vector3;
        this.drag.moved = true;
        if (this.drag.tilting) this.store.set({ slope: [moved[0], moved[1]] });
        else this.store.set({ delta: moved });
        this.preview();
    }

    /** Makes the drag a command. */
    commit(): void {
        const drag = this.drag;
        if (!drag) return;
        this.end();
        if (!drag.moved) return;
        if (this.isStill(drag.tilting)) void this.session.send({ do: "release" });
        else void this.apply(drag.tilting);
    }

    /** Ends the drag; nothing stays. */
    cancel(): void {
        if (!this.drag) return;
        const { moved } = this.drag;
        this.end();
        if (moved) void this.session.send({ do: "release" });
        this.resetFields();
        this.show();
    }

    /** Moves the selection by what the fields say, or tilts it. */
    async apply(tilting: boolean): Promise<void> {
        const edit = this.isStill(tilting) ? null : this.edit(tilting);
        this.resetFields();
        if (edit) await this.session.edit(edit);
    }

    /** Moves the selection by so many steps along the axes; by tilting if this is the tool. */
    nudge(x: number, y: number, z: number): void {
        if (!this.canEdit) return;
        const { step, tool } = this.store.state;
        if (tool === "tilt" && z === 0) {
            this.store.set({ slope: [x * step, y * step] });
            void this.apply(true);
            return;
        }
        this.store.set({
            delta: this.onlyUp ? [0, 0, (y + z) * step] : [x * step, y * step, z * step],
        });
        void this.apply(false);
    }

    /** Multiplies the falloff's radius. */
    scaleRadius(factor: number): void {
        const radius = Number((this.store.state.radius * factor).toPrecision(3));
        this.store.set({ radius, falloff: true });
        if (this.drag) this.preview();
    }

    private isStill(tilting: boolean): boolean {
        const { slope, delta } = this.store.state;
        return (tilting ? slope : delta).every((d) => d === 0);
    }

    private edit(tilting: boolean): Edit | null {
        const { selection, netLevel, delta, slope, falloff, radius, profile } = this.store.state;
        const points = [...selection].sort((a, b) => a - b);
        if (points.length === 0) return null;
        const around: { falloff?: Falloff } = falloff ? { falloff: { radius, profile } } : {};
        if (tilting) return { do: "tilt", level: netLevel, points, slope, ...around };
        return {
            do: "move",
            level: netLevel,
            points,
            delta: this.onlyUp ? delta[2] : delta,
            ...around,
        };
    }

    /** Shows the drag here and asks the server to show it. */
    private preview(): void {
        const drag = this.drag;
        if (!drag) return;
        const { delta } = this.store.state;
        this.gizmo.show(
            drag.start.map((s, i) => s + (drag.tilting ? 0 : delta[i])) as Vector3,
            this.gizmoKind(),
        );
        const edit = this.edit(drag.tilting);
        if (edit) this.drags.offer(edit);
    }

    private end(): void {
        this.drag = null;
        this.drags.drop();
        this.gizmo.release();
        this.store.set({ dragging: false });
    }

    private netArrived(): void {
        if (this.net.count > 0 && this.net.level !== this.netLevel) {
            this.netLevel = this.net.level;
            this.store.set({ radius: Number((3 * this.net.typicalEdge()).toPrecision(2)) || 1 });
        }
        if (this.net.count > 0 && this.afterNet) {
            const call = this.afterNet;
            this.afterNet = null;
            call();
        }
        if (!this.drag) this.show();
    }

    /** Calls as soon as the net is there; shows it first if need be. */
    private withNet(call: () => void): void {
        if (this.net.count > 0) {
            call();
            return;
        }
        this.afterNet = call;
        this.store.set({ net: true });
    }

    private forgetNet(): void {
        this.net.clear();
        this.netLevel = -1;
        this.hovered = -1;
        this.afterNet = null;
        this.store.set({ selection: new Set() });
    }

    private resetFields(): void {
        this.store.set({ delta: [0, 0, 0], slope: [0, 0] });
    }

    private gizmoKind(): GizmoKind {
        if (this.store.state.tool === "tilt") return "tilt";
        return this.onlyUp ? "up" : "space";
    }

    private show(): void {
        const { hello, selection, falloff, radius, profile, net } = this.store.state;
        if (!this.drag) {
            const middle =
                net && this.canEdit ? this.net.middle(this.net.placesOf(selection)) : null;
            this.gizmo.show(middle, this.gizmoKind());
        }
        const metric = hello?.raster && !hello.parametric ? "plane" : "edges";
        this.net.highlight(selection, falloff ? { radius, profile, metric } : null, this.hovered);
    }
}
