// What is drawn, and when: one canvas, its camera, the robot, a path, and the time that is shown.
import {
  AmbientLight, Color, ColorManagement, DirectionalLight, Frustum, Group, LinearSRGBColorSpace, Matrix4, Scene, Vector3, WebGLRenderer,
} from "three";
import { Camera, control } from "./camera.js";
import { unpacked } from "./data.js";
import { Path } from "./path.js";
import { lineMaterial, rgb } from "./ribbon.js";
import { boxEdges, facing, Grid, ground, Lines, Parts, posed, stretched } from "./robot.js";
import { Scans } from "./scans.js";

ColorManagement.enabled = false; // colours are those of the page, as they are

const SLOW = 45; // ms that a frame takes
const COARSEST = 32; // pixels of error, while one turns the view
const AGAIN = 180; // ms after a motion until all is drawn as well as can be

export class View {
  constructor(canvas, given) {
    this.canvas = canvas;
    this.given = given;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    const gl = this.renderer.getContext(), about = gl.getExtension("WEBGL_debug_renderer_info");
    this.software = /swiftshader|llvmpipe|software|basic render/i.test(about ? gl.getParameter(about.UNMASKED_RENDERER_WEBGL) : "");
    this.took = this.software ? 150 : 0; // ms
    this.scene = new Scene();
    this.camera = new Camera(given.bounds.low, given.bounds.high);
    this.camera.sees = (box) => this.frustum.intersectsBox(box);
    this.frustum = new Frustum();
    this.frame = 0;
    this.drawn = 0; // pictures so far
    this.allowed = 1; // pixels of error
    this.listeners = [];
    this.groups = Object.fromEntries(["frame", "walls", "lines", "sheaves", "platform", "estimate", "ellipsoid", "path", "deposit", "scans"].map((name) => [name, new Group()]));
    this.scene.add(...Object.values(this.groups), new AmbientLight(0xffffff, 2.0));
    this.sun = new DirectionalLight(0xffffff, 1.7);
    this.scene.add(this.sun);
    this.looks = []; // [material, token] of lines of one colour
    this.extras = {}; // groups of meshes, points and tracks by name
  }

  static async of(canvas, given) {
    const view = new View(canvas, given);
    const { frames } = given;
    view.grid = new Grid(given.bounds.low, given.bounds.high);
    view.parts = new Parts();
    view.poses = await unpacked(frames.poses);
    view.count = view.poses.shape[0];
    view.lines = await Lines.of(frames, view.grid);
    for (const name of ["sheaves", "times", "samples", "estimates", "ellipsoids", "layers", "fileLines"]) view[name] = await unpacked(frames[name]);
    view.scans = await Scans.of(frames, view.grid);
    view.path = given.path ? await Path.of(given.path, view.software) : null;
    view.least = view.software && view.path ? Math.max(1, Math.min(16, view.path.n / 20_000)) : 1;
    await view.build();
    view.theme();
    control(canvas, view.camera, () => view.changed(true), (event) => view.hover?.(event));
    new ResizeObserver(() => view.resize()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { view.theme(); view.show(view.frame); });
    view.resize();
    view.camera.home();
    view.show(frames.shown ?? 0);
    return view;
  }

  plain(pieces, token, width, group, bias = 0) {
    if (!pieces.length) return null;
    const material = this.grid.apply(lineMaterial(width, bias)), made = this.grid.ribbon(pieces, material);
    this.looks.push([material, token]);
    group.add(made.mesh);
    return made;
  }

