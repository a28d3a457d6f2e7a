// The canvas: scene, camera, and drawing when something has changed.

import * as THREE from "three";
import { add, basis, dot, fieldOfView, framed, type CameraState } from "./camera";
import type { Vector3 } from "./protocol";
import type { Point2, Projected } from "./selection";

const firstView: CameraState = {
    target: [0, 0, 0],
    distance: 1,
    azimuth: (-60 * Math.PI) / 180,
    elevation: (38 * Math.PI) / 180,
};

/** Whether the browser computes pictures without a graphics card. */
function drawsInSoftware(): boolean {
    const gl = document.createElement("canvas").getContext("webgl2");
    const info = gl?.getExtension("WEBGL_debug_renderer_info");
    const name = gl && info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
    gl?.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|software/i.test(name);
}

export interface Ray {
    origin: Vector3;
    direction: Vector3;
}

export class Viewport {
    readonly scene = new THREE.Scene();
    /** Geometry in page coordinates; its z is stretched by the exaggeration. */
    readonly world = new THREE.Group();
    /**
     * Whether the browser computes pictures without a graphics card: then they have to be simpler.
     */
    readonly software = drawsInSoftware();
    private readonly renderer: THREE.WebGLRenderer;
    private readonly lens = new THREE.PerspectiveCamera((fieldOfView * 180) / Math.PI);
    private readonly caster = new THREE.Raycaster();
    private readonly beforeDraw: (() => void)[] = [];
    private state = firstView;
    private bounds = { min: [-1, -1, -1] as Vector3, max: [1, 1, 1] as Vector3 };
    private waiting = false;
    frames = 0;

