// The robot: frame, beams, walls, sheaves, sagging lines, platform, and the labels beside them.
import {
  BoxGeometry, BufferAttribute, BufferGeometry, CylinderGeometry, DoubleSide, Group, Matrix4, Mesh, MeshLambertMaterial,
  Quaternion, SphereGeometry, TorusGeometry, Vector3,
} from "three";
import { unpacked } from "./data.js";
import { LAID, LEVELS, lineMaterial, rampTexture, Ribbon, UNKNOWN } from "./ribbon.js";

const STEPS = 65535;

// Grid of 16 bits around all that a scene has.
export class Grid {
  constructor(low, high) {
    this.low = low;
    this.step = Math.max(...low.map((v, i) => high[i] - v), 1e-9) / STEPS;
  }

  apply(material) {
    material.uniforms.uOrigin.value.set(...this.low);
    material.uniforms.uStep.value = this.step;
    return material;
  }

  // pieces: [[from, to], ...] in m
  ribbon(pieces, material) {
    const places = new Uint16Array(8 * pieces.length), marks = new Uint8Array(8 * pieces.length);
    pieces.flat().forEach((point, k) => {
      point.forEach((v, axis) => { places[4 * k + axis] = Math.max(0, Math.min(STEPS, Math.round((v - this.low[axis]) / this.step))); });
      marks[4 * k] = k % 2;
      marks[4 * k + 1] = UNKNOWN;
    });
    return new Ribbon(places, marks, material);
  }
}

const corners = (low, high) => [...Array(8).keys()].map((k) => [0, 1, 2].map((axis) => (k >> axis & 1 ? high : low)[axis]));

export function boxEdges(low, high) {
  const all = corners(low, high), made = [];
  for (let k = 0; k < 8; k++) for (const bit of [1, 2, 4]) if (!(k & bit)) made.push([all[k], all[k | bit]]);
  return made;
}

export function ground(low, high) { // the frame's floor, in squares of a round size
  const wide = Math.max(high[0] - low[0], high[1] - low[1]), z = low[2], made = [];
  const power = 10 ** Math.floor(Math.log10(wide / 5)), step = [5, 2, 1].map((f) => f * power).find((s) => s <= wide / 5) ?? power;
  for (const [axis, other] of [[0, 1], [1, 0]])
    for (let v = Math.ceil(low[axis] / step + 1e-6) * step; v < high[axis] - 1e-6 * step; v += step) {
      const from = [0, 0, z], to = [0, 0, z];
      from[axis] = to[axis] = v; from[other] = low[other]; to[other] = high[other];
      made.push([from, to]);
    }
  return { pieces: made, step };
}

export class Lines { // sagging lines of one state at a time, coloured by tension
  static async of(frames, grid) {
    const made = new Lines();
    made.curves = await unpacked(frames.curves); // (F, m, k, 3)
    made.tensions = await unpacked(frames.tensions); // (F, m)
    made.grid = grid;
    const [, m, k] = made.curves.shape;
    made.m = m; made.k = k;
    made.material = grid.apply(lineMaterial(2.6, 1e-5));
    made.ribbon = new Ribbon(new Uint16Array(4 * m * k), new Uint8Array(4 * m * k), made.material);
    return made;
  }

  colourBy(scale, colours) {
    this.scale = scale;
    const own = this.material.uniforms;
    own.uRamp.value?.dispose();
    own.uRamp.value = rampTexture(colours);
    own.uByValue.value = scale ? 1 : 0;
  }

  tension(frame, line) { return this.tensions ? this.tensions.values[frame * this.m + line] : NaN; }

  show(frame) {
    const { m, k, scale } = this, places = this.ribbon.places.array, marks = this.ribbon.marks.array;
    for (let i = 0; i < m; i++) {
      const t = this.tension(frame, i);
      const step = !scale || !Number.isFinite(t) ? UNKNOWN
        : Math.round((LEVELS - 1) * Math.max(0, Math.min(1, (t - scale.low) / (scale.high - scale.low))));
      for (let j = 0; j < k; j++) {
        const to = 4 * (i * k + j), from = 3 * ((frame * m + i) * k + j);
        for (let axis = 0; axis < 3; axis++) places[to + axis] = this.curves.values[from + axis];
        marks[to] = j ? LAID : 0;
        marks[to + 1] = step;
      }
    }
    this.ribbon.changed();
  }

