// The conversation with the server: what is open, what is shown, and what comes back.

import { Connection, failureOf, Refusal } from "./connection";
import type { ControlNet } from "./control_net";
import type { Drape } from "./drape";
import { saveBlob } from "./dom";
import { FrameError, type Frame } from "./frame";
import { MeshSurface } from "./mesh_surface";
import type { Messages } from "./messages";
import type {
    Answer,
    Changed,
    CompressAnswer,
    Edit,
    ErrorsAnswer,
    Extra,
    Hello,
    SaveAnswer,
    ServerEvent,
} from "./protocol";
import { netWindow, windowLeft, type NetWindow } from "./net_window";
import type { ExportFormat } from "./panel/file_section";
import type { Shape } from "./shape";
import { startState } from "./start_state";
import type { Store } from "./store";
import type { SurfaceMaterial } from "./surface_material";
import { Terrain } from "./terrain";
import type { Viewport } from "./viewport";

export interface Parts {
    store: Store;
    viewport: Viewport;
    net: ControlNet;
    material: SurfaceMaterial;
    messages: Messages;
    drape: Drape;
}

export class Session {
    shape: Shape | null = null;
    private readonly connection: Connection;
    private readonly geometryWatchers: (() => void)[] = [];
    private viewAsked = "";
    private viewBusy = false;
    private netAsked = "";
    private window: NetWindow | null = null;
    private errorsBusy = false;
    private errorsAgain = false;
    private lastCompress = 0;
    /** The question whose progress the status bar shows. */
    private inProgress = 0;
    /** Requests over HTTP that are not answered. */
    private transfers = 0;

    constructor(
        address: string,
        private readonly parts: Parts,
    ) {
        this.connection = new Connection(address, {
            event: (event) => this.event(event),
            frame: (frame) => this.frame(frame),
            answered: (id) => {
                if (id === this.inProgress) parts.store.set({ busy: "" });
            },
            closed: () => this.closed(),
            broken: (message) => parts.messages.error(message),
        });
        const keys = ["hello", "level", "shown", "colouring", "net", "netLevel"] as const;
        parts.store.watch(keys, () => this.updateView());
        parts.viewport.onDraw(() => {
            this.followWindow();
            this.shape?.prepare();
        });
    }

    get isClosed(): boolean {
        return this.connection.isClosed;
    }

    get pending(): number {
        return this.connection.pending + this.transfers;
    }

    /** Calls whenever vertices or control points have come. */
    onGeometry(call: () => void): void {
        this.geometryWatchers.push(call);
    }

    /** Sends a command or a question whose refusal is shown as a message. */
    async send<T extends Answer>(message: object, frames = 0): Promise<T | null> {
        try {
            return await this.connection.send<T>(message, frames);
        } catch (reason) {
            this.failed(reason);
            return null;
        }
    }

    edit(edit: Edit): Promise<Answer | null> {
        return this.send(edit);
    }

    /**
     * Everything that was sent before is answered, and what it changed has come: an empty question
     * comes back.
     */
    async fence(): Promise<void> {
        // Kinds without tiles refuse it, which is an answer too.
        if (this.parts.store.state.connected)
            await this.connection.send({ ask: "forget", tiles: [] }).catch(() => null);
    }

    async save(): Promise<void> {
        const answer = await this.send<SaveAnswer>({ ask: "save" });
        if (!answer) return;
        this.parts.store.set({ savedAt: this.parts.store.state.history.done });
        this.parts.messages.notice(`Saved ${answer.path}.`);
    }

    /** Sends a file to take the place of the open one. */
    async open(file: File): Promise<void> {
        const { store, messages } = this.parts;
        store.set({ busy: `Opening ${file.name} \u2026` });
        ++this.transfers;
        try {
            const response = await fetch(`open?name=${encodeURIComponent(file.name)}`, {
                method: "POST",
                body: file,
            });
            if (!response.ok) throw new Refusal(await failureOf(response));
            messages.clear();
        } catch (reason) {
            this.failed(reason);
        }
        --this.transfers;
        store.set({ busy: "" });
    }

    async drape(file: File): Promise<void> {
        ++this.transfers;
        try {
            await this.parts.drape.load(file);
        } catch (reason) {
            this.failed(reason);
        }
        --this.transfers;
    }

    /** Saves the surface in another format through the browser. */
    async download(format: ExportFormat): Promise<void> {
        const { store } = this.parts;
        store.set({ busy: "Exporting \u2026" });
        ++this.transfers;
        try {
            const response = await fetch(`export?format=${format}`);
            if (!response.ok) throw new Refusal(await failureOf(response));
            const stem = (store.state.hello?.name ?? "surface").replace(/\.[^.]*$/, "");
            saveBlob(await response.blob(), `${stem}.${format === "script" ? "json" : format}`);
        } catch (reason) {
            this.failed(reason);
        }
        --this.transfers;
        store.set({ busy: "" });
    }

    /** Encodes at the bound of the state; of several in a row only the last one counts. */
    async compress(show: boolean): Promise<void> {
        const { store } = this.parts;
        const number = ++this.lastCompress;
        store.set({ busy: "Compressing \u2026" });
        try {
            const answer = await this.connection.send<CompressAnswer>({
                ask: "compress",
                max_error: store.state.bound,
            });
            if (number === this.lastCompress) this.compressed(answer, show);
        } catch (reason) {
            if (!(reason instanceof Refusal && reason.failure?.code === "cancelled"))
                this.failed(reason);
        }
        if (number === this.lastCompress) store.set({ busy: "" });
    }