    constructor(readonly canvas: HTMLCanvasElement) {
        this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !this.software, alpha: true });
        this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
        this.scene.add(this.world);
        this.lens.matrixAutoUpdate = false;
        new ResizeObserver(() => this.resize()).observe(canvas.parentElement as HTMLElement);
        this.resize();
    }

    get width(): number {
        return this.canvas.clientWidth || 1;
    }

    get height(): number {
        return this.canvas.clientHeight || 1;
    }

    get pixelRatio(): number {
        return this.renderer.getPixelRatio();
    }

    get maxTextureSize(): number {
        return this.renderer.capabilities.maxTextureSize;
    }

    get camera(): CameraState {
        return this.state;
    }

    set camera(camera: CameraState) {
        const nearest = this.radius * 1e-5;
        const farthest = this.radius * 50;
        this.state = {
            ...camera,
            distance: Math.min(farthest, Math.max(nearest, camera.distance)),
        };
        this.invalidate();
    }

    get exaggeration(): number {
        return this.world.scale.z;
    }

    /** Stretches heights; the camera keeps looking at the same place of the surface. */
    set exaggeration(factor: number) {
        const [x, y, z] = this.state.target;
        this.state = { ...this.state, target: [x, y, (z / this.exaggeration) * factor] };
        this.world.scale.z = factor;
        this.invalidate();
    }

    /** Says where geometry lies, in page coordinates. */
    setBounds(min: Vector3, max: Vector3): void {
        this.bounds = { min, max };
        this.invalidate();
    }

    /** Looks at a box in page coordinates, or at everything. */
    frame(box: { min: Vector3; max: Vector3 } = this.bounds): void {
        this.camera = framed(
            this.state,
            this.toScene(box.min),
            this.toScene(box.max),
            this.width / this.height,
        );
    }

    look(azimuth: number, elevation: number): void {
        this.camera = { ...this.state, azimuth, elevation };
    }

    /** The direction in which a file is first seen. */
    lookAgain(): void {
        this.look(firstView.azimuth, firstView.elevation);
    }

    /** Called before every picture. */
    onDraw(call: () => void): void {
        this.beforeDraw.push(call);
    }

    get drawn(): boolean {
        return !this.waiting;
    }

    /** Asks for a picture; any number of calls give one. */
    invalidate(): void {
        if (this.waiting) return;
        this.waiting = true;
        requestAnimationFrame(() => {
            this.waiting = false;
            this.draw();
        });
    }

    draw(): void {
        this.placeLens();
        for (const call of this.beforeDraw) call();
        this.renderer.render(this.scene, this.lens);
        ++this.frames;
    }

    toScene(p: Vector3): Vector3 {
        return [p[0], p[1], p[2] * this.exaggeration];
    }

    toPage(p: Vector3): Vector3 {
        return [p[0], p[1], p[2] / this.exaggeration];
    }

    /** Pixels of the canvas and depth of points in page coordinates (3 numbers each). */
    project(
        position: Float32Array,
        result: Projected = new Float32Array(position.length),
    ): Projected {
        const matrix = new THREE.Matrix4()
            .multiplyMatrices(this.lens.projectionMatrix, this.lens.matrixWorldInverse)
            .multiply(this.world.matrixWorld);
        const m = matrix.elements;
        for (let i = 0; i < position.length; i += 3) {
            const [x, y, z] = [position[i], position[i + 1], position[i + 2]];
            const w = m[3] * x + m[7] * y + m[11] * z + m[15];
            result[i] = (((m[0] * x + m[4] * y + m[8] * z + m[12]) / w + 1) / 2) * this.width;
            result[i + 1] = ((1 - (m[1] * x + m[5] * y + m[9] * z + m[13]) / w) / 2) * this.height;
            result[i + 2] = w > 0 ? w : NaN;
        }
        return result;
    }

    projectPoint(p: Vector3): Vector3 {
        return [...this.project(Float32Array.from(p))] as Vector3;
    }

    /** The ray of a pixel, in the scene. */
    ray(pointer: Point2): Ray {
        const { eye, right, up, back } = basis(this.state);
        const tangent = Math.tan(fieldOfView / 2);
        const x = ((2 * pointer.x) / this.width - 1) * tangent * (this.width / this.height);
        const y = (1 - (2 * pointer.y) / this.height) * tangent;
        const direction = add(add(add([0, 0, 0], right, x), up, y), back, -1);
        const length = Math.sqrt(dot(direction, direction));
        return { origin: eye, direction: add([0, 0, 0], direction, 1 / length) };
    }

    /** The nearest point of `object` under a pixel, in page coordinates. */
    hit(pointer: Point2, object: THREE.Object3D): Vector3 | null {
        const { origin, direction } = this.ray(pointer);
        this.caster.set(new THREE.Vector3(...origin), new THREE.Vector3(...direction));
        const found = this.caster.intersectObject(object, true)[0];
        return found ? this.toPage(found.point.toArray() as Vector3) : null;
    }

    /** What lies inside the picture, for boxes in page coordinates. */
    visibility(): (box: THREE.Box3) => boolean {
        const matrix = new THREE.Matrix4()
            .multiplyMatrices(this.lens.projectionMatrix, this.lens.matrixWorldInverse)
            .multiply(this.world.matrixWorld);
        const frustum = new THREE.Frustum().setFromProjectionMatrix(matrix);
        return (box) => frustum.intersectsBox(box);
    }

    private get radius(): number {
        const { min, max } = this.bounds;
        const diagonal = add(this.toScene(max), this.toScene(min), -1);
        return Math.sqrt(dot(diagonal, diagonal)) / 2 || 1;
    }

    private placeLens(): void {
        const { eye, right, up, back } = basis(this.state);
        const vector = (v: Vector3) => new THREE.Vector3(...v);
        this.lens.matrix.makeBasis(vector(right), vector(up), vector(back)).setPosition(...eye);
        const { min, max } = this.bounds;
        const middle = this.toScene(add(add([0, 0, 0], min, 0.5), max, 0.5));
        const away = add(eye, middle, -1);
        const distance = Math.sqrt(dot(away, away));
        const reach = 1.2 * this.radius;
        this.lens.near = Math.max(distance - reach, Math.min(this.state.distance, reach) * 0.01);
        this.lens.far = Math.max(distance + reach, this.lens.near * 2);
        this.lens.aspect = this.width / this.height;
        this.lens.updateProjectionMatrix();
        this.scene.updateMatrixWorld();
        this.lens.updateMatrixWorld(true);
    }

    private resize(): void {
        const frame = this.canvas.parentElement as HTMLElement;
        this.renderer.setSize(frame.clientWidth, frame.clientHeight, true);
        // A canvas that was resized is empty: draw at once, not a frame later.
        this.draw();
    }
}