  points(frame, line) {
    return [...Array(this.k).keys()].map((j) => [0, 1, 2].map((axis) =>
      this.grid.low[axis] + this.grid.step * this.curves.values[3 * ((frame * this.m + line) * this.k + j) + axis]));
  }
}

export class Parts { // bodies, whose colours follow the page
  constructor() { this.materials = {}; }

  material(token, opacity = 1) {
    const key = `${token} ${opacity}`;
    this.materials[key] ??= { token, made: new MeshLambertMaterial({
      side: DoubleSide, flatShading: true, transparent: opacity < 1, opacity, depthWrite: opacity === 1,
      polygonOffset: token === "--estimate", polygonOffsetFactor: 2, polygonOffsetUnits: 2, // behind the truth where both are
    }) };
    return this.materials[key].made;
  }

  recolour(colour) { for (const { token, made } of Object.values(this.materials)) made.color.setRGB(...colour(token)); }

  sheave(radius, token) {
    const made = new Group();
    made.add(new Mesh(new TorusGeometry(radius, 0.14 * radius, 8, 28), this.material(token)));
    const hub = new Mesh(new CylinderGeometry(0.25 * radius, 0.25 * radius, 0.3 * radius, 12), this.material(token));
    hub.rotation.x = Math.PI / 2;
    made.add(hub);
    return made;
  }

  rod(from, to, radius, token) {
    const a = new Vector3(...from), b = new Vector3(...to), made = new Mesh(new CylinderGeometry(radius, radius, a.distanceTo(b), 12), this.material(token));
    made.position.addVectors(a, b).multiplyScalar(0.5);
    made.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), b.sub(a).normalize());
    return made;
  }

  platform(given, size, token, opacity = 1) {
    const made = new Group(), nozzle = new Vector3(...given.nozzle);
    for (const [low, high] of given.boxes) {
      const sides = low.map((v, i) => high[i] - v), box = new Mesh(new BoxGeometry(...sides), this.material(token, opacity));
      box.position.set(...low.map((v, i) => (v + high[i]) / 2));
      made.add(box);
    }
    if (given.hull) made.add(new Mesh(geometry(new Float32Array(given.hull.vertices.flat()), new Uint32Array(given.hull.faces.flat())), this.material(token, opacity * (given.boxes.length ? 0.25 : 0.85))));
    if (!given.boxes.length && !given.hull) made.add(new Mesh(new SphereGeometry(0.008 * size, 20, 14), this.material(token, opacity)));
    const length = Math.max(nozzle.length(), 0), tip = 0.012 * size;
    const cone = new Mesh(new CylinderGeometry(0.35 * tip, 0.05 * tip, tip, 16), this.material("--nozzle", opacity));
    cone.rotation.x = Math.PI / 2; // its point is down
    cone.position.copy(nozzle).z += tip / 2;
    made.add(cone);
    if (given.kind === "rigid" && length > 2 * tip) made.add(this.rod([0, 0, 0], given.nozzle, 0.15 * tip, token));
    return made;
  }

  mesh(vertices, faces, token, opacity) { return new Mesh(geometry(vertices, faces), this.material(token, opacity)); }

  wall(points, token) {
    return this.mesh(new Float32Array(points.flat()), new Uint32Array([0, 1, 2, 0, 2, 3]), token, 0.18);
  }

  ellipsoid(token) { return new Mesh(new SphereGeometry(1, 28, 18), this.material(token, 0.35)); }
}

function geometry(vertices, faces) {
  const made = new BufferGeometry();
  made.setAttribute("position", new BufferAttribute(vertices, 3));
  made.setIndex(new BufferAttribute(faces, 1));
  made.computeVertexNormals();
  return made;
}

export function posed(object, pose) { // position, and rotation vector
  object.position.set(...pose.slice(0, 3));
  const turn = new Vector3(...(pose.length > 3 ? pose.slice(3, 6) : [0, 0, 0])), angle = turn.length();
  object.quaternion.copy(angle > 0 ? new Quaternion().setFromAxisAngle(turn.divideScalar(angle), angle) : new Quaternion());
}

export function facing(object, centre, axis) { // a sheave at its centre, turned about its axis
  object.position.set(...centre);
  object.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...axis));
}

export function stretched(object, centre, axes, times) { // a unit sphere to an ellipsoid of three half axes
  const [x, y, z] = [0, 1, 2].map((k) => new Vector3(...axes.slice(3 * k, 3 * k + 3)).multiplyScalar(times));
  object.matrixAutoUpdate = false;
  object.matrix.copy(new Matrix4().makeBasis(x, y, z)).setPosition(...centre);
}