    private compressed(answer: CompressAnswer, show: boolean): void {
        const { store } = this.parts;
        store.set({ compressed: answer });
        if (!show && store.state.shown !== "compressed") return;
        // What is shown under this name is now something else.
        if (store.state.shown === "compressed") this.viewAsked = "";
        store.set({ shown: "compressed" });
        this.updateView();
    }

    failed = (reason: unknown): void => {
        this.parts.messages.error(reason instanceof Error ? reason.message : String(reason));
    };

    private event(event: ServerEvent): void {
        const { store, messages } = this.parts;
        switch (event.event) {
            case "hello":
                this.hello(event);
                break;
            case "changed":
                this.changed(event);
                break;
            case "progress":
                this.inProgress = event.id;
                store.set({ busy: `Working \u2026 ${Math.round(100 * event.fraction)} %` });
                break;
            case "notice":
                messages.notice(event.message);
                break;
            case "closing":
                messages.error("The program ends. What was not saved is lost.");
                break;
        }
    }

    private hello(hello: Hello): void {
        const { store, viewport, net, material, messages, drape } = this.parts;
        if (hello.protocol !== 1)
            messages.error(
                `The server speaks version ${hello.protocol} of the protocol, this page 1.`,
            );
        this.shape?.dispose();
        this.shape?.object.removeFromParent();
        this.shape = null;
        net.clear();
        drape.clear();
        this.viewAsked = "";
        this.netAsked = "";
        viewport.setBounds(hello.min, hello.max);
        store.set(startState(hello));
        this.shape = hello.raster
            ? new Terrain(hello, hello.raster, this.connection, viewport, material, this.failed)
            : new MeshSurface(viewport, material);
        viewport.world.add(this.shape.object);
        viewport.lookAgain();
        viewport.frame();
        this.geometry();
    }

    private changed(changed: Changed): void {
        const { store, viewport } = this.parts;
        viewport.setBounds(changed.min, changed.max);
        store.set({
            bounds: { min: changed.min, max: changed.max },
            revision: changed.revision,
            history: changed.history,
            compressed: null,
        });
        if (store.state.shown === "compressed") store.set({ shown: "edited" });
        if (store.state.colouring === "error") void this.measureErrors();
    }

    private frame(frame: Frame): void {
        try {
            if (frame.what === "net") {
                if (this.parts.store.state.net) this.parts.net.take(frame);
            } else if (this.shape && !this.shape.take(frame)) {
                throw new FrameError(`"${frame.what}" does not belong to this file`);
            }
        } catch (error) {
            if (!(error instanceof FrameError)) throw error;
            this.parts.messages.error(`The server sent something unreadable: ${error.message}.`);
        }
        this.geometry();
    }

    private geometry(): void {
        for (const call of this.geometryWatchers) call();
    }

    private closed(): void {
        this.parts.store.set({ connected: false, busy: "" });
        this.parts.messages.error(
            "The connection to the program is lost. Start it again and open the address it prints.",
        );
    }

    /** Tells the server what is shown, if that has changed; one question at a time. */
    private updateView(): void {
        const { state } = this.parts.store;
        if (!state.hello || !state.connected || this.viewBusy) return;
        const raster = state.hello.raster !== undefined;
        const withNet = state.net && !raster;
        const extras: Extra[] =
            state.colouring === "error" || state.colouring === "curvature" ? [state.colouring] : [];
        const view = {
            ask: "view",
            level: state.level,
            show: state.shown,
            with: extras,
            net: withNet,
            ...(withNet ? { net_level: state.netLevel } : {}),
        };
        const key = JSON.stringify(view);
        if (key !== this.viewAsked) {
            this.viewAsked = key;
            this.viewBusy = true;
            void this.send(view, raster ? 0 : withNet ? 2 : 1).then(() => {
                this.viewBusy = false;
                this.updateView();
            });
            this.shape?.refresh();
            if (extras[0] === "error") void this.measureErrors();
            else this.parts.store.set({ errors: null });
        }
        if (!state.net) this.parts.net.clear();
        if (raster) this.updateNet();
    }

    private updateNet(): void {
        const { store, viewport } = this.parts;
        const { hello, net, netLevel, shown } = store.state;
        if (!hello) return;
        if (!net) {
            if (this.netAsked !== "") void this.send({ ask: "net", level: null });
            this.netAsked = "";
            return;
        }
        const info = hello.levels.find((level) => level.level === netLevel);
        this.window = netWindow(hello, info, viewport.camera.target);
        const question = {
            ask: "net",
            level: netLevel,
            ...(this.window ? { window: this.window } : {}),
        };
        const key = JSON.stringify([question, shown]);
        if (key === this.netAsked) return;
        this.netAsked = key;
        void this.send(question, 1);
    }

    /** Asks for another window of a large net when the camera looks elsewhere. */
    private followWindow(): void {
        const { hello, net, netLevel } = this.parts.store.state;
        if (!hello || !net || !this.window) return;
        if (windowLeft(hello, netLevel, this.window, this.parts.viewport.camera.target))
            this.updateNet();
    }

    private async measureErrors(): Promise<void> {
        this.errorsAgain = true;
        if (this.errorsBusy) return;
        this.errorsBusy = true;
        while (this.errorsAgain) {
            this.errorsAgain = false;
            const errors = await this.send<ErrorsAnswer>({ ask: "errors" });
            if (this.parts.store.state.colouring === "error") this.parts.store.set({ errors });
        }
        this.errorsBusy = false;
    }
}
