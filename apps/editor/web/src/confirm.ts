// A question with two answers, before something is lost.

import { button, el } from "./dom";

/** True if the user agrees; Escape is a no. */
export function confirmed(question: string, yes: string): Promise<boolean> {
    return new Promise((resolve) => {
        const dialog = el("dialog", { class: "confirm", "aria-label": question });
        const agree = button(yes, () => dialog.close("yes"), { class: "primary" });
        const refuse = button("Cancel", () => dialog.close(""), { autofocus: true });
        dialog.append(el("p", {}, question), el("div", { class: "row" }, refuse, agree));
        dialog.addEventListener("close", () => {
            dialog.remove();
            resolve(dialog.returnValue === "yes");
        });
        document.body.append(dialog);
        dialog.showModal();
    });
}
