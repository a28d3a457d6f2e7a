// What buttons and keys do.

import { orbited, panned, zoomed } from "./camera";
import { confirmed } from "./confirm";
import type { Editing } from "./editing";
import type { Help } from "./help";
import { savePicture } from "./picture";
import type { Pointer } from "./pointer";
import type { Appearance } from "./appearance";
import type { ExportFormat } from "./panel/file_section";
import { movesOnlyUp, type Vector3 } from "./protocol";
import type { Session } from "./session";
import type { Action } from "./shortcuts";
import type { Colouring, Store } from "./store";
import type { Theme } from "./theme";
import type { Viewport } from "./viewport";
import type { ControlNet } from "./control_net";

const quarter = Math.PI / 2;
const turn = Math.PI / 24;
const panPixels = 60;
const colourings: readonly Colouring[] = ["plain", "height", "slope", "curvature", "error"];

export interface ActionParts {
    store: Store;
    session: Session;
    viewport: Viewport;
    net: ControlNet;
    editing: Editing;
    pointer: Pointer;
    appearance: Appearance;
    help: Help;
    theme: Theme;
}

export class Actions {
    private readonly table: Record<Action, () => void>;

    constructor(private readonly parts: ActionParts) {
        this.table = { ...this.viewActions(), ...this.showActions(), ...this.editActions() };
    }

    run(action: Action): void {
        this.table[action]();
    }

    async openFile(file: File): Promise<void> {
        const { store, session } = this.parts;
        const { history, savedAt, hello } = store.state;
        const question = `${hello?.name} has unsaved changes. Open ${file.name} and lose them?`;
        if (history.done === savedAt || (await confirmed(question, "Open")))
            await session.open(file);
    }

    drapeFile(file: File): void {
        void this.parts.session.drape(file);
    }

    exportAs(format: ExportFormat): void {
        void this.parts.session.download(format);
    }

    compress(): void {
        void this.parts.session.compress(true);
    }

    goTo(done: number): void {
        if (done !== this.parts.store.state.history.done)
            void this.parts.session.send({ do: "goto", done });
    }

    applyFields(): void {
        if (this.parts.editing.canEdit)
            void this.parts.editing.apply(this.parts.store.state.tool === "tilt");
    }

    goToLargestError(): void {
        const { store, viewport } = this.parts;
        const place = store.state.errors?.place;
        if (place) this.frameAround(place, Math.hypot(...this.extent()) / 20);
        viewport.invalidate();
    }

    private extent(): Vector3 {
        const { min, max } = this.parts.store.state.bounds;
        return max.map((m, i) => m - min[i]) as Vector3;
    }

    private frameAround(place: Vector3, radius: number): void {
        const box = (sign: number) => place.map((p) => p + sign * radius) as Vector3;
        this.parts.viewport.frame({ min: box(-1), max: box(1) });
    }

    private frame(): void {
        const { viewport, net, store } = this.parts;
        const places = net.placesOf(store.state.selection);
        const middle = net.middle(places);
        if (!middle) {
            viewport.frame();
            return;
        }
        const far = Math.max(
            ...places.map((place) =>
                Math.hypot(...net.pointAt(place).map((p, i) => p - middle[i])),
            ),
        );
        this.frameAround(middle, Math.max(far, 2 * net.typicalEdge()));
    }

    private viewActions() {
        const { viewport } = this.parts;
        const orbit = (dx: number, dy: number) => () => {
            viewport.camera = orbited(viewport.camera, dx * turn, dy * turn);
        };
        const pan = (dx: number, dy: number) => () => {
            viewport.camera = panned(
                viewport.camera,
                dx * panPixels,
                dy * panPixels,
                viewport.height,
            );
        };
        const zoom = (factor: number) => () => {
            viewport.camera = zoomed(viewport.camera, factor, 0, 0, viewport.height);
        };
        return {
            frame: () => this.frame(),
            home: () => {
                viewport.lookAgain();
                viewport.frame();
            },
            top: () => viewport.look(-quarter, quarter),
            front: () => viewport.look(-quarter, 0),
            side: () => viewport.look(0, 0),
            orbitLeft: orbit(-1, 0),
            orbitRight: orbit(1, 0),
            orbitUp: orbit(0, 1),
            orbitDown: orbit(0, -1),
            panLeft: pan(1, 0),
            panRight: pan(-1, 0),
            panUp: pan(0, 1),
            panDown: pan(0, -1),
            zoomIn: zoom(1 / 1.2),
            zoomOut: zoom(1.2),
        };
    }

