// Keys of the page become actions.

import type { Actions } from "./actions";
import { actionOf, belongsToControl } from "./shortcuts";

export function listenToKeys(actions: Actions): void {
    document.addEventListener("keydown", (event) => {
        const target = event.target instanceof HTMLElement ? event.target : document.body;
        const control = {
            tag: target.tagName,
            type: target instanceof HTMLInputElement ? target.type : "",
        };
        const action = actionOf(event);
        if (!action || belongsToControl(event, control)) return;
        // Dialogs close by themselves on Escape.
        if (document.querySelector("dialog[open]") && action !== "help") return;
        event.preventDefault();
        actions.run(action);
    });
}
