// A raster as tiles: coarse at once, finer as they arrive.

import * as THREE from "three";
import type { Connection } from "./connection";
import type { Frame } from "./frame";
import { parent, chooseTiles, type TileView } from "./tile_choice";
import { tileKey, type Hello, type RasterInfo, type TileId } from "./protocol";
import { hashArrays, typicalLargest, type Shape } from "./shape";
import type { SurfaceMaterial } from "./surface_material";
import { buildTile, patchTile, tileIdOf, type Tile } from "./tile_geometry";
import type { Viewport } from "./viewport";
import { fieldOfView } from "./camera";

interface Loaded {
    tile: Tile;
    mesh: THREE.Mesh;
    box: THREE.Box3;
    /** Loaded before the latest change of view: shown until its successor comes. */
    stale: boolean;
    lastDrawn: number;
}

/** So many tiles may be asked for and not yet here: a change of view is answered soon. */
const maxAsked = 8;
const keptTiles = 320;

export class Terrain implements Shape {
    readonly object = new THREE.Group();
    private readonly raster: RasterInfo;
    private readonly loaded = new Map<string, Loaded>();
    /**
     * Tiles that were asked for since the view changed, by the id of the question. Those that fail
     * are not asked for again.
     */
    private readonly asked = new Map<string, number>();
    private drawn: TileId[] = [];
    private since = 0;

    constructor(
        private readonly hello: Hello,
        raster: RasterInfo,
        private readonly connection: Connection,
        private readonly viewport: Viewport,
        private readonly material: SurfaceMaterial,
        private readonly failed: (reason: unknown) => void,
    ) {
        this.raster = raster;
        this.refresh();
    }

    get triangles(): number {
        return this.drawn.reduce(
            (sum, id) => sum + (this.loaded.get(tileKey(id))?.tile.index.length ?? 0) / 3,
            0,
        );
    }

    get shownTiles(): TileId[] {
        return this.drawn;
    }

    refresh(): void {
        for (const entry of this.loaded.values()) entry.stale = true;
        this.asked.clear();
        this.since = this.connection.latestId;
        this.ask([[this.raster.coarsest, 0, 0]]);
        this.viewport.invalidate();
    }

    take(frame: Frame): boolean {
        if (frame.what === "tile") this.takeTile(frame);
        else if (frame.what === "patch" && frame.head.tile) this.takePatch(frame);
        else return false;
        this.viewport.invalidate();
        return true;
    }

    prepare(): void {
        const { draw, want } = chooseTiles(this.raster, this.view(), this.limits());
        this.show(draw);
        const stale = draw.filter((id) => this.loaded.get(tileKey(id))?.stale);
        this.ask([...stale, ...want].filter((id) => !this.asked.has(tileKey(id))));
        this.dropOldest();
    }

    setEdges(): void {
        // The material draws the lattice's lines.
    }

    setFaces(): void {
        // Nor can the faces be hidden apart from them.
    }

    largestValue(): number {
        const root = this.loaded.get(tileKey([this.raster.coarsest, 0, 0]));
        return root?.tile.value ? typicalLargest([root.tile.value]) : 0;
    }

    hash(): string {
        const keys = this.drawn.map(tileKey).sort();
        return hashArrays(keys.map((key) => (this.loaded.get(key) as Loaded).tile.position));
    }

    dispose(): void {
        for (const key of [...this.loaded.keys()]) this.remove(key);
    }

    private view(): TileView {
        const inside = this.viewport.visibility();
        const eye = new THREE.Vector3(
            ...this.viewport.ray({ x: this.viewport.width / 2, y: this.viewport.height / 2 })
                .origin,
        );
        const focal = this.viewport.height / (2 * Math.tan(fieldOfView / 2));
        const spacing = Math.max(...this.raster.spacing);
        const stretch = new THREE.Vector3(1, 1, this.viewport.exaggeration);
        return {
            visible: (id) => inside(this.boxOf(id)),
            loaded: (id) => this.loaded.has(tileKey(id)),
            pixels: (id) => {
                const box = this.boxOf(id).clone();
                box.min.multiply(stretch);
                box.max.multiply(stretch);
                return (
                    (spacing * 2 ** id[0] * focal) /
                    Math.max(box.distanceToPoint(eye), 1e-6 * spacing)
                );
            },
        };
    }

    private limits(): { pixels: number; tiles: number } {
        return this.viewport.software ? { pixels: 8, tiles: 4 } : { pixels: 2.5, tiles: 120 };
    }

