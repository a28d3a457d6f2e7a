// An image laid over terrain: the server says where its corners lie.

import * as THREE from "three";
import { failureOf, Refusal } from "./connection";
import type { Store } from "./store";
import type { Viewport } from "./viewport";

export type Rect = [x0: number, y0: number, x1: number, y1: number];

export class Drape {
    texture: THREE.Texture | null = null;
    rect: Rect = [0, 0, 1, 1];

    constructor(
        private readonly store: Store,
        private readonly viewport: Viewport,
    ) {}

    /** Sends an image and shows it. Throws Refusal. */
    async load(file: File): Promise<void> {
        const sent = await fetch(`drape?name=${encodeURIComponent(file.name)}`, {
            method: "POST",
            body: file,
        });
        if (!sent.ok) throw new Refusal(await failureOf(sent));
        const { rect } = (await sent.json()) as { rect: Rect };
        const picture = await fetch("drape.png", { cache: "no-store" });
        if (!picture.ok) throw new Refusal(await failureOf(picture));
        const image = await this.fitting(await picture.blob());
        this.clear();
        this.texture = new THREE.Texture(image);
        this.texture.flipY = false;
        this.texture.generateMipmaps = true;
        this.texture.minFilter = THREE.LinearMipmapLinearFilter;
        this.texture.anisotropy = 8;
        this.texture.needsUpdate = true;
        this.rect = rect;
        // Also when another one was shown before: watchers of the state must see a change.
        this.store.set({ drape: "none" });
        this.store.set({ drape: "shown" });
    }

    clear(): void {
        this.texture?.dispose();
        this.texture = null;
        this.store.set({ drape: "none" });
    }

    /** The picture at the largest size that a texture can have. */
    private async fitting(blob: Blob): Promise<ImageBitmap> {
        const whole = await createImageBitmap(blob);
        const factor = this.viewport.maxTextureSize / Math.max(whole.width, whole.height);
        if (factor >= 1) return whole;
        const [resizeWidth, resizeHeight] = [whole.width, whole.height].map((size) =>
            Math.max(1, Math.floor(size * factor)),
        );
        const reduced = await createImageBitmap(whole, {
            resizeWidth,
            resizeHeight,
            resizeQuality: "high",
        });
        whole.close();
        return reduced;
    }
}
