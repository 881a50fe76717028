// Hold to run: while a button is held, leases of a jog are sent, each with the state that was seen last.
import { at, make, put } from "./words.js";

const EVERY = 50; // ms between leases; one holds for 200
const WAYS = [["\u2212x", [-1, 0, 0]], ["+x", [1, 0, 0]], ["\u2212y", [0, -1, 0]], ["+y", [0, 1, 0]], ["down", [0, 0, -1]], ["up", [0, 0, 1]]];

export class Jog {
  constructor(link, orders) {
    this.link = link;
    this.orders = orders;
    this.count = 0;
    at("jog").append(...WAYS.map(([text, way]) => this.button(text, way)));
    at("jog-speed").addEventListener("input", () => this.told());
    link.on("sitting", (sitting) => { this.sitting = sitting; this.told(); }).on("hello", () => { this.count = 0; }).on("lost", () => this.end());
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

  get speed() { return (this.sitting?.jog_speed ?? 0) * Number(at("jog-speed").value) / 100; }

  told() { put(at("jog-told"), `${Math.round(1e3 * this.speed)} mm/s`); }

  allow(control) {
    const may = this.orders.mine && control?.known && ["idle", "manual"].includes(control.state);
    for (const each of at("jog").children) each.disabled = !may;
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
