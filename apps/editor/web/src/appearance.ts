// Applies the state and the theme to what is drawn: colours, ranges, light, lines.

import { basis } from "./camera";
import {
    curvatureMap,
    errorMap,
    heightMap,
    parseColour,
    slopeMap,
    type ColourMap,
} from "./colour_maps";
import type { ControlNet } from "./control_net";
import type { Drape } from "./drape";
import { roundUp } from "./format";
import { movesOnlyUp, type Vector3 } from "./protocol";
import type { Session } from "./session";
import type { State, Store } from "./store";
import type { SurfaceMaterial } from "./surface_material";
import type { Viewport } from "./viewport";

export interface Scale {
    title: string;
    unit: string;
    map: ColourMap;
    quantity: "height" | "slope" | "value";
    /** In page coordinates; `offset` is added to what the legend says. */
    low: number;
    high: number;
    offset: number;
}

/** Light from the upper left: north-west and 45 degrees high on a map. */
const mapSun: Vector3 = [-0.5, 0.5, Math.SQRT1_2];

function aroundZero(title: string, unit: string, map: ColourMap, largest: number): Scale {
    const high = roundUp(largest);
    return { title, unit, map, quantity: "value", low: -high, high, offset: 0 };
}

/** The colours by value of the state, or null if the surface is plain. */
export function scaleOf(state: State, largestValue: number): Scale | null {
    const { hello, bounds, colouring, errors } = state;
    if (!hello) return null;
    switch (colouring) {
        case "plain":
            return null;
        case "height":
            return {
                title: "Height",
                unit: hello.unit,
                map: heightMap,
                quantity: "height",
                low: bounds.min[2],
                high: bounds.max[2],
                offset: hello.origin[2],
            };
        case "slope": {
            const high = movesOnlyUp(hello) ? 60 : 180;
            return {
                title: "Slope",
                unit: "\u00b0",
                map: slopeMap,
                quantity: "slope",
                low: 0,
                high,
                offset: 0,
            };
        }
        case "curvature": {
            const unit = hello.unit ? `1/${hello.unit}` : "";
            return aroundZero("Mean curvature", unit, curvatureMap, largestValue);
        }
        case "error":
            return aroundZero("Error", hello.unit, errorMap, errors?.max_error || largestValue);
    }
}

/** A colour that the theme's stylesheet gives. */
function themeColour(name: string): string {
    return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

export class Appearance {
    private readonly watchers: ((scale: Scale | null) => void)[] = [];
    scale: Scale | null = null;

    constructor(
        private readonly store: Store,
        private readonly session: Session,
        private readonly viewport: Viewport,
        private readonly material: SurfaceMaterial,
        private readonly net: ControlNet,
        private readonly drape: Drape,
    ) {
        const keys = [
            "hello",
            "level",
            "colouring",
            "errors",
            "surface",
            "wireframe",
            "exaggeration",
            "drape",
        ] as const;
        store.watch(keys, () => this.apply());
        // Colours do not change under a point that is being dragged.
        store.watch(["bounds", "dragging"], ({ dragging }) => {
            if (!dragging) this.colour();
        });
        session.onGeometry(() => {
            if (store.state.colouring === "curvature" || store.state.colouring === "error")
                this.colour();
            this.edges();
        });
        viewport.onDraw(() => this.light());
    }

    /** Calls now and whenever the colours by value change. */
    onScale(call: (scale: Scale | null) => void): void {
        this.watchers.push(call);
        call(this.scale);
    }

    /** After a change of theme, too. */
    apply(): void {
        const { hello, surface, exaggeration, drape } = this.store.state;
        const hex = (name: string) => parseInt(themeColour(name).slice(1), 16);
        this.material.plain = parseColour(themeColour("--surface-plain"));
        this.material.exaggeration = exaggeration;
        this.material.twoSided = hello !== null && !(hello.raster && !hello.parametric);
        this.material.filled = surface;
        this.material.setDrape(drape === "shown" ? this.drape.texture : null, this.drape.rect);
        if (this.viewport.exaggeration !== exaggeration) this.viewport.exaggeration = exaggeration;
        this.net.setColours({
            point: hex("--net-point"),
            line: hex("--net-line"),
            selected: hex("--net-selected"),
            triangle: hex("--net-triangle"),
        });
        this.colour();
        this.edges();
        this.viewport.invalidate();
    }

    private colour(): void {
        const scale = scaleOf(this.store.state, this.session.shape?.largestValue() ?? 0);
        // Under an image colours say nothing.
        this.scale = this.store.state.drape === "shown" ? null : scale;
        this.material.setColouring(
            scale?.quantity ?? "height",
            scale?.map ?? null,
            scale?.low ?? 0,
            scale?.high ?? 1,
        );
        for (const call of this.watchers) call(this.scale);
        this.viewport.invalidate();
    }

    private edges(): void {
        const { hello, surface, wireframe, level } = this.store.state;
        const lines = wireframe || !surface;
        const colour = parseColour(themeColour(surface ? "--wire-over" : "--wire-alone"));
        const shape = this.session.shape;
        if (hello?.raster) {
            // Without faces and lines there is nothing at all.
            if (shape) shape.object.visible = surface || wireframe;
            this.material.grid = { step: lines ? 2 ** level : 0, colour };
            return;
        }
        this.material.grid = { step: 0, colour };
        shape?.setFaces(surface);
        shape?.setEdges(wireframe, (colour[0] << 16) | (colour[1] << 8) | colour[2]);
    }

    /**
     * The sun stands still over a map; other surfaces are lit from behind the viewer's left
     * shoulder.
     */
    private light(): void {
        const { hello } = this.store.state;
        const { eye, right, up, back } = basis(this.viewport.camera);
        const shoulder = right.map((r, i) => -0.45 * r + 0.5 * up[i] + 0.74 * back[i]);
        this.material.setLight(hello?.raster && !hello.parametric ? mapSun : shoulder, eye);
    }
}
