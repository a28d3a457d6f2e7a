import "./style/base.css";
import "./style/viewport.css";
import "./style/panel.css";
import "./style/overlays.css";
import { Actions } from "./actions";
import { Appearance } from "./appearance";
import { axesCross } from "./axes";
import { ControlNet } from "./control_net";
import { el } from "./dom";
import { Drape } from "./drape";
import { dropZones } from "./drop";
import { Editing } from "./editing";
import { Gizmo } from "./gizmo";
import { Help } from "./help";
import { installHook } from "./hook";
import { listenToKeys } from "./keys";
import { Legend } from "./legend";
import { Messages } from "./messages";
import { buildPanel } from "./panel/build";
import { Pointer } from "./pointer";
import { Session } from "./session";
import { StatusBar } from "./status_bar";
import { Store } from "./store";
import { SurfaceMaterial } from "./surface_material";
import { Theme } from "./theme";
import { Viewport } from "./viewport";

function socketAddress(): string {
    const address = new URL("socket", location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    return address.href;
}

/** In the title, and when the page is left. */
function warnOfUnsaved(store: Store): void {
    store.watch(["hello", "history", "savedAt"], ({ hello, history, savedAt }) => {
        document.title = hello
            ? `${history.done === savedAt ? "" : "\u2022 "}${hello.name} \u2013 relief`
            : "relief";
    });
    window.addEventListener("beforeunload", (event) => {
        if (store.state.history.done !== store.state.savedAt) event.preventDefault();
    });
}

function start(): void {
    const stage = document.getElementById("stage") as HTMLElement;
    const canvas = document.getElementById("canvas") as HTMLCanvasElement;
    const store = new Store();
    const theme = new Theme();
    const messages = new Messages();
    const viewport = new Viewport(canvas);
    const material = new SurfaceMaterial();
    const net = new ControlNet(viewport);
    const gizmo = new Gizmo(viewport);
    viewport.world.add(net.object);
    viewport.scene.add(gizmo.object);
    const drape = new Drape(store, viewport);
    const parts = { store, viewport, net, material, messages, drape };
    const session = new Session(socketAddress(), parts);
    const editing = new Editing(store, session, viewport, net, gizmo);
    const appearance = new Appearance(store, session, viewport, material, net, drape);
    const pointer = new Pointer(viewport, store, session, editing, gizmo);
    const help = new Help();
    const actions = new Actions({ ...parts, session, editing, pointer, appearance, help, theme });

    const status = new StatusBar(store, session, viewport);
    pointer.onHover((place) => status.follow(place));
    const legend = new Legend();
    appearance.onScale((scale) => legend.show(scale));
    theme.onChange(() => {
        appearance.apply();
        legend.redraw();
    });
    stage.append(legend.element, axesCross(viewport), messages.element);
    document.body.append(
        buildPanel({ store, actions }, theme, help),
        status.element,
        help.element,
        dropZones(store, actions),
    );
    listenToKeys(actions);
    warnOfUnsaved(store);
    installHook({ ...parts, session });
}

function canDraw(): boolean {
    return document.createElement("canvas").getContext("webgl2") !== null;
}

if (canDraw()) start();
else
    document.body.append(
        el(
            "p",
            { class: "fatal", role: "alert" },
            "This page needs WebGL 2, which this browser does not offer.",
        ),
    );