    /**
     * Of a tile that is not loaded: its part of the nearest coarser one, or where the raster lies.
     */
    private boxOf(id: TileId): THREE.Box3 {
        const own = this.loaded.get(tileKey(id));
        if (own) return own.box;
        const whole = new THREE.Box3(
            new THREE.Vector3(...this.hello.min),
            new THREE.Vector3(...this.hello.max),
        );
        const above = id[0] < this.raster.coarsest ? this.boxOf(parent(id)) : whole;
        if (this.hello.parametric) return above;
        const [j, r, c] = id;
        const side = this.raster.tile * 2 ** j;
        const [dx, dy] = this.raster.spacing;
        return new THREE.Box3(
            new THREE.Vector3(
                whole.min.x + c * side * dx,
                whole.max.y - (r + 1) * side * dy,
                above.min.z,
            ),
            new THREE.Vector3(
                whole.min.x + (c + 1) * side * dx,
                whole.max.y - r * side * dy,
                above.max.z,
            ),
        );
    }

    private show(draw: TileId[]): void {
        for (const id of this.drawn) {
            const entry = this.loaded.get(tileKey(id));
            if (entry) entry.mesh.visible = false;
        }
        for (const id of draw) {
            const entry = this.loaded.get(tileKey(id)) as Loaded;
            entry.mesh.visible = true;
            entry.lastDrawn = this.viewport.frames;
        }
        this.drawn = draw;
    }

    private ask(tiles: TileId[]): void {
        let waiting = 0;
        for (const id of this.asked.values()) waiting += this.connection.awaits(id) ? 1 : 0;
        const next = tiles.slice(0, Math.max(0, maxAsked - waiting));
        if (next.length === 0) return;
        const sent = this.connection.send({ ask: "tiles", tiles: next }, next.length);
        for (const id of next) this.asked.set(tileKey(id), this.connection.latestId);
        sent.catch(this.failed);
    }

    private takeTile(frame: Frame): void {
        // Of what was asked for before the view changed nothing is of use; 0 is what the server
        // sends by itself.
        if (frame.id && frame.id <= this.since) return;
        const tile = buildTile(frame, this.raster);
        const key = tileKey(tile.id);
        this.asked.delete(key);
        this.remove(key);
        const geometry = new THREE.BufferGeometry();
        geometry.setAttribute("position", new THREE.BufferAttribute(tile.position, 3));
        geometry.setAttribute("normal", new THREE.BufferAttribute(tile.normal, 4, true));
        geometry.setAttribute("lattice", new THREE.BufferAttribute(tile.lattice, 2));
        if (tile.value) geometry.setAttribute("value", new THREE.BufferAttribute(tile.value, 1));
        geometry.setIndex(new THREE.BufferAttribute(tile.index, 1));
        const mesh = new THREE.Mesh(geometry, this.material);
        mesh.visible = false;
        const entry = {
            tile,
            mesh,
            box: new THREE.Box3(),
            stale: false,
            lastDrawn: this.viewport.frames,
        };
        measure(entry);
        this.loaded.set(key, entry);
        this.object.add(mesh);
    }

    private takePatch(frame: Frame): void {
        const entry = this.loaded.get(tileKey(tileIdOf(frame)));
        if (!entry) return;
        patchTile(entry.tile, frame);
        for (const name of ["position", "normal", "value"]) {
            const attribute = entry.mesh.geometry.getAttribute(name);
            if (attribute) attribute.needsUpdate = true;
        }
        measure(entry);
    }

    private dropOldest(): void {
        if (this.loaded.size <= keptTiles) return;
        const coarsest = tileKey([this.raster.coarsest, 0, 0]);
        const old = [...this.loaded.entries()]
            .filter(([key, entry]) => !entry.mesh.visible && key !== coarsest)
            .sort((a, b) => a[1].lastDrawn - b[1].lastDrawn)
            .slice(0, this.loaded.size - keptTiles);
        for (const [key] of old) this.remove(key);
        const tiles = old.map(([, entry]) => entry.tile.id);
        this.connection.send({ ask: "forget", tiles }).catch(this.failed);
    }

    private remove(key: string): void {
        const entry = this.loaded.get(key);
        if (!entry) return;
        this.object.remove(entry.mesh);
        entry.mesh.geometry.dispose();
        this.loaded.delete(key);
    }
}

function measure({ tile, mesh, box }: Loaded): void {
    box.setFromArray(tile.position);
    mesh.geometry.boundingBox = box.clone();
    mesh.geometry.boundingSphere = box.getBoundingSphere(new THREE.Sphere());
}
