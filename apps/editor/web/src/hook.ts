// window.editor: the state of the page for tests and for the curious. Read-only.

import type { CameraState } from "./camera";
import type { ControlNet } from "./control_net";
import type { Messages } from "./messages";
import { tileKey, type Hello, type Vector3 } from "./protocol";
import type { Session } from "./session";
import type { State, Store } from "./store";
import { Terrain } from "./terrain";
import type { Viewport } from "./viewport";

export interface EditorHook {
    readonly state: Readonly<State>;
    readonly file: Readonly<Hello> | null;
    readonly level: number;
    readonly kind: string | null;
    readonly revision: number;
    readonly selection: number[];
    readonly camera: Readonly<CameraState>;
    /** Keys "j/r/c" of the tiles that are drawn. */
    readonly tiles: string[];
    readonly counts: { triangles: number; netPoints: number; frames: number };
    /** Hashes of the positions of surface and control net. */
    readonly hash: { surface: string; net: string };
    readonly pending: number;
    readonly messages: string[];
    /** Pixels of the viewport where control point `name` stands, or null if it is not loaded. */
    pixelOf(name: number): { x: number; y: number } | null;
    /** Pixels of the viewport where a point in page coordinates lies. */
    project(point: Vector3): { x: number; y: number };
    /**
     * Resolves when nothing is pending and a picture of it was drawn; rejects when the connection
     * is closed.
     */
    idle(): Promise<void>;
}

declare global {
    interface Window {
        editor: EditorHook;
    }
}

export interface HookParts {
    store: Store;
    session: Session;
    viewport: Viewport;
    net: ControlNet;
    messages: Messages;
}

function nextFrame(): Promise<void> {
    return new Promise((resolve) => requestAnimationFrame(() => resolve()));
}

/**
 * A picture may ask for finer tiles, and an answer for a picture: idle means settled for two
 * frames.
 */
async function idle(session: Session, settled: () => boolean): Promise<void> {
    for (let quiet = 0; quiet < 2; ) {
        if (session.isClosed) throw new Error("the connection is closed");
        if (settled()) await session.fence();
        await nextFrame();
        quiet = settled() ? quiet + 1 : 0;
    }
}

export function installHook({ store, session, viewport, net, messages }: HookParts): void {
    const settled = () => store.state.hello !== null && session.pending === 0 && viewport.drawn;
    const project = (point: Vector3) => {
        const [x, y] = viewport.projectPoint(point);
        return { x, y };
    };
    window.editor = {
        get state() {
            return store.state;
        },
        get file() {
            return store.state.hello;
        },
        get level() {
            return store.state.level;
        },
        get kind() {
            return store.state.hello?.kind ?? null;
        },
        get revision() {
            return store.state.revision;
        },
        get selection() {
            return [...store.state.selection].sort((a, b) => a - b);
        },
        get camera() {
            return viewport.camera;
        },
        get tiles() {
            return session.shape instanceof Terrain
                ? session.shape.shownTiles.map(tileKey).sort()
                : [];
        },
        get counts() {
            return {
                triangles: session.shape?.triangles ?? 0,
                netPoints: net.count,
                frames: viewport.frames,
            };
        },
        get hash() {
            return { surface: session.shape?.hash() ?? "", net: net.hash() };
        },
        get pending() {
            return session.pending;
        },
        get messages() {
            return messages.texts;
        },
        pixelOf(name) {
            const [place] = net.placesOf([name]);
            return place === undefined ? null : project(net.pointAt(place));
        },
        project,
        idle: () => idle(session, settled),
    };
}
