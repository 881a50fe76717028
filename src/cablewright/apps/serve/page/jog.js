// Hold to run, or a step. While a button is held, leases of a jog are sent, each with the state that was seen last.
import { atRest } from "./state.js";
import { at, fixed, make, put, t } from "./words.js";

export const EVERY = 50; // ms between leases; one holds for 200
export const END = [[window, "blur"], [window, "pagehide"], [document, "visibilitychange"]]; // that let go
const NEAR = 2e-2; // m, within which the platform stands where a way was checked from
const STEPS = [0, 1e-3, 1e-2, 0.1]; // m; 0: hold
const WORDS = [["\u2212x", "+x"], ["\u2212y", "+y"], ["jog.down", "jog.up"]];
const KEYS = ["ArrowLeft", "ArrowRight", "ArrowDown", "ArrowUp", "PageDown", "PageUp"]; // of the buttons, in their order

function ways(plane) { // buttons in pairs, back and forth: along the axes, or the two directions of the platform's plane
  return (plane?.along ?? [[1, 0, 0], [0, 1, 0], [0, 0, 1]]).flatMap((along) => {
    const sizes = along.map(Math.abs), axis = sizes.indexOf(Math.max(...sizes)), aside = sizes[axis] < 1 - 1e-9;
    const forth = along.map((v) => v * Math.sign(along[axis])), back = forth.map((v) => -v);
    return [back, forth].map((way, k) => [(axis === 2 ? t(WORDS[2][k]) : WORDS[axis][k]) + (aside ? t("jog.inplane") : ""), way]);
  });
}

export function holds(button, begin, end) { // a button that acts as long as it is held
  button.addEventListener("pointerdown", (event) => { if (event.button === 0) { button.setPointerCapture(event.pointerId); begin(); } });
  for (const kind of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) button.addEventListener(kind, end);
  button.addEventListener("keydown", (event) => { if ([" ", "Enter"].includes(event.key)) { event.preventDefault(); if (!event.repeat) begin(); } });
  button.addEventListener("keyup", end);
  button.addEventListener("contextmenu", (event) => event.preventDefault());
}

export class Jog {
  constructor(link, orders) {
    this.link = link;
    this.orders = orders;
    this.count = 0;
    this.step = 0; // m of each press; 0: as long as it is held
    at("step").append(...STEPS.map((step) => make("label", {}, make("input", { type: "radio", name: "step", checked: step === 0, onchange: () => { this.end(); this.step = step; } }), step ? ` ${1e3 * step} mm` : ` ${t("jog.hold")}`)));
    at("jog-speed").addEventListener("input", () => this.told());
    at("goto").addEventListener("submit", (event) => { event.preventDefault(); this.go(this.goal()); });
    at("jog").addEventListener("keydown", (event) => this.key(event));
    at("jog").addEventListener("keyup", ({ key }) => { if (KEYS.includes(key)) this.end(); });
    link.on("sitting", (sitting) => this.sit(sitting)).on("hello", () => { this.count = 0; }).on("lost", () => this.end());
    link.on("state", ({ control }) => this.allow(control)).on("jog", () => this.end());
    for (const [what, kind] of END) what.addEventListener(kind, () => this.end());
  }

  button(text, way) {
    const made = make("button", { type: "button", textContent: text, disabled: true });
    made.setAttribute("aria-label", t("jog.label", { way: text }));
    holds(made, () => this.begin(made, way), () => this.end());
    return made;
  }

  key(event) { // arrows, of whatever button has the focus
    const button = at("jog").children[KEYS.indexOf(event.key)];
    if (!button) return;
    event.preventDefault();
    if (!event.repeat) this.begin(button, this.ways[KEYS.indexOf(event.key)][1]);
  }