  async build() {
    const { given, groups, parts } = this, size = this.camera.size, { low, high } = given.frame;
    const floor = ground(low, high);
    this.floorStep = floor.step;
    this.plain(floor.pieces, "--grid", 1, groups.frame);
    this.plain(boxEdges(low, high), "--edge", 1.2, groups.frame);
    for (const { start, end, radius } of given.beams) groups.frame.add(parts.rod(start, end, radius, "--beam"));
    for (const { corners } of given.walls) {
      groups.walls.add(parts.wall(corners, "--wall"));
      this.plain(corners.map((p, k) => [p, corners[(k + 1) % 4]]), "--edge", 1, groups.walls);
    }
    const dead = given.lines.flatMap(({ dead }) => dead.slice(1).map((p, k) => [dead[k], p]));
    this.plain(dead, "--dead", 1.6, groups.lines);
    groups.lines.add(this.lines.ribbon.mesh);
    this.wheels = given.lines.map(({ sheave }) => sheave ? parts.sheave(sheave.radius, "--sheave") : null);
    for (const wheel of this.wheels) if (wheel) groups.sheaves.add(wheel);
    this.plain(given.lines.map(({ exit }) => [exit, exit]), "--plain", 6, groups.frame, 2e-5);
    groups.platform.add(parts.platform(given.platform, size, "--platform"));
    if (this.estimates) groups.estimate.add(parts.platform(given.platform, size, "--estimate", 0.55));
    if (this.ellipsoids) groups.ellipsoid.add(parts.ellipsoid("--estimate"));
    if (this.scans) {
      this.looks.push([this.scans.material, "--scan"]);
      groups.scans.add(this.scans.ribbon.mesh);
    }
    if (this.path) groups.path.add(this.path.thin, this.path.thick);
    if (this.path?.deposit) groups.deposit.add(this.path.deposit);
    for (const each of given.meshes) this.extra(each, parts.mesh((await unpacked(each.vertices)).values, (await unpacked(each.faces)).values, each.token, each.opacity));
    for (const each of given.tracks) {
      const { values, shape } = await unpacked(each.places), pieces = [];
      const point = (k) => [...values.slice(3 * k, 3 * k + 3)];
      for (let k = 1; k < shape[0]; k++) if (Number.isFinite(values[3 * k]) && Number.isFinite(values[3 * k - 3])) pieces.push([point(k - 1), point(k)]);
      const group = new Group();
      this.plain(pieces, each.token, 1.6, group, 2e-6);
      this.extra(each, group);
    }
    for (const each of given.points) {
      const { values, shape } = await unpacked(each.places), s = 0.006 * size, group = new Group();
      const cross = (k) => { const [x, y, z] = values.slice(3 * k, 3 * k + 3); return [[[x - s, y, z], [x + s, y, z]], [[x, y - s, z], [x, y + s, z]]]; };
      this.plain([...Array(shape[0]).keys()].flatMap(cross), each.token, 2, group);
      this.extra(each, group);
    }
  }

  extra(each, object) {
    object.visible = each.shown !== false;
    this.extras[each.name] = object;
    this.scene.add(object);
  }

  theme() {
    const style = getComputedStyle(this.canvas), token = (name) => rgb(style.getPropertyValue(name).trim() || "#888888");
    this.dark = style.getPropertyValue("--scheme").trim() === "dark";
    this.renderer.setClearColor(new Color().setRGB(...token("--stage")), 1);
    this.parts.recolour(token);
    for (const [material, name] of this.looks) material.uniforms.uPlain.value.set(...token(name));
    const own = this.lines.material.uniforms, path = this.path?.uniforms;
    for (const each of [own, path]) {
      each?.uUnknown.value.set(...token("--unknown"));
      each?.uPlain.value.set(...token("--plain"));
    }
    path?.uAhead.value.set(...token("--ahead"));
    path?.uTravel.value.set(...token("--travel"));
    this.lines.colourBy(this.given.tension_scale, this.ramp("tension"));
    if (this.path) this.path.colourBy(this.path.quantity, this.ramp(this.path.quantity?.colours ?? "error"));
    this.changed();
    for (const told of this.listeners) told("theme");
  }

  ramp(name) { return this.given.colours[name][this.dark ? "dark" : "light"]; }

  colourBy(key) {
    this.path.colourBy(this.path.quantities.find((each) => each.key === key) ?? null, this.ramp(this.path.quantities.find((each) => each.key === key)?.colours ?? "error"));
    this.changed();
  }

