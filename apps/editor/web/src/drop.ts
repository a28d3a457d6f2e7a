// Files dropped on the page: opened, or laid over terrain.

import { canDrape, type Actions } from "./actions";
import { el } from "./dom";
import type { Store } from "./store";

function zone(title: string, text: string, dropped: (file: File) => void): HTMLElement {
    const element = el("div", { class: "zone" }, el("strong", {}, title), el("span", {}, text));
    element.addEventListener("dragenter", () => element.classList.add("over"));
    element.addEventListener("dragleave", () => element.classList.remove("over"));
    element.addEventListener("drop", (event) => {
        const file = event.dataTransfer?.files[0];
        element.classList.remove("over");
        if (file) dropped(file);
    });
    return element;
}

export function dropZones(store: Store, actions: Actions): HTMLElement {
    const open = zone("Open", "in place of this file", (file) => void actions.openFile(file));
    const drape = zone("Drape", "as an image over the terrain", (file) => actions.drapeFile(file));
    const element = el("div", { class: "drop", hidden: true }, open, drape);
    const hasFiles = (event: DragEvent) => event.dataTransfer?.types.includes("Files") ?? false;
    document.addEventListener("dragover", (event) => {
        if (!hasFiles(event)) return;
        event.preventDefault();
        drape.hidden = !canDrape(store);
        element.hidden = false;
    });
    document.addEventListener("dragleave", (event) => {
        if (event.relatedTarget === null) element.hidden = true;
    });
    document.addEventListener("drop", (event) => {
        event.preventDefault();
        element.hidden = true;
    });
    return element;
}
