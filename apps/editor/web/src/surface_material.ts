// How surfaces are coloured and lit.

import * as THREE from "three";
import { colourTable, type ColourMap } from "./colour_maps";

const vertexShader = /* glsl */ `
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform float exaggeration;
in vec3 position;
in vec4 normal;
in float value;
in vec2 lattice;
out vec3 place;
out vec3 steepness;
out vec3 seen;
out float measure;
out vec2 cell;
void main() {
    vec4 eye = modelViewMatrix * vec4(position, 1.0);
    place = position;
    steepness = normal.xyz;
    seen = position * vec3(1.0, 1.0, exaggeration);
    measure = value;
    cell = lattice;
    gl_Position = projectionMatrix * eye;
}`;

const fragmentShader = /* glsl */ `
precision highp float;
uniform float exaggeration;
uniform int colouring;      // 0 plain, 1 height, 2 slope, 3 value
uniform vec2 range;
uniform sampler2D colours;
uniform vec3 plain;
uniform vec3 sun;
uniform vec3 eyePlace;
uniform bool twoSided;
uniform bool filled;
uniform float gridStep;     // 0: no lines
uniform vec3 gridColour;
uniform float shading;
uniform bool draped;
uniform sampler2D drape;
uniform vec4 drapeRect;
in vec3 place;
in vec3 steepness;
in vec3 seen;
in float measure;
in vec2 cell;
out vec4 colour;

vec3 toLinear(vec3 c) {
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
}

vec3 toScreen(vec3 c) {
    return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}

vec3 baseColour(vec3 n) {
    float slope = degrees(acos(clamp(n.z, -1.0, 1.0)));
    float quantity = colouring == 1 ? place.z : colouring == 2 ? slope : measure;
    float t = clamp((quantity - range.x) / max(range.y - range.x, 1e-30), 0.0, 1.0);
    vec3 base = colouring == 0 ? plain : texture(colours, vec2((t * 255.0 + 0.5) / 256.0, 0.5)).rgb;
    if (draped) {
        vec2 at = (place.xy - drapeRect.xy) / (drapeRect.zw - drapeRect.xy);
        if (all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(1.0)))) {
            vec4 image = texture(drape, vec2(at.x, 1.0 - at.y));
            base = mix(base, image.rgb, image.a);
        }
    }
    return toLinear(base);
}

// Every so many-th line of the lattice, one pixel wide.
float linesOf(vec2 at, vec2 width, float every) {
    vec2 away = abs(fract(at / every - 0.5) - 0.5) * every / max(width, vec2(1e-6));
    return 1.0 - smoothstep(0.5, 1.5, min(away.x, away.y));
}

// Where lines would be closer than 8 pixels, only every 2nd, 4th, .. is drawn; those between fade
// away.
float gridLine() {
    vec2 at = cell / gridStep;
    vec2 width = fwidth(at);
    float crowding = max(0.0, log2(max(max(width.x, width.y) * 8.0, 1e-6)));
    float every = exp2(floor(crowding));
    float between = linesOf(at, width, every) * (1.0 - fract(crowding));
    return max(linesOf(at, width, 2.0 * every), between);
}

void main() {
    float line = gridStep > 0.0 ? gridLine() : 0.0;
    if (!filled && line < 0.1) discard;
    vec3 n = normalize(steepness);
    vec3 lit = normalize(vec3(n.xy, n.z / exaggeration));
    if (twoSided) {
        vec3 face = cross(dFdx(seen), dFdy(seen));
        if (dot(face, eyePlace - seen) < 0.0) face = -face;
        if (dot(lit, face) < 0.0) lit = -lit;
    }
    vec3 towards = normalize(eyePlace - seen);
    float sunlight = max(0.0, dot(lit, sun));
    float light = 0.2 + 0.8 * sunlight + 0.12 * max(0.0, dot(lit, towards)) + 0.08 * lit.z;
    light = mix(1.0, light, shading);
    vec3 base = filled ? baseColour(n) * light : toLinear(gridColour);
    vec3 lined = mix(base, toLinear(gridColour), filled ? 0.55 * line : 0.0);
    colour = vec4(toScreen(clamp(lined, 0.0, 1.0)), 1.0);
}`;