  sit(sitting) {
    this.sitting = sitting;
    const { plane } = sitting;
    this.ways = ways(plane);
    this.end();
    at("jog").replaceChildren(...this.ways.map(([text, way]) => this.button(text, way)));
    if (plane) this.decided = plane.normal.map(Math.abs).indexOf(Math.max(...plane.normal.map(Math.abs))); // an axis
    else this.decided = null;
    put(at("goal-told"), plane ? t("goto.plane", { axes: "xyz".replace("xyz"[this.decided], "").split("").join(", "), axis: "xyz"[this.decided] }) : "x, y, z");
    this.told();
  }

  get here() { // of the point that is moved, m
    const platform = this.orders.control?.platform;
    return platform?.valid ? platform.nozzle ?? platform.position : null;
  }

  inPlane(place) { // the coordinate that the plane decides, from the others
    const { plane } = this.sitting;
    if (!plane) return place;
    const { normal, distance } = plane, found = place.with(this.decided, 0);
    found[this.decided] = (distance - normal.reduce((sum, n, k) => sum + n * found[k], 0)) / normal[this.decided];
    return found;
  }

  goal() { // of the form; what the plane decides is left out there
    return this.completed(at("goal").value.trim().split(/[,;\s]+/).map(Number));
  }

  completed(given) { return this.sitting.plane && given.length === 2 ? this.inPlane(given.toSpliced(this.decided, 0, 0)) : given; }

  stands(from) { // still at rest there: the way that was checked begins there
    const { here, orders } = this;
    return Boolean(here && from && atRest(orders.control)) && here.every((v, k) => Math.abs(v - from[k]) < NEAR);
  }

  async go(place) { // once the way was checked, and a person has confirmed it; why not is answered
    const { orders, here } = this, told = place.map((v) => fixed(v, 3)).join(", ");
    const rejected = (why) => { orders.say(t("goto.rejected", { why })); return why; };
    if (here && !this.stands(here)) return rejected(t("goto.moves"));
    orders.say(t("goto.checking"));
    const found = await this.link.ask("/reach", { method: "POST", body: JSON.stringify({ position: place }) }).catch((reason) => ({ holds: false, why: reason.message }));
    if (!found.holds) return rejected(found.why);
    if (!this.stands(here)) return rejected(t("goto.moves"));
    orders.say("");
    const sure = await orders.sure(t("sure.goto"), t("sure.goto.text", { place: told, length: fixed(found.length, 3), clear: t("clear") }), t("yes"));
    if (sure && !this.stands(here)) return rejected(t("goto.moves"));
    return sure ? orders.give("go to", { position: place }) : t("console.asked");
  }

  get speed() { return (this.sitting?.jog_speed ?? 0) * Number(at("jog-speed").value) / 100; }

  told() { put(at("jog-told"), `${Math.round(1e3 * this.speed)} mm/s`); }

  get may() { const { control, mine } = this.orders; return mine && control?.known && ["idle", "manual"].includes(control.state); }

  allow(control) {
    const { may } = this;
    for (const each of [...at("jog").children, at("goto-yes")]) each.disabled = !may;
    put(at("jog-why"), may ? "" : t("jog.grey", { why: this.orders.mine ? t("why.hand") : this.orders.why("release") }));
    if (!may) this.end();
  }

  begin(button, way) {
    if (this.timer || button.disabled) return;
    if (this.step) { this.once(way); return; }
    this.held = button;
    button.classList.add("held");
    const lease = () => this.link.stale ? this.end() : this.send(way);
    lease();
    this.timer = setInterval(lease, EVERY);
  }

  once(way) { // a step from where it stands; a second press waits until it stands again
    const { here, orders } = this;
    if (here && atRest(orders.control)) orders.give("go to", { position: this.inPlane(here.map((v, k) => v + way[k] * this.step)) });
  }

  send(way) { this.link.send({ t: "jog", seq: ++this.count, beat: this.link.beat, velocity: way.map((v) => v * this.speed) }); }

  end() {
    if (!this.timer) return;
    clearInterval(this.timer);
    this.timer = null;
    this.held.classList.remove("held");
    this.send([0, 0, 0]); // slows down immediately; without it, when the lease ends
  }
}
