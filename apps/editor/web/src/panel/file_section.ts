import { button, el, row, section, select } from "../dom";
import * as format from "../format";
import { movesOnlyUp, type Hello } from "../protocol";
import type { Panel } from "./panel";

export type ExportFormat = "relief" | "script" | "tif" | "glb" | "obj" | "ply";

const formats: readonly [ExportFormat, string][] = [
    ["relief", "relief (.relief)"],
    ["tif", "GeoTIFF (.tif)"],
    ["glb", "glTF (.glb)"],
    ["obj", "Wavefront (.obj)"],
    ["ply", "Stanford (.ply)"],
    ["script", "Script of the edits (.json)"],
];

const kinds: Record<Hello["kind"], string> = {
    raster: "Raster",
    mesh: "Subdivision mesh",
    quads: "Cubic spline over quads",
    triangles: "Powell\u2013Sabin spline",
};

function describe(hello: Hello): string {
    const size = hello.raster
        ? `${format.count(hello.raster.rows)} \u00d7 ${format.count(hello.raster.cols)} samples`
        : "";
    // Splines on triangles are of one scheme.
    const scheme =
        hello.scheme && hello.kind !== "triangles"
            ? `${hello.scheme}${hello.order ? ` of order ${hello.order}` : ""}`
            : "";
    return [
        kinds[hello.kind],
        size,
        scheme,
        format.crs(hello.crs),
        hello.bytes ? format.bytes(hello.bytes) : "",
    ]
        .filter((part) => part !== "")
        .join(" \u00b7 ");
}

/** Opens a file chooser whose choice goes to `chosen`. */
function chooser(accept: string, label: string, chosen: (file: File) => void): HTMLInputElement {
    const input = el("input", {
        type: "file",
        accept,
        hidden: true,
        "aria-label": label,
        tabindex: -1,
    });
    input.addEventListener("change", () => {
        const file = input.files?.[0];
        input.value = "";
        if (file) chosen(file);
    });
    return input;
}

export function fileSection({ store, actions }: Panel): HTMLElement {
    const name = el("p", { class: "name" });
    const about = el("p", { class: "dim" });
    const openInput = chooser("", "File to open", (file) => void actions.openFile(file));
    const drapeInput = chooser("image/*,.tif,.tiff", "Image to drape", (file) =>
        actions.drapeFile(file),
    );
    openInput.id = "open-file";
    drapeInput.id = "drape-file";
    const open = button("Open\u2026", () => openInput.click(), {
        title: "Ctrl+O, or drop a file on the page",
    });
    const save = button("Save", () => actions.run("save"), { title: "Ctrl+S" });
    const drape = button("Drape\u2026", () => drapeInput.click(), {
        title: "Lay an image over the terrain",
    });
    const picture = button("Picture", () => actions.run("picture"), {
        title: "Save what is seen as PNG (P)",
    });
    const chosen = select("Format of the export", formats, () => {}, "export-format");
    chosen.element.classList.add("unlabelled");
    const download = button("Export", () => actions.exportAs(chosen.input.value as ExportFormat));
    store.watch(["hello"], ({ hello }) => {
        name.textContent = hello?.name ?? "No file";
        about.textContent = hello ? describe(hello) : "Drop a file on the page, or open one.";
        save.title = hello?.save
            ? `Ctrl+S: writes ${hello.save}`
            : "Nothing to write to: export instead";
        drape.hidden = !hello || hello.kind === "mesh" || !movesOnlyUp(hello);
        for (const option of chosen.input.options)
            option.hidden = option.value === "tif" && hello?.kind !== "raster";
    });
    store.watch(["hello", "connected"], ({ hello, connected }) => {
        save.disabled = !connected || !hello?.save || !hello.writer;
        open.disabled = drape.disabled = !connected || hello?.writer === false;
        download.disabled = picture.disabled = !hello;
    });
    store.watch(["history", "savedAt"], ({ history, savedAt }) => {
        save.classList.toggle("primary", history.done !== savedAt);
    });
    return section(
        "File",
        name,
        about,
        el("div", { class: "row even" }, open, save, picture, drape),
        row(chosen.element, download),
        openInput,
        drapeInput,
    );
}
