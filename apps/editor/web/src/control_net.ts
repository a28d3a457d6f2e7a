// The control net of a level: its points, edges and control triangles, and how selection and
// falloff look on it.

import * as THREE from "three";
import { unitsPerPixel } from "./camera";
import { adjacency, falloffWeights, type Adjacency, type Metric } from "./falloff";
import { checkIndices, FrameError, optionalArray, requiredArray, type Frame } from "./frame";
import type { Falloff, Vector3 } from "./protocol";
import { hashArrays } from "./shape";
import type { Viewport } from "./viewport";

export interface NetColours {
    point: number;
    line: number;
    selected: number;
    triangle: number;
}

/** Pixels across a point: fewer where points are dense. */
const pointPixels = { least: 3, most: 7, perEdge: 0.35 };

const pointVertexShader = /* glsl */ `
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform float size;
in vec3 position;
in float state;             // 0 .. 1: weight of the falloff; 2: selected; 3: under the pointer
out float weight;
void main() {
    weight = state;
    // A little towards the eye, so that the surface does not cut through the discs.
    gl_Position = projectionMatrix * vec4(0.985 * (modelViewMatrix * vec4(position, 1.0)).xyz, 1.0);
    gl_PointSize = size * (state >= 2.0 ? 1.45 : 1.0 + 0.3 * state) + 2.0;
}`;

const pointFragmentShader = /* glsl */ `
precision highp float;
uniform vec3 point;
uniform vec3 selected;
uniform float opacity;
uniform float size;
in float weight;
out vec4 colour;
void main() {
    float width = size * (weight >= 2.0 ? 1.45 : 1.0 + 0.3 * weight) + 2.0;
    float inside = (0.5 - length(gl_PointCoord - 0.5)) * width - 0.5;
    if (inside <= 0.0) discard;
    vec3 fill = mix(point, selected, clamp(weight, 0.0, 1.0));
    vec3 rim = weight >= 3.0 ? selected : vec3(1.0);
    colour = vec4(mix(rim, fill, clamp(inside - 0.6, 0.0, 1.0)), opacity * clamp(inside, 0.0, 1.0));
}`;

function pointMaterial(opacity: number, depthTest: boolean): THREE.RawShaderMaterial {
    return new THREE.RawShaderMaterial({
        glslVersion: THREE.GLSL3,
        vertexShader: pointVertexShader,
        fragmentShader: pointFragmentShader,
        transparent: true,
        depthTest,
        depthWrite: false,
        uniforms: {
            size: { value: 1 },
            opacity: { value: opacity },
            point: { value: new THREE.Vector3() },
            selected: { value: new THREE.Vector3() },
        },
    });
}

function lineMaterial(depthTest: boolean): THREE.LineBasicMaterial {
    return new THREE.LineBasicMaterial({
        transparent: true,
        opacity: depthTest ? 0.8 : 0.25,
        depthTest,
        depthWrite: false,
    });
}

export class ControlNet {
    readonly object = new THREE.Group();
    /** Page coordinates of the points by place; commands call point p `names[p]`. */
    position = new Float32Array();
    names = new Uint32Array();
    level = -1;
    private line = new Uint32Array();
    private corner: Float32Array | null = null;
    private edges: Adjacency = adjacency(0, this.line);
    private places = new Map<number, number>();
    private states = new Float32Array();
    private spacing = 0;
    /** What is behind the surface is drawn faintly, by a second pass without depth test. */
    private readonly pointMaterials = [pointMaterial(0.3, false), pointMaterial(1, true)];
    private readonly lineMaterials = [lineMaterial(false), lineMaterial(true)];
    private readonly triangleMaterials = [lineMaterial(false), lineMaterial(true)];
    private readonly points = new THREE.BufferGeometry();
    private readonly lines = new THREE.BufferGeometry();
    private readonly trianglePositions = new THREE.BufferGeometry();

    constructor(private readonly viewport: Viewport) {
        for (const [geometry, materials] of [
            [this.lines, this.lineMaterials],
            [this.trianglePositions, this.triangleMaterials],
        ] as const) {
            materials.forEach((material, order) => {
                const lines = new THREE.LineSegments(geometry, material);
                lines.renderOrder = 1 + order;
                lines.frustumCulled = false;
                this.object.add(lines);
            });
        }
        this.pointMaterials.forEach((material, order) => {
            const points = new THREE.Points(this.points, material);
            points.renderOrder = 3 + order;
            points.frustumCulled = false;
            this.object.add(points);
        });
        viewport.onDraw(() => this.scalePoints());
    }

    get count(): number {
        return this.names.length;
    }

    get adjacency(): Adjacency {
        return this.edges;
    }

    get hasTriangles(): boolean {
        return this.corner !== null;
    }

    hash(): string {
        return hashArrays([this.position]);
    }

    /** Takes a `net` message. Throws FrameError. */
    take(frame: Frame): void {
        if (frame.head.patch) this.takePatch(frame);
        else this.takeNet(frame);
        this.viewport.invalidate();
    }

    clear(): void {
        this.position = new Float32Array();
        this.names = new Uint32Array();
        this.line = new Uint32Array();
        this.corner = null;
        this.level = -1;
        this.build();
        this.viewport.invalidate();
    }

    /** Places of those of the points that are part of the net (a window of it may be loaded). */
    placesOf(names: Iterable<number>): number[] {
        const found: number[] = [];
        for (const name of names) {
            const place = this.places.get(name);
            if (place !== undefined) found.push(place);
        }
        return found;
    }

    pointAt(place: number): Vector3 {
        return [...this.position.subarray(3 * place, 3 * place + 3)] as Vector3;
    }