  pose(frame = this.frame) {
    const width = this.poses.shape[1];
    return [...this.poses.values.slice(frame * width, (frame + 1) * width)];
  }

  show(frame) {
    this.frame = Math.max(0, Math.min(this.count - 1, frame));
    this.lines.show(this.frame);
    this.scans?.show(this.frame);
    posed(this.groups.platform, this.pose());
    if (this.sheaves) {
      const m = this.wheels.length;
      this.wheels.forEach((wheel, i) => {
        if (!wheel) return;
        const at = 6 * (this.frame * m + i), own = [...this.sheaves.values.slice(at, at + 6)];
        wheel.visible = own.every(Number.isFinite);
        if (wheel.visible) facing(wheel, own.slice(0, 3), own.slice(3));
      });
    }
    const width = this.poses.shape[1], guessed = this.estimates && [...this.estimates.values.slice(this.frame * width, (this.frame + 1) * width)];
    const known = Boolean(guessed) && guessed.every(Number.isFinite);
    this.groups.estimate.visible = known && this.wantsEstimate !== false;
    if (known) posed(this.groups.estimate, guessed);
    if (this.ellipsoids) {
      const axes = [...this.ellipsoids.values.slice(9 * this.frame, 9 * this.frame + 9)];
      this.groups.ellipsoid.visible = axes.every(Number.isFinite) && this.wantsEllipsoid !== false;
      if (this.groups.ellipsoid.visible) stretched(this.groups.ellipsoid.children[0], (known ? guessed : this.pose()).slice(0, 3), axes, this.given.frames.ellipsoid_times);
    }
    if (this.path && this.samples && this.gone) this.path.now = this.samples.values[this.frame]; // all of it until one moves the time
    this.changed();
    for (const told of this.listeners) told("frame");
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    const first = !this.camera.width;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio || 1));
    this.renderer.setSize(width, height, false);
    this.camera.resize(width, height);
    if (first || this.untouched) this.camera.fit();
    this.changed();
  }

  changed(moving = false) {
    if (moving) this.move();
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => this.draw());
  }

  move() { // as good as can be again once nothing has moved for a while
    this.untouched = false;
    if (!this.moving) this.allowed = Math.max(this.least, this.allowed / 2);
    this.moving = true;
    clearTimeout(this.later);
    this.later = setTimeout(() => { this.moving = false; this.changed(); }, AGAIN + 3 * this.took);
  }

  draw() {
    this.waiting = false;
    const { camera, renderer } = this;
    camera.place();
    this.frustum.setFromProjectionMatrix(new Matrix4().multiplyMatrices(camera.eye.projectionMatrix, camera.eye.matrixWorldInverse));
    this.sun.position.copy(camera.eye.position).sub(camera.target).add(new Vector3(0, 0, 0.5 * camera.distance));
    const sizes = [this.lines.material, this.path, ...this.looks.map(([each]) => each)].filter(Boolean);
    for (const { uniforms } of sizes) uniforms.uSize.value.set(camera.width / 2, camera.height / 2);
    this.path?.choose(camera, this.moving ? this.allowed : 1, Boolean(this.moving));
    renderer.render(this.scene, camera.eye);
    this.drawn++;
    this.pace();
    for (const told of this.listeners) told("drawn");
  }

  pace() { // coarser while a large scene is rotated
    const began = performance.now();
    requestAnimationFrame(() => {
      this.took = performance.now() - began;
      if (this.moving && this.took > SLOW) this.allowed = Math.min(COARSEST, this.allowed * Math.min(4, this.took / SLOW));
    });
  }

  project(point) { // to pixels of the canvas, and the depth
    const p = new Vector3(...point).project(this.camera.eye);
    return [(p.x + 1) / 2 * this.camera.width, (1 - p.y) / 2 * this.camera.height, p.z];
  }
}
