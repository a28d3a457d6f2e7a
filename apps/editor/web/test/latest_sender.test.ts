import { describe, expect, it } from "vitest";
import { LatestSender } from "../src/latest_sender";

function setUp() {
    const sent: number[] = [];
    const answers: (() => void)[] = [];
    const frames: (() => void)[] = [];
    const sender = new LatestSender<number>(
        (value) => {
            sent.push(value);
            return new Promise<void>((resolve) => answers.push(resolve));
        },
        (call) => frames.push(call),
    );
    return {
        sent,
        sender,
        frame: () => frames.splice(0).forEach((call) => call()),
        answer: async () => {
            answers.splice(0).forEach((call) => call());
            await new Promise((resolve) => setTimeout(resolve));
        },
    };
}

describe("a sender of the latest", () => {
    it("sends once a frame what was offered last", () => {
        const { sent, sender, frame } = setUp();
        [1, 2, 3].forEach((value) => sender.offer(value));
        expect(sent).toEqual([]);
        frame();
        expect(sent).toEqual([3]);
    });

    it("has never more than one without an answer", async () => {
        const { sent, sender, frame, answer } = setUp();
        sender.offer(1);
        frame();
        [2, 3].forEach((value) => sender.offer(value));
        frame();
        expect(sent).toEqual([1]);
        await answer();
        expect(sent).toEqual([1]);
        frame();
        expect(sent).toEqual([1, 3]);
        await answer();
        frame();
        expect(sent).toEqual([1, 3]);
    });

    it("sends nothing that was dropped, and goes on afterwards", async () => {
        const { sent, sender, frame, answer } = setUp();
        sender.offer(1);
        sender.drop();
        frame();
        expect(sent).toEqual([]);
        sender.offer(2);
        frame();
        sender.offer(3);
        sender.drop();
        await answer();
        frame();
        expect(sent).toEqual([2]);
    });
});
