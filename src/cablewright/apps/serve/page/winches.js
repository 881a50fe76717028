// Single winches, behind a switch: the first press begins, leases go on while it is held, and letting go ends it.
import { END, EVERY, holds } from "./jog.js";
import { at, make, put, t } from "./words.js";

export class Winches {
  constructor(link, orders, jog) {
    this.link = link;
    this.orders = orders;
    this.jog = jog;
    at("winch-on").addEventListener("change", () => this.allow());
    link.on("sitting", (sitting) => this.begin(sitting)).on("state", () => this.allow()).on("lost", () => this.end());
    for (const [what, kind] of END) what.addEventListener(kind, () => this.end());
  }

  begin({ winch_names: names }) {
    this.end();
    this.there = Boolean(names);
    at("winch-on").checked = false;
    at("winches").replaceChildren(...(names ?? []).map((name, k) => make("li", {}, this.button(k, name, -1), make("strong", { textContent: name }), this.button(k, name, 1))));
    this.allow();
  }

  button(k, name, way) {
    const made = make("button", { type: "button", textContent: t(way < 0 ? "winch.in" : "winch.out"), disabled: true });
    made.setAttribute("aria-label", t(way < 0 ? "winch.in.label" : "winch.out.label", { name }));
    holds(made, () => this.hold(made, k, way), () => this.end());
    return made;
  }

  get why() { // why no winch can be turned now; empty: one can
    const { orders } = this, { control } = orders;
    if (!this.there) return t("winch.none");
    if (!orders.mine) return orders.why("release");
    return control?.state === "idle" || this.timer ? "" : t("why.winch");
  }

  allow() {
    const { why } = this, on = at("winch-on");
    on.disabled = !this.there || !this.orders.mine;
    if (!this.orders.mine) on.checked = false;
    put(at("winch-why"), why);
    at("winches").hidden = !on.checked;
    for (const each of at("winches").querySelectorAll("button")) each.disabled = Boolean(why) || !on.checked;
    if (this.timer && (!this.orders.mine || !["idle", "tensioning"].includes(this.orders.control?.state))) this.end();
  }

  async hold(button, k, way) {
    if (this.timer || button.disabled) return;
    const speed = way * this.jog.speed;
    this.turned = [k, speed];
    this.held = button;
    button.classList.add("held");
    this.timer = setInterval(() => this.link.stale ? this.end() : this.lease(speed), EVERY);
    if (await this.orders.give("take up", { winch: [k, speed] })) this.end();
  }

  lease(speed) { this.link.send({ t: "jog", seq: ++this.jog.count, beat: this.link.beat, winch: [this.turned[0], speed] }); }

  end() {
    if (!this.timer) return;
    clearInterval(this.timer);
    this.timer = null;
    this.held.classList.remove("held");
    this.lease(0); // it slows down immediately; without it, when the last lease ends
  }
}
