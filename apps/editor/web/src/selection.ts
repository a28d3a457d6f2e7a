// Sets of control points, by the numbers that commands call them.

import type { Adjacency } from "./falloff";

export interface Point2 {
    x: number;
    y: number;
}

export interface Box {
    left: number;
    top: number;
    right: number;
    bottom: number;
}

/** Places of points on the screen: x, y, depth each; depth NaN for those behind the camera. */
export type Projected = Float32Array;

export function toggled(selection: ReadonlySet<number>, point: number): Set<number> {
    const result = new Set(selection);
    if (!result.delete(point)) result.add(point);
    return result;
}

export function united(selection: ReadonlySet<number>, points: Iterable<number>): Set<number> {
    const result = new Set(selection);
    for (const point of points) result.add(point);
    return result;
}

/** The rectangle between two corners, in any order. */
export function boxOf(a: Point2, b: Point2): Box {
    return {
        left: Math.min(a.x, b.x),
        top: Math.min(a.y, b.y),
        right: Math.max(a.x, b.x),
        bottom: Math.max(a.y, b.y),
    };
}

/** Places of the points inside the box. */
export function placesInBox(projected: Projected, box: Box): number[] {
    const found: number[] = [];
    for (let i = 0; 3 * i < projected.length; ++i) {
        const x = projected[3 * i];
        const y = projected[3 * i + 1];
        if (Number.isNaN(projected[3 * i + 2])) continue;
        if (x >= box.left && x <= box.right && y >= box.top && y <= box.bottom) found.push(i);
    }
    return found;
}

/**
 * The place of the point nearest to the pointer within `reach` pixels and no deeper than `deepest`,
 * or -1. Of points on one pixel the front one.
 */
export function placeUnder(
    projected: Projected,
    pointer: Point2,
    reach: number,
    deepest = Infinity,
): number {
    let best = -1;
    let bestDistance = reach;
    let bestDepth = Infinity;
    for (let i = 0; 3 * i < projected.length; ++i) {
        const depth = projected[3 * i + 2];
        if (!(depth <= deepest)) continue;
        const distance = Math.hypot(projected[3 * i] - pointer.x, projected[3 * i + 1] - pointer.y);
        if (distance > reach) continue;
        const clearlyNearer = distance < bestDistance - 1;
        const asNear = distance <= bestDistance + 1;
        if (clearlyNearer || (asNear && depth < bestDepth)) {
            best = i;
            bestDistance = distance;
            bestDepth = depth;
        }
    }
    return best;
}

/** `places` and all their neighbours, in ascending order. */
export function grown(net: Adjacency, places: Iterable<number>): number[] {
    const result = new Set(places);
    for (const place of [...result]) {
        for (let i = net.first[place]; i < net.first[place + 1]; ++i) result.add(net.targets[i]);
    }
    return [...result].sort((a, b) => a - b);
}

/**
 * The neighbour of `place` that lies most nearly in a direction on the screen (y downwards), or -1
 * if none does.
 */
export function neighbourTowards(
    net: Adjacency,
    projected: Projected,
    place: number,
    direction: Point2,
): number {
    let best = -1;
    let bestCosine = 0.3; // About 70 degrees: a key never moves backwards or sideways.
    for (let i = net.first[place]; i < net.first[place + 1]; ++i) {
        const target = net.targets[i];
        if (Number.isNaN(projected[3 * target + 2])) continue;
        const x = projected[3 * target] - projected[3 * place];
        const y = projected[3 * target + 1] - projected[3 * place + 1];
        const cosine = (x * direction.x + y * direction.y) / (Math.hypot(x, y) || 1);
        if (cosine > bestCosine) {
            best = target;
            bestCosine = cosine;
        }
    }
    return best;
}
