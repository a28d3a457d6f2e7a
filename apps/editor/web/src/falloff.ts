// How much control points around the moved ones follow: the weights of docs/protocol.md.

import type { Profile } from "./protocol";

/** Edges of the control net by place: the neighbours of p are targets[first[p] .. first[p + 1]]. */
export interface Adjacency {
    first: Uint32Array;
    targets: Uint32Array;
}

/** `line` holds pairs of places below `points`. Complexity: O(points + edges). */
export function adjacency(points: number, line: Uint32Array): Adjacency {
    const first = new Uint32Array(points + 1);
    for (const place of line) ++first[place + 1];
    for (let p = 0; p < points; ++p) first[p + 1] += first[p];
    const next = first.slice(0, points);
    const targets = new Uint32Array(line.length);
    for (let i = 0; i + 1 < line.length; i += 2) {
        targets[next[line[i]]++] = line[i + 1];
        targets[next[line[i + 1]]++] = line[i];
    }
    return { first, targets };
}

/** The weight at distance d of a falloff of radius r; 1 at 0 for every profile. */
export function profileWeight(profile: Profile, d: number, r: number): number {
    if (d === 0) return 1;
    if (d >= r) return 0;
    const u = d / r;
    switch (profile) {
        case "smooth":
            return (1 - u * u) ** 2;
        case "linear":
            return 1 - u;
        case "sharp":
            return (1 - u) ** 2;
        case "flat":
            return 1;
    }
}

/** A heap of places by distance; places may be in it more than once, the nearest comes first. */
class Heap {
    private readonly places: number[] = [];
    private readonly keys: number[] = [];

    get empty(): boolean {
        return this.places.length === 0;
    }

    push(place: number, key: number): void {
        let i = this.places.length;
        while (i > 0) {
            const parent = (i - 1) >> 1;
            if (this.keys[parent] <= key) break;
            this.keys[i] = this.keys[parent];
            this.places[i] = this.places[parent];
            i = parent;
        }
        this.keys[i] = key;
        this.places[i] = place;
    }

    pop(): { place: number; key: number } {
        const top = { place: this.places[0], key: this.keys[0] };
        const key = this.keys.pop() as number;
        const place = this.places.pop() as number;
        const size = this.places.length;
        if (size === 0) return top;
        let i = 0;
        for (;;) {
            let child = 2 * i + 1;
            if (child >= size) break;
            if (child + 1 < size && this.keys[child + 1] < this.keys[child]) ++child;
            if (this.keys[child] >= key) break;
            this.keys[i] = this.keys[child];
            this.places[i] = this.places[child];
            i = child;
        }
        this.keys[i] = key;
        this.places[i] = place;
        return top;
    }
}

/** How far points are from each other: along the edges, or straight in the plane (rasters). */
export type Metric = "edges" | "plane";

/**
 * Distances from the nearest of `sources` (places), up to `radius`; Infinity beyond.
 * Complexity: O(e log e) in the edges within the radius.
 */
export function distances(
    position: Float32Array,
    net: Adjacency,
    sources: Iterable<number>,
    radius: number,
    metric: Metric,
): Float64Array {
    const found = new Float64Array(position.length / 3).fill(Infinity);
    const origin = new Uint32Array(found.length);
    const heap = new Heap();
    for (const source of sources) {
        found[source] = 0;
        origin[source] = source;
        heap.push(source, 0);
    }
    const apart = (a: number, b: number, axis: number) =>
        position[3 * a + axis] - position[3 * b + axis];
    while (!heap.empty) {
        const { place, key } = heap.pop();
        if (key > found[place]) continue;
        const source = origin[place];
        for (let i = net.first[place]; i < net.first[place + 1]; ++i) {
            const target = net.targets[i];
            const d =
                metric === "plane"
                    ? Math.hypot(apart(target, source, 0), apart(target, source, 1))
                    : key +
                      Math.hypot(
                          apart(target, place, 0),
                          apart(target, place, 1),
                          apart(target, place, 2),
                      );
            if (d < radius && d < found[target]) {
                found[target] = d;
                origin[target] = source;
                heap.push(target, d);
            }
        }
    }
    return found;
}

/** The weight of every point: 1 at `sources`, less around them, 0 from `radius` on. */
export function falloffWeights(
    position: Float32Array,
    net: Adjacency,
    sources: Iterable<number>,
    radius: number,
    profile: Profile,
    metric: Metric,
): Float32Array {
    return Float32Array.from(distances(position, net, sources, radius, metric), (d) =>
        profileWeight(profile, d, radius),
    );
}
