// Lines of a width in pixels, and strands as boxes: one instance per piece between two vertices of one buffer.
//
// A vertex has four 16-bit numbers (its place on a grid, and its layer) and four 8-bit numbers: what the piece that ends
// there is (LIFTED: nothing), the step of its value in the colour scale (UNKNOWN: none), and two that are not used.
import {
  BufferAttribute, DataTexture, DoubleSide, GLSL3, InstancedBufferGeometry, InstancedInterleavedBuffer,
  InterleavedBufferAttribute, Mesh, NearestFilter, RGBAFormat, ShaderMaterial, Sphere, Vector2, Vector3,
} from "three";

export const LIFTED = 0, LAID = 1, TRAVEL = 2, DASHED = 3, UNKNOWN = 255;
export const LEVELS = 250; // of a colour scale

const PLACES = `
  in vec4 a; in vec4 b; in vec4 mark;
  uniform vec3 uOrigin; uniform float uStep; uniform float uSplit; uniform vec2 uLayers; uniform vec2 uKinds;
  uniform sampler2D uRamp; uniform vec3 uPlain; uniform vec3 uUnknown; uniform vec3 uAhead; uniform float uByValue;
  uniform vec3 uTravel; uniform float uShowAhead;
  flat out vec3 vColour;
  bool hidden() {
    bool ahead = float(gl_InstanceID) >= uSplit;
    return mark.x < 0.5 || b.w < uLayers.x || b.w > uLayers.y || (mark.x == 1.0 && uKinds.x < 0.5)
      || (mark.x == 2.0 && uKinds.y < 0.5) || (ahead && uShowAhead < 0.5);
  }
  vec3 colour() {
    vec3 own = uPlain;
    if (uByValue > 0.5) {
      own = mark.y > 254.5 ? uUnknown : texture(uRamp, vec2((mark.y + 0.5) / 256.0, 0.5)).rgb;
    }
    if (mark.x == 2.0) own = uTravel;
    return float(gl_InstanceID) >= uSplit ? uAhead : own;
  }`;

const LINE = `${PLACES}
  uniform vec2 uSize; uniform float uWidth; uniform float uBias;
  void main() {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    vColour = vec3(0.0);
    if (hidden()) return;
    vec4 from = projectionMatrix * modelViewMatrix * vec4(uOrigin + uStep * a.xyz, 1.0);
    vec4 to = projectionMatrix * modelViewMatrix * vec4(uOrigin + uStep * b.xyz, 1.0);
    float near = 1e-4;
    if (from.w < near && to.w < near) return;
    if (from.w < near) from = mix(to, from, (to.w - near) / (to.w - from.w));
    if (to.w < near) to = mix(from, to, (from.w - near) / (from.w - to.w));
    vec2 along = (to.xy / to.w - from.xy / from.w) * uSize;
    float size = length(along);
    along = size > 1e-6 ? along / size : vec2(1.0, 0.0);
    float width = mark.x == 2.0 ? max(1.0, 0.5 * uWidth) : uWidth;
    vec4 at = position.x < 0.5 ? from : to;
    vec2 off = 0.5 * width * (vec2(-along.y, along.x) * position.y + along * (2.0 * position.x - 1.0) * (size < 1e-6 ? 1.0 : 0.6));
    at.xy += off / uSize * at.w;
    at.z -= uBias * at.w;
    gl_Position = at;
    vColour = colour();
  }`;

const STRAND = `${PLACES}
  uniform vec2 uBead;
  void main() {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    vColour = vec3(0.0);
    if (hidden() || mark.x != 1.0 || float(gl_InstanceID) >= uSplit) return;
    vec3 from = uOrigin + uStep * a.xyz, to = uOrigin + uStep * b.xyz, way = to - from;
    float size = length(way);
    way = size > 1e-9 ? way / size : vec3(1.0, 0.0, 0.0);
    vec3 side = length(way.xy) > 1e-6 ? normalize(vec3(-way.y, way.x, 0.0)) : vec3(0.0, 1.0, 0.0);
    vec3 at = mix(from, to, position.x) + side * position.y * uBead.x + vec3(0.0, 0.0, position.z * uBead.y);
    at += way * (2.0 * position.x - 1.0) * 0.3 * uBead.x;
    vec3 face = normal.x * way + normal.y * side + vec3(0.0, 0.0, normal.z);
    gl_Position = projectionMatrix * modelViewMatrix * vec4(at, 1.0);
    float light = 0.55 + 0.45 * max(0.0, dot(face, normalize(vec3(0.3, -0.5, 0.8))));
    vColour = colour() * light;
  }`;

const PAINT = `flat in vec3 vColour; out vec4 painted; void main() { painted = vec4(vColour, 1.0); }`;

function material(vertexShader, more) {
  return new ShaderMaterial({
    vertexShader, fragmentShader: PAINT, glslVersion: GLSL3, side: DoubleSide,
    uniforms: {
      uOrigin: { value: new Vector3() }, uStep: { value: 1 }, uSplit: { value: 1e9 },
      uLayers: { value: new Vector2(-1, 1e9) }, uKinds: { value: new Vector2(1, 1) }, uRamp: { value: null },
      uPlain: { value: new Vector3() }, uUnknown: { value: new Vector3() }, uAhead: { value: new Vector3() },
      uTravel: { value: new Vector3() }, uByValue: { value: 0 }, uShowAhead: { value: 1 }, ...more,
    },
  });
}

export const lineMaterial = (width, bias = 0) =>
  material(LINE, { uSize: { value: new Vector2(1, 1) }, uWidth: { value: width }, uBias: { value: bias } });

export const strandMaterial = (width, height) => material(STRAND, { uBead: { value: new Vector2(width, height) } });

const QUAD = new BufferAttribute(new Float32Array([0, -1, 0, 1, -1, 0, 0, 1, 0, 1, 1, 0]), 3);
const QUAD_INDEX = new BufferAttribute(new Uint16Array([0, 1, 2, 2, 1, 3]), 1);
const [BOX, BOX_NORMALS] = box();

function box() { // x from 0 to 1 along the piece, y to either side, z from -1 (the bottom) to 0
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
    made.setAttribute("mark", new InterleavedBufferAttribute(this.marks, 4, 4));
    made.instanceCount = this.count;
    return made;
  }

  strands(own) { // the same pieces as boxes
    const made = this.geometry(BOX, null);
    made.setAttribute("normal", BOX_NORMALS);
    const mesh = new Mesh(made, own);
    mesh.frustumCulled = false;
    return mesh;
  }

  within(centre, radius) { // only drawn where this sphere is seen
    this.mesh.geometry.boundingSphere = new Sphere(centre, radius);
    this.mesh.frustumCulled = true;
  }

  changed() { this.places.needsUpdate = true; this.marks.needsUpdate = true; }

  dispose() { this.mesh.geometry.dispose(); }
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