    /** The level so many places finer (negative) or coarser than one. */
    private levelBeside(level: number, places: number): number {
        const levels = this.parts.store.state.hello?.levels ?? [];
        const place = levels.findIndex((info) => info.level === level) + places;
        return levels[Math.min(levels.length - 1, Math.max(0, place))]?.level ?? level;
    }

    private showActions() {
        const { store, theme, help } = this.parts;
        const level = (places: number) => () =>
            store.set({ level: this.levelBeside(store.state.level, places) });
        const net = (places: number) => () =>
            store.set({ netLevel: this.levelBeside(store.state.netLevel, places) });
        return {
            finer: level(-1),
            coarser: level(1),
            netFiner: net(-1),
            netCoarser: net(1),
            surface: () => store.set({ surface: !store.state.surface }),
            wireframe: () => store.set({ wireframe: !store.state.wireframe }),
            net: () => store.set({ net: !store.state.net }),
            original: () =>
                store.set({ shown: store.state.shown === "original" ? "edited" : "original" }),
            drape: () => {
                if (store.state.drape !== "none")
                    store.set({ drape: store.state.drape === "shown" ? "hidden" : "shown" });
            },
            colour: () => {
                const next = (colourings.indexOf(store.state.colouring) + 1) % colourings.length;
                store.set({ colouring: colourings[next] });
            },
            theme: () => theme.next(),
            help: () => help.toggle(),
        };
    }

    private editActions() {
        const { editing, session, store, viewport, appearance } = this.parts;
        const towards = (x: number, y: number) => () => editing.selectTowards({ x, y });
        const nudge = (x: number, y: number, z: number) => () => editing.nudge(x, y, z);
        const choose = (id: string) => () => document.getElementById(id)?.click();
        return {
            box: () => editing.startBox(),
            all: () => editing.selectAll(),
            none: () => this.leave(),
            grow: () => editing.grow(),
            left: towards(-1, 0),
            right: towards(1, 0),
            up: towards(0, -1),
            down: towards(0, 1),
            moveLeft: nudge(-1, 0, 0),
            moveRight: nudge(1, 0, 0),
            moveUp: nudge(0, 1, 0),
            moveDown: nudge(0, -1, 0),
            raise: nudge(0, 0, 1),
            lower: nudge(0, 0, -1),
            tilt: () => {
                if (store.state.hello?.kind === "triangles")
                    store.set({ tool: store.state.tool === "tilt" ? "move" : "tilt" });
            },
            falloff: () => store.set({ falloff: !store.state.falloff }),
            wider: () => editing.scaleRadius(1.25),
            narrower: () => editing.scaleRadius(0.8),
            undo: () => {
                if (editing.canEdit) void session.send({ do: "undo" });
            },
            redo: () => {
                if (editing.canEdit) void session.send({ do: "redo" });
            },
            open: choose("open-file"),
            save: () => {
                if (store.state.hello?.save && editing.canEdit) void session.save();
            },
            picture: () => savePicture(viewport, appearance.scale, store.state.hello),
        };
    }

    /** Escape: leaves the innermost of what is going on. */
    private leave(): void {
        const { pointer, editing } = this.parts;
        if (!pointer.cancel()) editing.selectNone();
    }
}

/** Whether a dropped file can be laid over what is open. */
export function canDrape(store: Store): boolean {
    const { hello } = store.state;
    return hello !== null && hello.kind !== "mesh" && movesOnlyUp(hello);
}