const emptyTexture = new THREE.DataTexture(new Uint8Array([255, 255, 255, 0]), 1, 1);
emptyTexture.needsUpdate = true;

export class SurfaceMaterial extends THREE.RawShaderMaterial {
    private readonly table = new THREE.DataTexture(new Uint8Array(4 * 256), 256, 1);

    constructor() {
        super({
            glslVersion: THREE.GLSL3,
            vertexShader,
            fragmentShader,
            side: THREE.DoubleSide,
            polygonOffset: true,
            polygonOffsetFactor: 1,
            polygonOffsetUnits: 1,
        });
        this.table.magFilter = THREE.LinearFilter;
        this.uniforms = {
            exaggeration: { value: 1 },
            colouring: { value: 0 },
            range: { value: new THREE.Vector2(0, 1) },
            colours: { value: this.table },
            plain: { value: new THREE.Vector3(0.8, 0.8, 0.8) },
            sun: { value: new THREE.Vector3(-0.5, 0.5, 0.7071) },
            eyePlace: { value: new THREE.Vector3() },
            twoSided: { value: false },
            filled: { value: true },
            gridStep: { value: 0 },
            gridColour: { value: new THREE.Vector3() },
            shading: { value: 1 },
            draped: { value: false },
            drape: { value: emptyTexture },
            drapeRect: { value: new THREE.Vector4(0, 0, 1, 1) },
        };
    }

    private set(name: string, value: unknown): void {
        this.uniforms[name].value = value;
    }

    private setColour(name: string, [r, g, b]: readonly [number, number, number]): void {
        (this.uniforms[name].value as THREE.Vector3).set(r / 255, g / 255, b / 255);
    }

    set exaggeration(value: number) {
        this.set("exaggeration", value);
    }

    /** sRGB bytes of a surface without colours by value. */
    set plain(colour: readonly [number, number, number]) {
        this.setColour("plain", colour);
    }

    set grid({ step, colour }: { step: number; colour: readonly [number, number, number] }) {
        this.set("gridStep", step);
        this.setColour("gridColour", colour);
    }

    /** Whether the faces are drawn, or the lines of the lattice alone. */
    set filled(value: boolean) {
        this.set("filled", value);
    }

    set twoSided(value: boolean) {
        this.set("twoSided", value);
    }

    /** Unit vector towards the light, and the eye's place, in the scene. */
    setLight(sun: readonly number[], eye: readonly number[]): void {
        (this.uniforms.sun.value as THREE.Vector3).set(sun[0], sun[1], sun[2]);
        (this.uniforms.eyePlace.value as THREE.Vector3).set(eye[0], eye[1], eye[2]);
    }

    /** Colours from a map over [low, high] of a quantity; the plain colour if there is no map. */
    setColouring(
        quantity: "height" | "slope" | "value",
        map: ColourMap | null,
        low: number,
        high: number,
    ): void {
        const codes = { height: 1, slope: 2, value: 3 };
        this.set("colouring", map ? codes[quantity] : 0);
        // Colours that must be read by the legend are darkened less than those of a landscape.
        this.set("shading", map && quantity !== "height" ? 0.5 : 1);
        (this.uniforms.range.value as THREE.Vector2).set(low, high);
        if (!map) return;
        (this.table.image.data as Uint8Array).set(colourTable(map, 256));
        this.table.needsUpdate = true;
    }

    /** An image over the rectangle x0, y0, x1, y1 of the page; null takes it away. */
    setDrape(image: THREE.Texture | null, rect: readonly [number, number, number, number]): void {
        this.set("draped", image !== null);
        this.set("drape", image ?? emptyTexture);
        (this.uniforms.drapeRect.value as THREE.Vector4).set(...rect);
    }
}
