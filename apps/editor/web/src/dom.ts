// Building the document.

type Attributes = Record<string, string | number | boolean | ((event: never) => void)>;

/** An element with attributes, `onclick` and its like as functions, and children. */
export function el<K extends keyof HTMLElementTagNameMap>(
    tag: K,
    attributes: Attributes = {},
    ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
        if (typeof value === "function")
            element.addEventListener(name.slice(2), value as EventListener);
        else if (typeof value === "boolean") element.toggleAttribute(name, value);
        else element.setAttribute(name, String(value));
    }
    element.append(...children);
    return element;
}

let ids = 0;

/** A name that no other element has. */
export function freshId(): string {
    return `control-${++ids}`;
}

export function button(
    text: string,
    click: () => void,
    attributes: Attributes = {},
): HTMLButtonElement {
    return el("button", { type: "button", onclick: click, ...attributes }, text);
}

export function row(...children: (Node | string)[]): HTMLDivElement {
    return el("div", { class: "row" }, ...children);
}

export function section(title: string, ...children: (Node | string)[]): HTMLDetailsElement {
    const body = el("div", { class: "body" }, ...children);
    return el(
        "details",
        { open: true, id: `section-${title.toLowerCase()}` },
        el("summary", {}, title),
        body,
    );
}

export interface Field {
    element: HTMLElement;
    input: HTMLInputElement;
    show(value: string): void;
}

/** A number with its label. `entered` is called with finite numbers that the user has confirmed. */
export function numberField(
    label: string,
    entered: (value: number) => void,
    attributes: Attributes = {},
): Field {
    const input = el("input", { type: "number", step: "any", id: freshId(), ...attributes });
    const confirm = () => {
        if (Number.isFinite(input.valueAsNumber) && input.checkValidity())
            entered(input.valueAsNumber);
    };
    input.addEventListener("change", confirm);
    const element = el("div", { class: "field" }, el("label", { for: input.id }, label), input);
    return {
        element,
        input,
        show: (value) => {
            if (input.value !== value) input.value = value;
        },
    };
}

export function checkbox(label: string, changed: (checked: boolean) => void): Field {
    const input = el("input", { type: "checkbox", onchange: () => changed(input.checked) });
    return {
        element: el("label", { class: "check" }, input, el("span", {}, label)),
        input,
        show: (value) => {
            input.checked = value === "true";
        },
    };
}

export interface Choice<T extends string> {
    element: HTMLElement;
    show(value: T): void;
    enable(value: T, enabled: boolean): void;
}

/** One of a few values, all in sight. */
export function segments<T extends string>(
    label: string,
    values: readonly [T, string][],
    chosen: (value: T) => void,
): Choice<T> {
    const name = freshId();
    const inputs = new Map<T, HTMLInputElement>();
    const element = el("div", { class: "segments", role: "radiogroup", "aria-label": label });
    for (const [value, text] of values) {
        const input = el("input", { type: "radio", name, value, onchange: () => chosen(value) });
        inputs.set(value, input);
        element.append(el("label", {}, input, el("span", {}, text)));
    }
    return {
        element,
        show: (value) => {
            for (const [key, input] of inputs) input.checked = key === value;
        },
        enable: (value, enabled) => {
            (inputs.get(value) as HTMLInputElement).disabled = !enabled;
        },
    };
}

export interface Select<T extends string> {
    element: HTMLElement;
    input: HTMLSelectElement;
    show(value: T): void;
}

export function select<T extends string>(
    label: string,
    values: readonly [T, string][],
    chosen: (value: T) => void,
    id = freshId(),
): Select<T> {
    const input = el("select", { id, onchange: () => chosen(input.value as T) });
    for (const [value, text] of values) input.append(el("option", { value }, text));
    return {
        element: el("div", { class: "field" }, el("label", { for: id }, label), input),
        input,
        show: (value) => {
            input.value = value;
        },
    };
}

/** A slider whose steps multiply: from `low` to `high`, both above 0. */
export function ratioSlider(label: string, moved: (value: number) => void) {
    let [low, high] = [1, 10];
    const input = el("input", { type: "range", min: 0, max: 1000, step: 1, "aria-label": label });
    const valueOf = () => low * (high / low) ** (input.valueAsNumber / 1000);
    input.addEventListener("input", () => moved(Number(valueOf().toPrecision(2))));
    return {
        input,
        setRange(least: number, most: number) {
            [low, high] = [least, most];
        },
        show(value: number, text: string) {
            const place = (1000 * Math.log(value / low)) / Math.log(high / low);
            input.value = String(Math.round(Math.min(1000, Math.max(0, place))));
            input.setAttribute("aria-valuetext", text);
        },
    };
}

/** Gives a file to the browser's downloads. */
export function saveBlob(blob: Blob, name: string): void {
    const link = el("a", { href: URL.createObjectURL(blob), download: name });
    link.click();
    // The browser has begun to read it by then.
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}
