// A path of any length: all of its vertices in two textures, and a list of the pieces that are drawn now.
//
// Vertices are in the order of the path. Each has a level: with those up to level L joined, nothing of the path is
// farther from what is drawn than tolerances[L] (m). What is chosen is less than a pixel off, unless one turns the view
// on a machine that cannot draw that much at once.
import {
  Box3, BufferAttribute, BufferGeometry, DataTexture, DoubleSide, GLSL3, InstancedBufferAttribute,
  InstancedBufferGeometry, LineSegments, Mesh, NearestFilter, RGBAIntegerFormat, ShaderMaterial, UnsignedByteType,
  UnsignedShortType, Vector2, Vector3,
} from "three";
import { unpacked } from "./data.js";
import { box, LAID, PAINT, QUAD, QUAD_INDEX, rampTexture, TRAVEL, UNKNOWN, WIDE } from "./ribbon.js";

const CHUNK = 512; // vertices of a part that is drawn or not
const ROW = 2048; // texels in a row of the textures
const SHADES = 249; // last step of a colour scale

// An instance, or a vertex of plain lines, has the numbers of its piece's vertices.
const COMMON = `
  uniform highp usampler2D uPlaces; uniform highp usampler2D uMarks; uniform vec3 uOrigin; uniform float uStep;
  uniform float uNow; uniform vec3 uPlain; uniform vec3 uUnknown; uniform vec3 uAhead; uniform vec3 uTravel;
  uniform float uByValue;
  flat out vec3 vColour; out float vValue; out float vLight;
  vec3 place(uint id) { return uOrigin + uStep * vec3(texelFetch(uPlaces, ivec2(id % ${ROW}u, id / ${ROW}u), 0).xyz); }
  uvec2 mark(uint id) { return texelFetch(uMarks, ivec2(id % ${ROW}u, id / ${ROW}u), 0).xy; }
  void paint(uint id, uint own, uint kind, float light) { // the piece that ends at id, with the value of own
    bool ahead = float(id) > uNow;
    uint value = mark(own).y;
    vLight = light;
    vValue = uByValue > 0.5 && value < 255u && !ahead && kind != ${TRAVEL}u ? float(value) : -1.0;
    vColour = ahead ? uAhead : kind == ${TRAVEL}u ? uTravel : uByValue > 0.5 ? uUnknown : uPlain;
  }`;
const THIN = `${COMMON}
  void main() {
    uint id = uint(gl_VertexID);
    paint(id, id, mark(id).x, 1.0);
    gl_Position = projectionMatrix * modelViewMatrix * vec4(place(id), 1.0);
  }`;
const THICK = `${COMMON}${WIDE}
  in uvec2 piece;
  void main() {
    uint kind = mark(piece.y).x;
    paint(piece.y, position.x < 0.5 ? piece.x : piece.y, kind, 1.0);
    gl_Position = wide(place(piece.x), place(piece.y), position.xy, kind == ${TRAVEL}u ? max(1.0, 0.5 * uWidth) : uWidth);
  }`;
const STRAND = `${COMMON}
  uniform vec2 uBead; in uvec2 piece;
  void main() {
    uint kind = mark(piece.y).x;
    paint(piece.y, position.x < 0.5 ? piece.x : piece.y, kind, 1.0);
    vec3 from = place(piece.x), to = place(piece.y), way = to - from;
    float size = length(way);
    way = size > 1e-9 ? way / size : vec3(1.0, 0.0, 0.0);
    vec3 side = length(way.xy) > 1e-6 ? normalize(vec3(-way.y, way.x, 0.0)) : vec3(0.0, 1.0, 0.0);
    vec3 at = mix(from, to, position.x) + side * position.y * uBead.x + vec3(0.0, 0.0, position.z * uBead.y);
    at += way * (2.0 * position.x - 1.0) * 0.3 * uBead.x;
    vec3 face = normal.x * way + normal.y * side + vec3(0.0, 0.0, normal.z);
    vLight = 0.55 + 0.45 * max(0.0, dot(face, normalize(vec3(0.3, -0.5, 0.8))));
    bool drawn = kind == ${LAID}u && float(piece.y) <= uNow;
    gl_Position = drawn ? projectionMatrix * modelViewMatrix * vec4(at, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  }`;

