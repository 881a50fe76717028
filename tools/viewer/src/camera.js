// Orbit, pan, zoom: mouse, keyboard, and touch that leaves one finger's way up and down to the page.
import { PerspectiveCamera, Vector3 } from "three";

const FIELD = 24 * Math.PI / 180, UP = new Vector3(0, 0, 1);
const HOME = { azimuth: -62, elevation: 22 }; // degrees

export class Camera {
  constructor(low, high) {
    this.eye = new PerspectiveCamera(FIELD * 180 / Math.PI, 1, 0.01, 100);
    this.eye.up.copy(UP);
    this.target = new Vector3();
    this.whole = [new Vector3(...low), new Vector3(...high)];
    this.size = this.whole[0].distanceTo(this.whole[1]);
    Object.assign(this, HOME);
    this.distance = this.size;
    this.aspect = 1;
    this.smallest = 1e-4 * this.size; // of the distance
  }

  resize(width, height) { this.aspect = width / height; this.height = height; this.width = width; }

  // the whole of a box in view, from where one looks now
  fit(low = this.whole[0], high = this.whole[1]) {
    this.target.addVectors(low, high).multiplyScalar(0.5);
    const { right, up, back } = this.axes(), slope = Math.tan(FIELD / 2), wide = slope * Math.min(this.aspect, 3);
    let distance = 0;
    for (let k = 0; k < 8; k++) {
      const p = new Vector3(...[0, 1, 2].map((i) => (k >> i & 1 ? high : low).getComponent(i))).sub(this.target);
      const depth = p.dot(back);
      distance = Math.max(distance, depth + Math.abs(p.dot(up)) / slope, depth + Math.abs(p.dot(right)) / wide);
    }
    this.distance = Math.max(1.08 * distance, this.smallest);
  }

  home() { Object.assign(this, HOME); this.fit(); }

  look(azimuth, elevation) { this.azimuth = azimuth; this.elevation = elevation; this.fit(); }

  axes() {
    const a = this.azimuth * Math.PI / 180, e = this.elevation * Math.PI / 180;
    const back = new Vector3(Math.cos(a) * Math.cos(e), Math.sin(a) * Math.cos(e), Math.sin(e));
    const right = new Vector3(-Math.sin(a), Math.cos(a), 0);
    return { back, right, up: new Vector3().crossVectors(back, right) };
  }

  place() {
    const { back, up } = this.axes(), span = this.size + this.distance;
    this.eye.position.copy(this.target).addScaledVector(back, this.distance);
    this.eye.up.copy(up);
    this.eye.lookAt(this.target);
    this.eye.aspect = this.aspect;
    this.eye.near = Math.max(this.distance - this.size, this.distance * 2e-3);
    this.eye.far = span + this.size;
    this.eye.updateProjectionMatrix();
    this.eye.updateMatrixWorld();
  }

  pixel(distance = this.distance) { return 2 * Math.tan(FIELD / 2) * distance / Math.max(1, this.height); } // m

  turn(azimuth, elevation) {
    this.azimuth += azimuth;
    this.elevation = Math.max(-89.9, Math.min(89.9, this.elevation + elevation));
  }

  pan(dx, dy) { // pixels
    const { right, up } = this.axes(), m = this.pixel();
    this.target.addScaledVector(right, -dx * m).addScaledVector(up, dy * m);
  }

  zoom(factor, x = 0, y = 0) { // x, y: pixels from the middle that stay where they are
    const next = Math.max(this.smallest, Math.min(6 * this.size, this.distance / factor)), before = this.pixel();
    const { right, up } = this.axes(), moved = before - this.pixel(next);
    this.target.addScaledVector(right, x * moved).addScaledVector(up, -y * moved);
    this.distance = next;
  }
}

const KEYS = {
  ArrowLeft: (c, s) => s ? c.pan(24, 0) : c.turn(5, 0), ArrowRight: (c, s) => s ? c.pan(-24, 0) : c.turn(-5, 0),
  ArrowUp: (c, s) => s ? c.pan(0, 24) : c.turn(0, 5), ArrowDown: (c, s) => s ? c.pan(0, -24) : c.turn(0, -5),
  "+": (c) => c.zoom(1.2), "=": (c) => c.zoom(1.2), "-": (c) => c.zoom(1 / 1.2), 0: (c) => c.home(),
  1: (c) => c.look(-90, 0), 2: (c) => c.look(0, 0), 3: (c) => c.look(-90, 89.9),
};

export function control(canvas, camera, changed, moved) {
  const fingers = new Map();
  const middle = () => {
    const all = [...fingers.values()];
    return { x: mean(all.map((p) => p.x)), y: mean(all.map((p) => p.y)), gap: all.length > 1 ? gap(all) : 0 };
  };
  let last = null;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    last = middle();
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) { moved(event); return; }
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const now = middle(), dx = now.x - last.x, dy = now.y - last.y;
    if (fingers.size === 1) {
      const shift = event.shiftKey || event.buttons & 6; // right or middle button
      if (event.pointerType === "touch") camera.turn(-0.4 * dx, 0);
      else if (shift) camera.pan(dx, dy);
      else camera.turn(-0.4 * dx, 0.4 * dy);
    } else {
      const box = canvas.getBoundingClientRect();
      camera.pan(dx, dy);
      if (last.gap > 0 && now.gap > 0)
        camera.zoom(now.gap / last.gap, now.x - box.left - box.width / 2, now.y - box.top - box.height / 2);
    }
    last = now;
    changed();
  });
  for (const kind of ["pointerup", "pointercancel"])
    canvas.addEventListener(kind, (event) => { fingers.delete(event.pointerId); last = fingers.size ? middle() : null; });
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas) return; // the page scrolls until the view is clicked
    event.preventDefault();
    const box = canvas.getBoundingClientRect();
    camera.zoom(Math.exp(-event.deltaY * 0.0015), event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2);
    changed();
  }, { passive: false });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("keydown", (event) => {
    const act = KEYS[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act(camera, event.shiftKey);
    changed();
  });
}

const mean = (values) => values.reduce((sum, value) => sum + value, 0) / Math.max(1, values.length);
const gap = ([p, q]) => Math.hypot(p.x - q.x, p.y - q.y);
