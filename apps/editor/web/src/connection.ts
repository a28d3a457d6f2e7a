// One WebSocket: questions and commands with their answers, events, and binary frames.

import { decodeFrame, FrameError, type Frame } from "./frame";
import { failureText, type Answer, type Failure, type ServerEvent } from "./protocol";

export interface Listener {
    event(event: ServerEvent): void;
    frame(frame: Frame): void;
    /** Called with the id of what was answered, done or refused. */
    answered(id: number): void;
    closed(): void;
    broken(message: string): void;
}

/** What the server refused, in its words. */
export class Refusal extends Error {
    constructor(readonly failure: Failure | undefined) {
        super(failureText(failure));
    }
}

interface Waiting {
    resolve(answer: Answer): void;
    reject(reason: Error): void;
    frames: number;
}

export class Connection {
    private readonly socket: WebSocket;
    private readonly unanswered = new Map<number, Waiting>();
    /** Frames still to come, by the id of the answered message that asked for them. */
    private readonly frames = new Map<number, number>();
    private lastId = 0;

    constructor(
        address: string,
        private readonly listener: Listener,
    ) {
        this.socket = new WebSocket(address);
        this.socket.binaryType = "arraybuffer";
        this.socket.addEventListener("message", (message) =>
            this.receive(message.data as string | ArrayBuffer),
        );
        this.socket.addEventListener("close", () => this.close());
    }

    get isClosed(): boolean {
        return this.socket.readyState === WebSocket.CLOSED;
    }

    /** Messages without answer and frames that were announced but have not come. */
    get pending(): number {
        let total = this.unanswered.size;
        for (const count of this.frames.values()) total += count;
        return total;
    }

    /** The id that the latest message had: what was asked before has an id up to this. */
    get latestId(): number {
        return this.lastId;
    }

    /**
     * Whether the message of this id is not answered, or frames that it asked for have not come.
     */
    awaits(id: number): boolean {
        return this.unanswered.has(id) || this.frames.has(id);
    }

    /**
     * Sends a question or a command. `frames`: how many binary messages follow the answer. Rejects
     * with Refusal.
     */
    send<T extends Answer>(message: object, frames = 0): Promise<T> {
        if (this.socket.readyState !== WebSocket.OPEN) {
            return Promise.reject(
                new Refusal({ code: "closed", message: "The connection is closed." }),
            );
        }
        const id = ++this.lastId;
        this.socket.send(JSON.stringify({ id, ...message }));
        return new Promise<T>((resolve, reject) => {
            this.unanswered.set(id, {
                resolve: resolve as (answer: Answer) => void,
                reject,
                frames,
            });
        });
    }

    private receive(data: string | ArrayBuffer): void {
        try {
            if (typeof data === "string") this.receiveText(JSON.parse(data));
            else this.receiveFrame(decodeFrame(data));
        } catch (error) {
            if (!(error instanceof FrameError || error instanceof SyntaxError)) throw error;
            this.listener.broken(`The server sent something unreadable: ${error.message}.`);
        }
    }

    private receiveText(message: ServerEvent | Answer): void {
        if ("event" in message) {
            this.listener.event(message);
            return;
        }
        const waiting = this.unanswered.get(message.id);
        if (!waiting)
            throw new FrameError(
                message.ok ? "an answer that nothing asked for" : failureText(message.error),
            );
        this.unanswered.delete(message.id);
        this.listener.answered(message.id);
        // Answers come in order, each followed by its frames: what earlier ones still lack does not
        // come.
        for (const id of this.frames.keys()) {
            if (id < message.id) this.frames.delete(id);
        }
        if (!message.ok) {
            waiting.reject(new Refusal(message.error));
            return;
        }
        if (waiting.frames > 0) this.frames.set(message.id, waiting.frames);
        waiting.resolve(message);
    }

    private receiveFrame(frame: Frame): void {
        const left = frame.id === null ? undefined : this.frames.get(frame.id);
        if (frame.id !== null && left !== undefined) {
            if (left > 1) this.frames.set(frame.id, left - 1);
            else this.frames.delete(frame.id);
        }
        this.listener.frame(frame);
    }

    private close(): void {
        const reason = new Refusal({ code: "closed", message: "The connection is closed." });
        for (const waiting of this.unanswered.values()) waiting.reject(reason);
        this.unanswered.clear();
        this.frames.clear();
        this.listener.closed();
    }
}

/** The reason in the body of an HTTP answer, or its status if there is none. */
export async function failureOf(response: Response): Promise<Failure> {
    try {
        const body = (await response.json()) as Failure & { error?: Failure };
        return body.error ?? body;
    } catch {
        return {
            code: "http",
            message: `The server answered ${response.status} ${response.statusText}.`,
        };
    }
}
