// A path of any length: an overview, and chunks whose detail is made when one comes near.
//
// Vertices are in the order of the path. Each has a level: at level L those up to L are joined, and nothing of the path
// is farther from what is drawn than tolerances[L] (m), which is to be less than a pixel.
import { Vector3 } from "three";
import { unpacked } from "./data.js";
import { lineMaterial, rampTexture, Ribbon, strandMaterial, UNKNOWN } from "./ribbon.js";

const CHUNK = 4096; // vertices
const CACHE = 1_500_000; // vertices of chunks that are kept
const FINE = 20_000; // pieces up to which lines are wide

export class Path {
  static async of(given) {
    const made = new Path();
    const names = ["places", "layer", "kind", "level", "sample", "time", "line"];
    const arrays = await Promise.all(names.map((name) => unpacked(given[name])));
    names.forEach((name, k) => { made[name] = arrays[k]?.values ?? null; });
    made.quantities = await Promise.all(given.quantities.map(async (each) => ({ ...each, values: (await unpacked(each.values)).values })));
    for (const key of ["origin", "step", "tolerances", "layers", "bead", "worst", "line_name"]) made[key] = given[key];
    made.n = made.kind.length;
    made.prepare();
    return made;
  }

  prepare() {
    this.quantity = this.quantities[0] ?? null;
    this.lines = lineMaterial(2);
    this.strands = this.bead ? strandMaterial(...this.bead) : null;
    this.lines.uniforms.uOrigin.value.set(...this.origin);
    this.lines.uniforms.uStep.value = this.step;
    const ids = [];
    for (let i = 0; i < this.n; i++) if (this.level[i] === 0) ids.push(i);
    this.overview = this.ribbon(Uint32Array.from(ids));
    this.chunks = [];
    for (let first = 0; first < this.n - 1; first += CHUNK) this.chunks.push(this.chunk(first, Math.min(this.n - 1, first + CHUNK)));
    this.kept = 0; // vertices of all chunks
    this.turn = 0;
    this.now = this.n ? this.sample[this.n - 1] : 0;
    if (this.strands) {
      this.deposit = this.overview.strands(this.strands);
      this.deposit.visible = false;
      this.strands.uniforms.uOrigin = this.lines.uniforms.uOrigin;
      this.strands.uniforms.uStep = this.lines.uniforms.uStep;
      for (const key of ["uLayers", "uKinds", "uByValue", "uRamp", "uPlain", "uUnknown", "uAhead", "uTravel"])
        this.strands.uniforms[key] = this.lines.uniforms[key];
      this.splitting(this.deposit, this.overview);
    }
  }

  place(i) { return [0, 1, 2].map((axis) => this.origin[axis] + this.step * this.places[3 * i + axis]); }

