// How a file is shown when it was opened.

import { roundUp } from "./format";
import { movesOnlyUp, type Hello } from "./protocol";
import type { State } from "./store";

/** Height over width. */
const steepest = 0.7;

/** Nets of more points are not chosen by themselves. */
const handyNet = 1600;

/**
 * A round exaggeration that makes heights a twentieth of the width at least, and at most 0.7 of
 * it; 1 if they are.
 */
function handyExaggeration(hello: Hello): number {
    const [wide, deep, high] = hello.max.map((m, i) => m - hello.min[i]);
    const ratio = high / Math.max(wide, deep);
    if (!movesOnlyUp(hello) || !(ratio > 0)) return 1;
    if (ratio < 0.04) return roundUp(0.05 / ratio);
    return ratio > steepest ? 1 / roundUp(ratio / steepest) : 1;
}

export function startState(hello: Hello): Partial<State> {
    const height = hello.max[2] - hello.min[2];
    const handy = hello.levels.find((level) => level.control_points <= handyNet);
    return {
        hello,
        bounds: { min: hello.min, max: hello.max },
        connected: true,
        revision: hello.revision,
        history: hello.history,
        savedAt: hello.history.done,
        level: hello.levels[0]?.level ?? 0,
        netLevel: (handy ?? hello.levels[hello.levels.length - 1])?.level ?? 0,
        shown: "edited",
        colouring: hello.kind === "raster" && !hello.parametric ? "height" : "plain",
        surface: true,
        net: false,
        exaggeration: handyExaggeration(hello),
        drape: "none",
        tool: "move",
        boxSelecting: false,
        dragging: false,
        selection: new Set(),
        step: roundUp(height / 200),
        delta: [0, 0, 0],
        slope: [0, 0],
        bound: hello.bound || roundUp(height / 2000),
        compressed: null,
        errors: null,
        busy: "",
    };
}