export class Path {
  static async of(given, software) {
    const made = new Path();
    const names = ["places", "layer", "kind", "level", "sample", "time", "line"];
    const arrays = await Promise.all(names.map((name) => unpacked(given[name])));
    names.forEach((name, k) => { made[name] = arrays[k]?.values ?? null; });
    made.quantities = await Promise.all(given.quantities.map(async (each) => ({ ...each, values: (await unpacked(each.values)).values })));
    for (const key of ["origin", "step", "tolerances", "layers", "bead", "line_name"]) made[key] = given[key];
    made.n = made.kind.length;
    made.wideUpTo = software ? { still: 12_000, moving: 300 } : { still: 150_000, moving: 150_000 }; // pieces
    made.most = software ? 400_000 : 4_000_000; // pieces in one frame, without those of the coarsest level
    made.prepare();
    return made;
  }

  prepare() {
    this.quantity = this.quantities[0] ?? null;
    const rows = Math.max(1, Math.ceil(this.n / ROW));
    const places = new Uint16Array(4 * ROW * rows);
    for (let i = 0; i < this.n; i++) for (let axis = 0; axis < 3; axis++) places[4 * i + axis] = this.places[3 * i + axis];
    this.marks = new Uint8Array(4 * ROW * rows);
    for (let i = 0; i < this.n; i++) this.marks[4 * i] = this.kind[i];
    this.textures = { places: texture(places, rows, UnsignedShortType, "RGBA16UI"), marks: texture(this.marks, rows, UnsignedByteType, "RGBA8UI") };
    this.uniforms = {
      uPlaces: { value: this.textures.places }, uMarks: { value: this.textures.marks }, uStep: { value: this.step },
      uOrigin: { value: new Vector3(...this.origin) }, uNow: { value: this.n }, uRamp: { value: null },
      uPlain: { value: new Vector3() }, uUnknown: { value: new Vector3() }, uAhead: { value: new Vector3() },
      uTravel: { value: new Vector3() }, uByValue: { value: 0 }, uSize: { value: new Vector2(1, 1) }, uWidth: { value: 2.2 },
      uBias: { value: 0 }, uBead: { value: new Vector2(...(this.bead ?? [1, 1])) },
    };
    const material = (vertexShader) => new ShaderMaterial({ vertexShader, fragmentShader: PAINT, glslVersion: GLSL3, side: DoubleSide, uniforms: this.uniforms });
    this.thin = new LineSegments(new BufferGeometry(), material(THIN));
    this.thick = new Mesh(instanced(QUAD, null, QUAD_INDEX), material(THICK));
    this.deposit = this.bead ? new Mesh(instanced(...box(), null), material(STRAND)) : null;
    for (const mesh of [this.thin, this.thick, this.deposit]) if (mesh) mesh.frustumCulled = mesh.visible = false;
    this.levels();
    this.divide();
    this.shown = { low: 0, high: this.layers.length, laid: true, travel: true, ahead: true };
    this.now = this.n ? this.sample[this.n - 1] : 0;
  }

  levels() { // the vertices of each level, in order
    this.ids = this.tolerances.map((_, level) => {
      let count = 0;
      for (let i = 0; i < this.n; i++) count += this.level[i] <= level;
      const ids = new Uint32Array(count);
      count = 0;
      for (let i = 0; i < this.n; i++) if (this.level[i] <= level) ids[count++] = i;
      return ids;
    });
  }

  divide() { // into chunks that end at vertices of all levels
    const ends = [0];
    for (const id of this.ids[0]) if (id - ends.at(-1) >= CHUNK) ends.push(id);
    if (this.n && ends.at(-1) !== this.n - 1) ends.push(this.n - 1);
    this.chunks = ends.slice(1).map((last, k) => ({ first: ends[k], last, box: this.around(ends[k], last) }));
    this.starts = this.ids.map((ids) => { // where each chunk begins among the vertices of a level
      let at = 0;
      return ends.map((end) => { while (at < ids.length && ids[at] < end) at++; return at; });
    });
  }