  chunk(first, last) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = first; i <= last; i++) for (let axis = 0; axis < 3; axis++) {
      const value = this.places[3 * i + axis];
      if (value < low[axis]) low[axis] = value;
      if (value > high[axis]) high[axis] = value;
    }
    const [near, far] = [low, high].map((p) => new Vector3(...p).multiplyScalar(this.step).add(new Vector3(...this.origin)));
    return { first, last, centre: near.clone().add(far).multiplyScalar(0.5), radius: near.distanceTo(far) / 2, ribbons: new Map() };
  }

  ribbon(ids) {
    const places = new Uint16Array(4 * ids.length), marks = new Uint8Array(4 * ids.length);
    ids.forEach((id, k) => {
      for (let axis = 0; axis < 3; axis++) places[4 * k + axis] = this.places[3 * id + axis];
      places[4 * k + 3] = this.layer[id];
      marks[4 * k] = k ? this.kind[id] : 0;
    });
    const made = new Ribbon(places, marks, this.lines);
    made.ids = ids;
    this.coloured(made);
    this.splitting(made.mesh, made);
    return made;
  }

  coloured(ribbon) {
    const values = this.quantity?.values, marks = ribbon.marks.array;
    ribbon.ids.forEach((id, k) => { marks[4 * k + 1] = values ? values[id] : UNKNOWN; });
    ribbon.marks.needsUpdate = true;
  }

  splitting(mesh, ribbon) { // what is done by now is told from what is ahead, buffer by buffer
    mesh.onBeforeRender = (_renderer, _scene, _camera, _geometry, material) => {
      material.uniforms.uSplit.value = this.before(ribbon.ids) - 1;
      material.uniformsNeedUpdate = true;
    };
  }

  before(ids) { // how many of these vertices are reached by now
    let low = 0, high = ids.length;
    while (low < high) {
      const at = (low + high) >> 1;
      if (this.sample[ids[at]] <= this.now) low = at + 1; else high = at;
    }
    return low;
  }

  colourBy(quantity, colours) {
    this.quantity = quantity;
    const own = this.lines.uniforms;
    own.uByValue.value = quantity ? 1 : 0;
    own.uRamp.value?.dispose();
    own.uRamp.value = rampTexture(colours);
    this.coloured(this.overview);
    for (const chunk of this.chunks) for (const each of chunk.ribbons.values()) this.coloured(each);
  }

  // Choose what is drawn, of pieces whose error is at most `allowed` pixels; group: where meshes are put.
  choose(group, camera, allowed) {
    const shown = new Set();
    this.turn++;
    this.pieces = 0;
    const level = (distance) => {
      const error = allowed * camera.pixel(distance), at = this.tolerances.findIndex((each) => each <= error);
      return at < 0 ? this.tolerances.length - 1 : at;
    };
    const eye = camera.eye.position, nearest = camera.eye.near;
    const wanted = this.chunks.map((each) => level(Math.max(nearest, eye.distanceTo(each.centre) - each.radius)));
    if (!wanted.some(Boolean)) {
      shown.add(this.overview.mesh);
      this.pieces = this.overview.count;
    } else {
      this.chunks.forEach((chunk, k) => {
        const ribbon = this.detail(chunk, wanted[k]);
        ribbon.turn = this.turn;
        shown.add(ribbon.mesh);
        if (camera.sees(chunk.centre, chunk.radius)) this.pieces += ribbon.count;
      });
      this.forget();
    }
    for (const mesh of [...group.children]) if (!shown.has(mesh)) group.remove(mesh);
    for (const mesh of shown) if (mesh.parent !== group) group.add(mesh);
    this.lines.uniforms.uWidth.value = this.pieces <= FINE ? 2.2 : 1.4;
  }

  detail(chunk, level) {
    let made = chunk.ribbons.get(level);
    if (made) return made;
    const ids = [];
    for (let i = chunk.first; i <= chunk.last; i++)
      if (this.level[i] <= level || i === chunk.first || i === chunk.last) ids.push(i);
    made = this.ribbon(Uint32Array.from(ids));
    made.within(chunk.centre, chunk.radius);
    chunk.ribbons.set(level, made);
    this.kept += ids.length;
    return made;
  }

  forget() { // what was not drawn for long, once there is too much
    if (this.kept <= CACHE) return;
    for (const chunk of this.chunks) for (const [level, each] of chunk.ribbons) {
      if (each.turn >= this.turn - 30) continue;
      this.kept -= each.ids.length;
      each.dispose();
      chunk.ribbons.delete(level);
    }
  }

  shownLayer(i) {
    const { x, y } = this.lines.uniforms.uLayers.value, kinds = this.lines.uniforms.uKinds.value;
    const own = this.kind[i] === 1 ? kinds.x : kinds.y;
    return own > 0.5 && this.layer[i] >= x && this.layer[i] <= y;
  }

  value(quantity, i) { // as far as 250 steps tell it; null where it is not known
    const step = quantity.values[i];
    return step === UNKNOWN ? null : quantity.low + (quantity.high - quantity.low) * step / 249;
  }
}
