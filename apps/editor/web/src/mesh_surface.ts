// A mesh or spline that is sent whole, and mended by patches.

import * as THREE from "three";
import { checkIndices, FrameError, optionalArray, requiredArray, type Frame } from "./frame";
import { hashArrays, typicalLargest, type Shape } from "./shape";
import type { SurfaceMaterial } from "./surface_material";
import type { Viewport } from "./viewport";

export class MeshSurface implements Shape {
    readonly object = new THREE.Group();
    private readonly mesh: THREE.Mesh;
    private readonly edges: THREE.LineSegments;

    constructor(
        private readonly viewport: Viewport,
        material: SurfaceMaterial,
    ) {
        this.mesh = new THREE.Mesh(new THREE.BufferGeometry(), material);
        const line = new THREE.LineBasicMaterial({ transparent: true, opacity: 0.55 });
        this.edges = new THREE.LineSegments(new THREE.BufferGeometry(), line);
        this.edges.raycast = () => {};
        this.object.add(this.mesh, this.edges);
    }

    get triangles(): number {
        return (this.mesh.geometry.getIndex()?.count ?? 0) / 3;
    }

    refresh(): void {
        // The answer to `view` brings the new surface.
    }

    prepare(): void {
        // It is drawn as it is.
    }

    take(frame: Frame): boolean {
        if (frame.what === "surface") this.takeSurface(frame);
        else if (frame.what === "patch" && !frame.head.tile) this.takePatch(frame);
        else return false;
        this.viewport.invalidate();
        return true;
    }

    setEdges(visible: boolean, colour: number): void {
        this.edges.visible = visible;
        (this.edges.material as THREE.LineBasicMaterial).color.setHex(colour);
    }

    setFaces(visible: boolean): void {
        this.mesh.visible = visible;
    }

    largestValue(): number {
        const value = this.mesh.geometry.getAttribute("value");
        return value ? typicalLargest([value.array]) : 0;
    }

    hash(): string {
        const position = this.mesh.geometry.getAttribute("position");
        return hashArrays(position ? [position.array as Float32Array] : []);
    }

    dispose(): void {
        this.mesh.geometry.dispose();
        this.edges.geometry.dispose();
        (this.edges.material as THREE.Material).dispose();
    }

    private takeSurface(frame: Frame): void {
        const position = requiredArray(frame, "position", "f32", 3);
        const vertices = position.length / 3;
        const normal = requiredArray(frame, "normal", "i16", 4, vertices);
        const index = requiredArray(frame, "index", "u32", 3);
        const line = optionalArray(frame, "line", "u32", 2) ?? new Uint32Array();
        const value =
            optionalArray(frame, "error", "f32", 1, vertices) ??
            optionalArray(frame, "curvature", "f32", 1, vertices);
        checkIndices("a triangle", index, vertices);
        checkIndices("an edge", line, vertices);
        const geometry = new THREE.BufferGeometry();
        const positions = new THREE.BufferAttribute(position, 3);
        geometry.setAttribute("position", positions);
        geometry.setAttribute("normal", new THREE.BufferAttribute(normal, 4, true));
        if (value) geometry.setAttribute("value", new THREE.BufferAttribute(value, 1));
        geometry.setIndex(new THREE.BufferAttribute(index, 1));
        const edges = new THREE.BufferGeometry();
        edges.setAttribute("position", positions);
        edges.setIndex(new THREE.BufferAttribute(line, 1));
        this.mesh.geometry.dispose();
        this.edges.geometry.dispose();
        this.mesh.geometry = geometry;
        this.edges.geometry = edges;
        this.measure();
    }

    private takePatch(frame: Frame): void {
        const at = requiredArray(frame, "at", "u32", 1);
        const geometry = this.mesh.geometry;
        const vertices = geometry.getAttribute("position")?.count ?? 0;
        if (vertices === 0) throw new FrameError("a patch came before its surface");
        checkIndices("a patch", at, vertices);
        const write = (name: string, source: Float32Array | Int16Array | null, width: number) => {
            const attribute = geometry.getAttribute(name) as THREE.BufferAttribute | undefined;
            if (!source || !attribute) return;
            const target = attribute.array as Float32Array;
            at.forEach((vertex, i) =>
                target.set(source.subarray(width * i, width * i + width), width * vertex),
            );
            attribute.needsUpdate = true;
        };
        write("position", optionalArray(frame, "position", "f32", 3, at.length), 3);
        write("normal", optionalArray(frame, "normal", "i16", 4, at.length), 4);
        const value =
            optionalArray(frame, "error", "f32", 1, at.length) ??
            optionalArray(frame, "curvature", "f32", 1, at.length);
        write("value", value, 1);
        this.measure();
    }

    private measure(): void {
        const box = new THREE.Box3().setFromArray(
            this.mesh.geometry.getAttribute("position").array,
        );
        for (const geometry of [this.mesh.geometry, this.edges.geometry]) {
            geometry.boundingBox = box;
            geometry.boundingSphere = box.getBoundingSphere(new THREE.Sphere());
        }
    }
}