  around(first, last) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = first; i <= last; i++) for (let axis = 0; axis < 3; axis++) {
      const value = this.places[3 * i + axis];
      if (value < low[axis]) low[axis] = value;
      if (value > high[axis]) high[axis] = value;
    }
    const [near, far] = [low, high].map((p) => new Vector3(...p).multiplyScalar(this.step).add(this.uniforms.uOrigin.value));
    return new Box3(near, far);
  }

  place(i) { return [0, 1, 2].map((axis) => this.origin[axis] + this.step * this.places[3 * i + axis]); }

  set now(sample) { // pieces that end later are ahead
    let low = 0, high = this.n;
    while (low < high) {
      const at = (low + high) >> 1;
      if (this.sample[at] <= sample) low = at + 1; else high = at;
    }
    this.uniforms.uNow.value = low - 1;
    if (!this.shown.ahead) this.signature = "";
  }

  colourBy(quantity, colours) {
    this.quantity = quantity;
    this.uniforms.uByValue.value = quantity ? 1 : 0;
    this.uniforms.uRamp.value?.dispose();
    this.uniforms.uRamp.value = rampTexture(colours);
    for (let i = 0; i < this.n; i++) this.marks[4 * i + 1] = quantity ? quantity.values[i] : UNKNOWN;
    this.textures.marks.needsUpdate = true;
  }

  only(shown) { // layers from low to high, by their number in `layers`; what is laid, travel, what is ahead
    Object.assign(this.shown, shown);
    this.signature = "";
  }

  // Choose what is drawn, of pieces whose error is at most `allowed` pixels.
  choose(camera, allowed, moving) {
    const eye = camera.eye.position, wanted = new Int8Array(this.chunks.length);
    let hash = 0;
    this.chunks.forEach(({ box: around }, k) => {
      wanted[k] = camera.sees(around) ? this.levelFor(allowed * camera.pixel(Math.max(camera.eye.near, around.distanceToPoint(eye)))) : -1;
      hash = (hash * 31 + wanted[k] + 7) | 0;
    });
    if (this.count(wanted) > this.most) { this.choose(camera, 2 * allowed, moving); return; }
    const signature = `${hash} ${moving}`;
    if (signature === this.signature) return;
    this.signature = signature;
    this.list(wanted, moving ? this.wideUpTo.moving : this.wideUpTo.still);
  }

  levelFor(error) {
    const at = this.tolerances.findIndex((each) => each <= error);
    return at < 0 ? this.tolerances.length - 1 : at;
  }

  count(wanted) { // pieces, before layers are left out
    let sum = 0;
    wanted.forEach((level, k) => { if (level > 0) sum += this.starts[level][k + 1] - this.starts[level][k]; });
    return sum;
  }

  list(wanted, widest) { // the numbers of both vertices of all pieces
    const most = this.count(wanted) + this.ids[0].length;
    if (!this.pairs || this.pairs.length < 2 * most) this.pairs = new Uint32Array(Math.max(64, Math.ceil(2.6 * most)));
    let count = 0;
    wanted.forEach((level, k) => {
      if (level < 0) return;
      const ids = this.ids[level], stop = this.starts[level][k + 1];
      for (let at = this.starts[level][k] + 1; at <= stop && at < ids.length; at++)
        if (this.shows(ids[at])) { this.pairs[count++] = ids[at - 1]; this.pairs[count++] = ids[at]; }
    });
    this.pieces = count / 2;
    this.draw(count, this.pieces <= widest);
  }

  shows(i) { // whether the piece that ends at a vertex is drawn
    const { low, high, laid, travel, ahead } = this.shown;
    return (this.kind[i] === LAID ? laid : this.kind[i] === TRAVEL && travel) && this.layer[i] >= low && this.layer[i] <= high
      && (ahead || i <= this.uniforms.uNow.value);
  }

  draw(count, wide) {
    this.thick.visible = wide;
    this.thin.visible = !wide;
    this.buffer(count);
    if (wide) this.thick.geometry.instanceCount = this.pieces;
    if (this.deposit) this.deposit.geometry.instanceCount = this.pieces;
    this.thin.geometry.setDrawRange(0, wide ? 0 : count);
  }

  buffer(count) { // one list for all three; a longer one gets new buffers
    if (this.held !== this.pairs) {
      this.held = this.pairs;
      const make = (Kind, size) => new Kind(this.pairs, size);
      this.thin.geometry.dispose();
      this.thin.geometry.setIndex(make(BufferAttribute, 1));
      const pieces = make(InstancedBufferAttribute, 2);
      for (const mesh of [this.thick, this.deposit].filter(Boolean)) {
        mesh.geometry.dispose();
        mesh.geometry.setAttribute("piece", pieces);
      }
      this.lists = [this.thin.geometry.index, pieces];
    }
    for (const each of this.lists) {
      each.clearUpdateRanges();
      each.addUpdateRange(0, count);
      each.needsUpdate = true;
    }
  }

  value(quantity, i) { // to the resolution of the scale; null where it is not known
    const step = quantity.values[i];
    return step === UNKNOWN ? null : quantity.low + (quantity.high - quantity.low) * step / SHADES;
  }
}

function texture(values, rows, type, format) {
  const made = new DataTexture(values, ROW, rows, RGBAIntegerFormat, type);
  made.internalFormat = format;
  made.minFilter = made.magFilter = NearestFilter;
  made.unpackAlignment = 1;
  made.needsUpdate = true;
  return made;
}

function instanced(position, normal, index) {
  const made = new InstancedBufferGeometry();
  made.setAttribute("position", position);
  if (normal) made.setAttribute("normal", normal);
  if (index) made.setIndex(index);
  made.instanceCount = 0;
  return made;
}
