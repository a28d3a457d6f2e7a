// Sends what was offered last: at most once a frame, and never while an answer is outstanding.

export class LatestSender<T> {
    private wanted: { value: T } | null = null;
    private scheduled = false;
    private answered = true;

    constructor(
        private readonly send: (value: T) => Promise<unknown>,
        private readonly nextFrame: (call: () => void) => void = (call) =>
            void requestAnimationFrame(call),
    ) {}

    /** Takes the place of what was offered before and has not been sent. */
    offer(value: T): void {
        this.wanted = { value };
        this.schedule();
    }

    /** What was offered and has not been sent is not sent any more. */
    drop(): void {
        this.wanted = null;
    }

    private schedule(): void {
        if (this.scheduled || !this.answered || !this.wanted) return;
        this.scheduled = true;
        this.nextFrame(() => this.sendWanted());
    }

    private sendWanted(): void {
        this.scheduled = false;
        const wanted = this.wanted;
        if (!wanted) return;
        this.wanted = null;
        this.answered = false;
        void this.send(wanted.value).finally(() => {
            this.answered = true;
            this.schedule();
        });
    }
}
