// A small cross of axes that turns with the camera; its ends look along them.

import { basis } from "./camera";
import { el } from "./dom";
import type { Vector3 } from "./protocol";
import type { Viewport } from "./viewport";

const size = 72;
const arm = 25;
const quarter = Math.PI / 2;

interface End {
    axis: Vector3;
    button: HTMLButtonElement;
    line: HTMLElement | null;
}

function makeEnd(
    viewport: Viewport,
    name: string,
    label: string,
    axis: Vector3,
    azimuth: number | null,
    elevation: number,
): End {
    const negative = name.startsWith("-");
    const look = () => viewport.look(azimuth ?? -quarter, elevation);
    const button = el(
        "button",
        {
            type: "button",
            class: `axis ${name.slice(-1)} ${negative ? "negative" : ""}`,
            "aria-label": label,
            title: label,
            onclick: look,
        },
        negative ? "" : name,
    );
    return { axis, button, line: negative ? null : el("span", { class: `line ${name}` }) };
}

/** The element, and keeps it up to date. */
export function axesCross(viewport: Viewport): HTMLElement {
    const ends = [
        makeEnd(viewport, "x", "From the east (along x)", [1, 0, 0], 0, 0),
        makeEnd(viewport, "-x", "From the west", [-1, 0, 0], Math.PI, 0),
        makeEnd(viewport, "y", "From the north (along y)", [0, 1, 0], quarter, 0),
        makeEnd(viewport, "-y", "From the south", [0, -1, 0], -quarter, 0),
        makeEnd(viewport, "z", "From above", [0, 0, 1], null, quarter),
        makeEnd(viewport, "-z", "From below", [0, 0, -1], null, -quarter),
    ];
    const element = el("div", { class: "axes", role: "group", "aria-label": "Directions of view" });
    for (const end of ends) element.append(...(end.line ? [end.line] : []), end.button);
    viewport.onDraw(() => {
        const { right, up, back } = basis(viewport.camera);
        for (const { axis, button, line } of ends) {
            const along = (v: Vector3) => v[0] * axis[0] + v[1] * axis[1] + v[2] * axis[2];
            const [x, y, depth] = [arm * along(right), -arm * along(up), along(back)];
            const place = `translate(${size / 2 + x}px, ${size / 2 + y}px)`;
            button.style.transform = `${place} translate(-50%, -50%)`;
            button.style.zIndex = String(10 + Math.round(5 * depth));
            if (line)
                line.style.transform = [
                    `translate(${size / 2}px, ${size / 2}px)`,
                    `rotate(${Math.atan2(y, x)}rad)`,
                    `scaleX(${Math.hypot(x, y)})`,
                ].join(" ");
        }
    });
    return element;
}
