// Hold to run: while a button is held, leases of a jog are sent, each with the state that was seen last.
import { at, fixed, make, put } from "./words.js";

const EVERY = 50; // ms between leases; one holds for 200
const WORDS = [["\u2212x", "+x"], ["\u2212y", "+y"], ["down", "up"]];

function ways(plane) { // buttons in pairs, back and forth: along the axes, or the two directions of the platform's plane
  return (plane?.along ?? [[1, 0, 0], [0, 1, 0], [0, 0, 1]]).flatMap((along) => {
    const sizes = along.map(Math.abs), axis = sizes.indexOf(Math.max(...sizes)), aside = sizes[axis] < 1 - 1e-9;
    const forth = along.map((v) => v * Math.sign(along[axis])), back = forth.map((v) => -v);
    return [back, forth].map((way, k) => [WORDS[axis][k] + (aside ? " in the plane" : ""), way]);
  });
}

export class Jog {
  constructor(link, orders) {
    this.link = link;
    this.orders = orders;
    this.count = 0;
    at("jog-speed").addEventListener("input", () => this.told());
    at("goto").addEventListener("submit", (event) => { event.preventDefault(); this.go(); });
    link.on("sitting", (sitting) => this.sit(sitting)).on("hello", () => { this.count = 0; }).on("lost", () => this.end());
    link.on("state", ({ control }) => this.allow(control)).on("jog", () => this.end());
    for (const [what, kind] of [[window, "blur"], [window, "pagehide"], [document, "visibilitychange"]]) what.addEventListener(kind, () => this.end());
  }

  button(text, way) {
    const made = make("button", { type: "button", textContent: text, disabled: true });
    made.setAttribute("aria-label", `Move ${text}, while held`);
    const begin = () => this.begin(made, way), end = () => this.end();
    made.addEventListener("pointerdown", (event) => { if (event.button === 0) { made.setPointerCapture(event.pointerId); begin(); } });
    for (const kind of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) made.addEventListener(kind, end);
    made.addEventListener("keydown", (event) => { if ([" ", "Enter"].includes(event.key)) { event.preventDefault(); if (!event.repeat) begin(); } });
    made.addEventListener("keyup", end);
    made.addEventListener("contextmenu", (event) => event.preventDefault());
    return made;
  }

  sit(sitting) {
    this.sitting = sitting;
    const { plane } = sitting, buttons = ways(plane).map(([text, way]) => this.button(text, way));
    this.end();
    at("jog").replaceChildren(...buttons);
    if (plane) this.decided = plane.normal.map(Math.abs).indexOf(Math.max(...plane.normal.map(Math.abs))); // an axis
    put(at("goal-told"), plane ? `${"xyz".replace("xyz"[this.decided], "").split("").join(", ")} (${"xyz"[this.decided]} follows from the plane)` : "x, y, z");
    this.told();
  }

  goal() { // of the point that is moved, m; what the plane decides is left out
    const given = at("goal").value.trim().split(/[,;\s]+/).map(Number), { plane } = this.sitting;
    if (!plane || given.length !== 2) return given;
    const place = given.toSpliced(this.decided, 0, 0), { normal, distance } = plane;
    place[this.decided] = (distance - normal.reduce((sum, n, k) => sum + n * place[k], 0)) / normal[this.decided];
    return place;
  }

  async go() {
    const place = this.goal(), told = place.map((v) => fixed(v, 3)).join(", ");
    const sure = await this.orders.sure("Go there?", `The platform moves straight to (${told}) m. Keep everyone clear of the machine.`, "Yes");
    if (sure) this.orders.give("go to", { position: place });
  }

  get speed() { return (this.sitting?.jog_speed ?? 0) * Number(at("jog-speed").value) / 100; }

  told() { put(at("jog-told"), `${Math.round(1e3 * this.speed)} mm/s`); }

  allow(control) {
    const may = this.orders.mine && control?.known && ["idle", "manual"].includes(control.state);
    for (const each of [...at("jog").children, at("goto-yes")]) each.disabled = !may;
    if (!may) this.end();
  }

  begin(button, way) {
    if (this.timer || button.disabled) return;
    this.held = button;
    button.classList.add("held");
    const lease = () => this.link.stale ? this.end() : this.send(way);
    lease();
    this.timer = setInterval(lease, EVERY);
  }

  send(way) { this.link.send({ t: "jog", seq: ++this.count, beat: this.link.beat, velocity: way.map((v) => v * this.speed) }); }

  end() {
    if (!this.timer) return;
    clearInterval(this.timer);
    this.timer = null;
    this.held.classList.remove("held");
    this.send([0, 0, 0]); // slows down at once; without it, when the lease ends
  }
}
