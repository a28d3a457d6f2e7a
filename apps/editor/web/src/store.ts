// The state that panels, shortcuts and the viewport share.

import type {
    CompressAnswer,
    ErrorsAnswer,
    Hello,
    History,
    Profile,
    Shown,
    Vector3,
} from "./protocol";

export type Colouring = "plain" | "height" | "slope" | "curvature" | "error";
export type Tool = "move" | "tilt";

export interface State {
    hello: Hello | null;
    /** Where the geometry lies now, in page coordinates. */
    bounds: { min: Vector3; max: Vector3 };
    connected: boolean;
    revision: number;
    history: History;
    /** Number of commands in effect when the file was last saved. */
    savedAt: number;

    level: number;
    netLevel: number;
    shown: Shown;
    colouring: Colouring;
    surface: boolean;
    wireframe: boolean;
    net: boolean;
    exaggeration: number;
    drape: "none" | "shown" | "hidden";

    tool: Tool;
    boxSelecting: boolean;
    dragging: boolean;
    selection: ReadonlySet<number>;
    falloff: boolean;
    radius: number;
    profile: Profile;
    step: number;
    /** What a drag has moved so far, or what the fields say. */
    delta: [number, number, number];
    slope: [number, number];

    bound: number;
    compressed: CompressAnswer | null;
    errors: ErrorsAnswer | null;
    busy: string;
}

export const initialState: State = {
    hello: null,
    bounds: { min: [0, 0, 0], max: [1, 1, 1] },
    connected: false,
    revision: 0,
    history: { done: 0, entries: [] },
    savedAt: 0,
    level: 0,
    netLevel: 0,
    shown: "edited",
    colouring: "plain",
    surface: true,
    wireframe: false,
    net: false,
    exaggeration: 1,
    drape: "none",
    tool: "move",
    boxSelecting: false,
    dragging: false,
    selection: new Set(),
    falloff: false,
    radius: 1,
    profile: "smooth",
    step: 1,
    delta: [0, 0, 0],
    slope: [0, 0],
    bound: 1,
    compressed: null,
    errors: null,
    busy: "",
};

type Key = keyof State;

interface Watcher {
    keys: readonly Key[];
    call(state: State): void;
}

export class Store {
    private current: State = initialState;
    private readonly watchers: Watcher[] = [];

    get state(): Readonly<State> {
        return this.current;
    }

    /** Changes some members, and calls those who watch one that is now different. */
    set(change: Partial<State>): void {
        const before = this.current;
        this.current = { ...before, ...change };
        const changed = (Object.keys(change) as Key[]).filter(
            (key) => before[key] !== this.current[key],
        );
        if (changed.length === 0) return;
        for (const watcher of this.watchers) {
            if (watcher.keys.some((key) => changed.includes(key))) watcher.call(this.current);
        }
    }

    /** Calls now and whenever one of `keys` changes. */
    watch(keys: readonly Key[], call: (state: State) => void): void {
        this.watchers.push({ keys, call });
        call(this.current);
    }
}
