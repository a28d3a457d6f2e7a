import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Connection, Refusal } from "../src/connection";
import { frameOf } from "./frames";

class FakeSocket {
    static last: FakeSocket;
    static readonly OPEN = 1;
    readyState = 1;
    binaryType = "";
    readonly sent: Record<string, unknown>[] = [];
    private readonly listeners = new Map<string, (event: { data?: unknown }) => void>();
    constructor() {
        FakeSocket.last = this;
    }
    addEventListener(name: string, call: (event: { data?: unknown }) => void) {
        this.listeners.set(name, call);
    }
    send(text: string) {
        this.sent.push(JSON.parse(text));
    }
    say(message: object | ArrayBuffer) {
        this.listeners.get("message")?.({
            data: message instanceof ArrayBuffer ? message : JSON.stringify(message),
        });
    }
    close() {
        this.readyState = 3;
        this.listeners.get("close")?.({});
    }
}

const net = (id: number) => frameOf({ what: "net", id }, { index: [Uint32Array.of(5), 1] });

describe("a connection", () => {
    const listener = {
        event: vi.fn(),
        frame: vi.fn(),
        answered: vi.fn(),
        closed: vi.fn(),
        broken: vi.fn(),
    };
    let connection: Connection;

    beforeEach(() => {
        vi.stubGlobal("WebSocket", FakeSocket);
        vi.clearAllMocks();
        connection = new Connection("ws://127.0.0.1/", listener);
    });
    afterEach(() => vi.unstubAllGlobals());

    it("numbers what it sends and gives each its answer", async () => {
        const first = connection.send({ ask: "at", x: 1, y: 2 });
        const second = connection.send({ do: "undo" });
        const { sent } = FakeSocket.last;
        expect(sent).toEqual([
            { id: 1, ask: "at", x: 1, y: 2 },
            { id: 2, do: "undo" },
        ]);
        FakeSocket.last.say({ id: 1, ok: true, value: 7 });
        FakeSocket.last.say({
            id: 2,
            ok: false,
            error: { code: "nothing", message: "nothing to undo", where: "command 0" },
        });
        expect(await first).toMatchObject({ value: 7 });
        await expect(second).rejects.toThrow("nothing to undo (command 0)");
        await expect(second).rejects.toBeInstanceOf(Refusal);
    });

    it("counts answers and frames that have not come", async () => {
        const sent = connection.send({ ask: "tiles" }, 2);
        expect(connection.pending).toBe(1);
        FakeSocket.last.say({ id: 1, ok: true });
        await sent;
        expect(connection.pending).toBe(2);
        FakeSocket.last.say(net(1));
        expect([connection.pending, connection.awaits(1)]).toEqual([1, true]);
        FakeSocket.last.say(net(1));
        expect([connection.pending, connection.awaits(1)]).toEqual([0, false]);
        expect(listener.frame).toHaveBeenCalledTimes(2);
    });

    it("does not wait for frames that a later answer has overtaken", () => {
        void connection.send({ ask: "tiles" }, 3);
        void connection.send({ ask: "forget" });
        FakeSocket.last.say({ id: 1, ok: true });
        FakeSocket.last.say(net(1));
        FakeSocket.last.say({ id: 2, ok: true });
        expect(connection.pending).toBe(0);
    });

    it("says so when it receives what it can not read", () => {
        FakeSocket.last.say(new ArrayBuffer(5));
        FakeSocket.last.say({ id: 99, ok: true });
        FakeSocket.last.say({
            id: null,
            ok: false,
            error: { code: "syntax", message: "not JSON" },
        });
        expect(listener.broken.mock.calls.map(([message]) => message)).toEqual([
            "The server sent something unreadable: 5 bytes are no message.",
            "The server sent something unreadable: an answer that nothing asked for.",
            "The server sent something unreadable: not JSON.",
        ]);
    });

    it("passes on events", () => {
        FakeSocket.last.say({ event: "notice", message: "hello" });
        expect(listener.event).toHaveBeenCalledWith({ event: "notice", message: "hello" });
    });

    it("refuses all that is open when it closes", async () => {
        const open = connection.send({ do: "undo" });
        FakeSocket.last.close();
        await expect(open).rejects.toThrow("closed");
        await expect(connection.send({ do: "redo" })).rejects.toThrow("closed");
        expect(connection.pending).toBe(0);
        expect(listener.closed).toHaveBeenCalledOnce();
    });
});