    /** The middle of some places, or null if there are none. */
    middle(places: readonly number[]): Vector3 | null {
        if (places.length === 0) return null;
        const sum: Vector3 = [0, 0, 0];
        for (const place of places) {
            for (let i = 0; i < 3; ++i) sum[i] += this.position[3 * place + i];
        }
        return sum.map((s) => s / places.length) as Vector3;
    }

    /** Length of an edge, half of them being longer: what a point of the net has to itself. */
    typicalEdge(): number {
        const lengths: number[] = [];
        const step = 2 * Math.max(1, Math.floor(this.line.length / 2 / 1000));
        for (let i = 0; i + 1 < this.line.length; i += step) {
            const [a, b] = [this.pointAt(this.line[i]), this.pointAt(this.line[i + 1])];
            lengths.push(Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
        }
        lengths.sort((a, b) => a - b);
        return lengths[lengths.length >> 1] ?? 0;
    }

    /**
     * Shows what is selected, how far its falloff reaches, and which point is under the pointer
     * (-1: none).
     */
    highlight(
        selection: ReadonlySet<number>,
        falloff: (Falloff & { metric: Metric }) | null,
        hovered: number,
    ): void {
        const selected = this.placesOf(selection);
        if (falloff && selected.length > 0) {
            this.states.set(
                falloffWeights(
                    this.position,
                    this.edges,
                    selected,
                    falloff.radius,
                    falloff.profile,
                    falloff.metric,
                ),
            );
        } else {
            this.states.fill(0);
        }
        for (const place of selected) this.states[place] = 2;
        if (hovered >= 0 && hovered < this.count)
            this.states[hovered] = this.states[hovered] >= 2 ? 2 : 3;
        const attribute = this.points.getAttribute("state");
        if (attribute) attribute.needsUpdate = true;
        this.viewport.invalidate();
    }

    setColours(colours: NetColours): void {
        const vector = (hex: number) =>
            new THREE.Vector3((hex >> 16) & 255, (hex >> 8) & 255, hex & 255).divideScalar(255);
        for (const material of this.pointMaterials) {
            material.uniforms.point.value = vector(colours.point);
            material.uniforms.selected.value = vector(colours.selected);
        }
        for (const material of this.lineMaterials) material.color.setHex(colours.line);
        for (const material of this.triangleMaterials) material.color.setHex(colours.triangle);
        this.viewport.invalidate();
    }

    private takeNet(frame: Frame): void {
        const names = requiredArray(frame, "index", "u32", 1);
        const position = requiredArray(frame, "position", "f32", 3, names.length);
        const line = optionalArray(frame, "line", "u32", 2) ?? new Uint32Array();
        const corner = optionalArray(frame, "corner", "f32", 9, names.length);
        checkIndices("an edge of the net", line, names.length);
        this.names = names;
        this.position = position;
        this.line = line;
        this.corner = corner;
        this.level = typeof frame.head.level === "number" ? frame.head.level : -1;
        this.build();
    }

    private takePatch(frame: Frame): void {
        const at = requiredArray(frame, "at", "u32", 1);
        if (this.count === 0) throw new FrameError("a patch of the net came before the net");
        checkIndices("a patch of the net", at, this.count);
        const position = requiredArray(frame, "position", "f32", 3, at.length);
        const corner = optionalArray(frame, "corner", "f32", 9, at.length);
        at.forEach((place, i) => {
            this.position.set(position.subarray(3 * i, 3 * i + 3), 3 * place);
            if (corner && this.corner)
                this.corner.set(corner.subarray(9 * i, 9 * i + 9), 9 * place);
        });
        this.points.getAttribute("position").needsUpdate = true;
        const corners = this.trianglePositions.getAttribute("position");
        if (corners) corners.needsUpdate = true;
    }

    private scalePoints(): void {
        const { camera, height, pixelRatio } = this.viewport;
        const edge = this.spacing / unitsPerPixel(camera, height);
        const { least, most, perEdge } = pointPixels;
        const pixels = Math.min(most, Math.max(least, perEdge * edge));
        for (const material of this.pointMaterials)
            material.uniforms.size.value = pixels * pixelRatio;
    }

    private build(): void {
        this.edges = adjacency(this.count, this.line);
        this.places = new Map([...this.names].map((name, place) => [name, place]));
        this.states = new Float32Array(this.count);
        const positions = new THREE.BufferAttribute(this.position, 3);
        // Attributes of another size need buffers of their own.
        for (const geometry of [this.points, this.lines, this.trianglePositions])
            geometry.dispose();
        this.points.setAttribute("position", positions);
        this.points.setAttribute("state", new THREE.BufferAttribute(this.states, 1));
        this.lines.setAttribute("position", positions);
        this.lines.setIndex(new THREE.BufferAttribute(this.line, 1));
        const corners = this.corner ?? new Float32Array();
        const sides = new Uint32Array(6 * (corners.length / 9));
        for (let t = 0; t < sides.length / 6; ++t)
            sides.set(
                [0, 1, 1, 2, 2, 0].map((i) => 3 * t + i),
                6 * t,
            );
        this.trianglePositions.setAttribute("position", new THREE.BufferAttribute(corners, 3));
        this.trianglePositions.setIndex(new THREE.BufferAttribute(sides, 1));
        this.object.visible = this.count > 0;
        this.spacing = this.typicalEdge();
        // Edges step back behind control triangles.
        this.lineMaterials[0].opacity = this.corner ? 0.08 : 0.25;
        this.lineMaterials[1].opacity = this.corner ? 0.3 : 0.8;
    }
}
