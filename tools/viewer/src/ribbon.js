// Lines of a width in pixels: one instance per piece between two vertices of one buffer.
//
// A vertex has four 16-bit numbers (its place on a grid, and 0) and four 8-bit numbers: what the piece that ends there is
// (LIFTED: nothing), the step of its value in the colour scale (UNKNOWN: none), and two that are not used.
import {
  BufferAttribute, DataTexture, DoubleSide, GLSL3, InstancedBufferGeometry, InstancedInterleavedBuffer,
  InterleavedBufferAttribute, Mesh, NearestFilter, RGBAFormat, ShaderMaterial, Vector2, Vector3,
} from "three";

export const LIFTED = 0, LAID = 1, TRAVEL = 2, UNKNOWN = 255;
export const LEVELS = 250; // of a colour scale

// What both kinds of lines have in common: a piece between two places, and its colour by value or plain.
export const WIDE = `
  uniform vec2 uSize; uniform float uWidth; uniform float uBias;
  vec4 wide(vec3 begin, vec3 end, vec2 corner, float width) {
    vec4 from = projectionMatrix * modelViewMatrix * vec4(begin, 1.0);
    vec4 to = projectionMatrix * modelViewMatrix * vec4(end, 1.0);
    float near = 1e-4;
    if (from.w < near && to.w < near) return vec4(2.0, 2.0, 2.0, 1.0);
    if (from.w < near) from = mix(to, from, (to.w - near) / (to.w - from.w));
    if (to.w < near) to = mix(from, to, (from.w - near) / (from.w - to.w));
    vec2 along = (to.xy / to.w - from.xy / from.w) * uSize;
    float size = length(along);
    along = size > 1e-6 ? along / size : vec2(1.0, 0.0);
    vec4 at = corner.x < 0.5 ? from : to;
    vec2 off = 0.5 * width * (vec2(-along.y, along.x) * corner.y + along * (2.0 * corner.x - 1.0) * (size < 1e-6 ? 1.0 : 0.6));
    at.xy += off / uSize * at.w;
    at.z -= uBias * at.w;
    return at;
  }`;

const LINE = `${WIDE}
  in vec4 a; in vec4 b; in vec4 before; in vec4 mark;
  uniform vec3 uOrigin; uniform float uStep; uniform vec3 uPlain; uniform vec3 uUnknown; uniform float uByValue;
  flat out vec3 vColour; out float vValue; out float vLight;
  void main() {
    bool known = before.y < 254.5 && mark.y < 254.5;
    vLight = 1.0;
    vValue = uByValue > 0.5 && known ? mix(before.y, mark.y, position.x) : -1.0;
    vColour = uByValue > 0.5 ? uUnknown : uPlain;
    gl_Position = mark.x < 0.5 ? vec4(2.0, 2.0, 2.0, 1.0)
      : wide(uOrigin + uStep * a.xyz, uOrigin + uStep * b.xyz, position.xy, uWidth);
  }`;

export const PAINT = `
  uniform sampler2D uRamp; flat in vec3 vColour; in float vValue; in float vLight; out vec4 painted;
  void main() {
    vec3 own = vValue < 0.0 ? vColour : texture(uRamp, vec2((vValue + 0.5) / 256.0, 0.5)).rgb;
    painted = vec4(own * vLight, 1.0);
  }`;

export const lineMaterial = (width, bias = 0) => new ShaderMaterial({
  vertexShader: LINE, fragmentShader: PAINT, glslVersion: GLSL3, side: DoubleSide,
  uniforms: {
    uOrigin: { value: new Vector3() }, uStep: { value: 1 }, uRamp: { value: null }, uPlain: { value: new Vector3() },
    uUnknown: { value: new Vector3() }, uByValue: { value: 0 }, uSize: { value: new Vector2(1, 1) },
    uWidth: { value: width }, uBias: { value: bias },
  },
});

export const QUAD = new BufferAttribute(new Float32Array([0, -1, 0, 1, -1, 0, 0, 1, 0, 1, 1, 0]), 3);
export const QUAD_INDEX = new BufferAttribute(new Uint16Array([0, 1, 2, 2, 1, 3]), 1);
export function box() { // x from 0 to 1 along the piece, y to either side, z from -1 (the bottom) to 0
  const corners = [], normals = [];
  const face = (normal, ...points) => {
    for (const k of [0, 1, 2, 2, 1, 3]) { corners.push(...points[k]); normals.push(...normal); }
  };
  for (const x of [0, 1]) face([2 * x - 1, 0, 0], [x, -0.5, -1], [x, 0.5, -1], [x, -0.5, 0], [x, 0.5, 0]);
  for (const y of [-0.5, 0.5]) face([0, 2 * y, 0], [0, y, -1], [1, y, -1], [0, y, 0], [1, y, 0]);
  face([0, 0, 1], [0, -0.5, 0], [1, -0.5, 0], [0, 0.5, 0], [1, 0.5, 0]);
  return [new BufferAttribute(new Float32Array(corners), 3), new BufferAttribute(new Float32Array(normals), 3)];
}

export class Ribbon {
  // places: Uint16Array, 4 numbers a vertex; marks: Uint8Array, 4 numbers a vertex
  constructor(places, marks, own) {
    this.places = new InstancedInterleavedBuffer(places, 4);
    this.marks = new InstancedInterleavedBuffer(marks, 4);
    this.count = Math.max(0, places.length / 4 - 1);
    this.mesh = new Mesh(this.geometry(QUAD, QUAD_INDEX), own);
    this.mesh.frustumCulled = false;
    this.mesh.matrixAutoUpdate = false;
  }

  geometry(position, index) {
    const made = new InstancedBufferGeometry();
    made.setAttribute("position", position);
    if (index) made.setIndex(index);
    made.setAttribute("a", new InterleavedBufferAttribute(this.places, 4, 0));
    made.setAttribute("b", new InterleavedBufferAttribute(this.places, 4, 4));
    made.setAttribute("before", new InterleavedBufferAttribute(this.marks, 4, 0));
    made.setAttribute("mark", new InterleavedBufferAttribute(this.marks, 4, 4));
    made.instanceCount = this.count;
    return made;
  }

  changed() { this.places.needsUpdate = true; this.marks.needsUpdate = true; }
}

export function rampTexture(colours) { // 250 steps of a scale, of any number of #rrggbb
  const pixels = new Uint8Array(256 * 4), stops = colours.map(rgb);
  for (let i = 0; i < 256; i++) {
    const at = Math.min(1, i / (LEVELS - 1)) * (stops.length - 1), k = Math.min(stops.length - 2, Math.floor(at));
    for (let c = 0; c < 3; c++) pixels[4 * i + c] = Math.round(255 * (stops[k][c] + (at - k) * (stops[k + 1][c] - stops[k][c])));
    pixels[4 * i + 3] = 255;
  }
  const made = new DataTexture(pixels, 256, 1, RGBAFormat);
  made.minFilter = made.magFilter = NearestFilter;
  made.needsUpdate = true;
  return made;
}

export function rgb(text) { // of #rrggbb, 0 to 1
  const n = parseInt(text.trim().slice(1), 16);
  return [(n >> 16 & 255) / 255, (n >> 8 & 255) / 255, (n & 255) / 255];
}
