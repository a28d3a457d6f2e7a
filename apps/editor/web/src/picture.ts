// Saves what is seen as a PNG, with the legend.

import type { Scale } from "./appearance";
import { saveBlob } from "./dom";
import { drawLegend, legendHeight, legendWidth } from "./legend";
import type { Hello } from "./protocol";
import type { Viewport } from "./viewport";

export function savePicture(viewport: Viewport, scale: Scale | null, hello: Hello | null): void {
    const canvas = document.createElement("canvas");
    canvas.width = viewport.canvas.width;
    canvas.height = viewport.canvas.height;
    const context = canvas.getContext("2d") as CanvasRenderingContext2D;
    const style = getComputedStyle(document.documentElement);
    context.fillStyle = style.getPropertyValue("--viewport").trim();
    context.fillRect(0, 0, canvas.width, canvas.height);
    // What was drawn is gone once the page has been composed: draw again, and take it at once.
    viewport.draw();
    context.drawImage(viewport.canvas, 0, 0);
    if (scale) {
        context.scale(viewport.pixelRatio, viewport.pixelRatio);
        context.translate(12, viewport.height - legendHeight - 12);
        context.globalAlpha = 0.85;
        context.fillStyle = style.getPropertyValue("--panel").trim();
        context.fillRect(0, 0, legendWidth, legendHeight);
        context.globalAlpha = 1;
        drawLegend(context, scale, {
            text: style.getPropertyValue("--text").trim(),
            font: "system-ui, sans-serif",
        });
    }
    canvas.toBlob((blob) => {
        if (blob) saveBlob(blob, `${(hello?.name ?? "surface").replace(/\.[^.]*$/, "")}.png`);
    }, "image/png");
}
