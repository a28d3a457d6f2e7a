// The scale of colours with its values, as drawn in the viewport and on saved pictures.

import type { Scale } from "./appearance";
import { colourAt } from "./colour_maps";
import { el } from "./dom";
import * as format from "./format";

export const legendWidth = 260;
export const legendHeight = 58;
const margin = 14;
const barTop = 24;
const barHeight = 10;

interface Ink {
    text: string;
    font: string;
}

/** What the ticks say: enough digits to tell them apart. */
function tickTexts(values: readonly number[]): string[] {
    const step = values.length > 1 ? Math.abs(values[1] - values[0]) : 1;
    const largest = Math.max(...values.map(Math.abs));
    const digits = Math.max(2, Math.ceil(Math.log10(Math.max(largest / step, 1))) + 1);
    return values.map((value) =>
        format.number(Math.abs(value) < step * 1e-9 ? 0 : value, Math.max(digits, 4)),
    );
}

/** Draws the legend into a rectangle of legendWidth x legendHeight at the origin. */
export function drawLegend(context: CanvasRenderingContext2D, scale: Scale, ink: Ink): void {
    const width = legendWidth - 2 * margin;
    for (let x = 0; x < width; ++x) {
        context.fillStyle = `rgb(${colourAt(scale.map, x / (width - 1)).join(" ")})`;
        context.fillRect(margin + x, barTop, 1, barHeight);
    }
    context.font = `600 12px ${ink.font}`;
    context.fillStyle = ink.text;
    context.textBaseline = "alphabetic";
    context.textAlign = "left";
    context.fillText(scale.unit ? `${scale.title} (${scale.unit})` : scale.title, margin, 16);
    context.font = `11px ${ink.font}`;
    const [low, high] = [scale.low + scale.offset, scale.high + scale.offset];
    const values = format.ticks(low, high, 5);
    const texts = tickTexts(values);
    let free = 0;
    values.forEach((value, i) => {
        const x = margin + (width * (value - low)) / (high - low || 1);
        context.fillRect(Math.round(x), barTop + barHeight, 1, 4);
        const half = context.measureText(texts[i]).width / 2;
        const middle = Math.min(legendWidth - half - 8, Math.max(half + 8, x));
        if (middle - half < free) return;
        context.fillText(texts[i], middle - half, barTop + barHeight + 16);
        free = middle + half + 8;
    });
}

export class Legend {
    readonly element = el("canvas", { class: "legend", role: "img" });
    private scale: Scale | null = null;

    show(scale: Scale | null): void {
        this.scale = scale;
        this.element.hidden = scale === null;
        if (!scale) return;
        const unit = scale.unit;
        this.element.setAttribute(
            "aria-label",
            `${scale.title}: colours from ${format.measured(
                scale.low + scale.offset,
                unit,
            )} to ${format.measured(scale.high + scale.offset, unit)}`,
        );
        const ratio = Math.min(window.devicePixelRatio, 2);
        this.element.width = legendWidth * ratio;
        this.element.height = legendHeight * ratio;
        this.element.style.width = `${legendWidth}px`;
        this.element.style.height = `${legendHeight}px`;
        const context = this.element.getContext("2d") as CanvasRenderingContext2D;
        context.scale(ratio, ratio);
        const style = getComputedStyle(document.documentElement);
        drawLegend(context, scale, {
            text: style.getPropertyValue("--text").trim(),
            font: "system-ui, sans-serif",
        });
    }

    /** After a change of theme. */
    redraw(): void {
        this.show(this.scale);
    }
}
