// The first run of a machine: each step with a picture, a check and a way back. The state decides what is done.
import { at, fixed, force, make, put, t } from "./words.js";

const NEAR = 1e-2; // m, within which a place that was measured agrees
const SQUARE = "first square", PRINTED = /-first-part-of-/; // the job, and its runs
const SVG = "http://www.w3.org/2000/svg", FRAME = "M4 36V4H60V36Z";
const PICTURES = { // 64 x 40: what is there, and what moves or is measured
  machine: [`${FRAME}M4 4L28 18M60 4L36 18M4 36L28 24M60 36L36 24M28 18H36V24H28Z`, ""],
  enable: ["M8 8H30V32H8ZM30 20H60", "M38 11A10 10 0 1 1 38 29M38 29L39 23M38 29L44 28"],
  tension: ["M4 20Q16 34 28 20H60", "M40 12H56M51 7L56 12L51 17"],
  home: [FRAME, "M32 8V32M20 20H44M26 20A6 6 0 1 0 38 20A6 6 0 1 0 26 20"],
  measure: [`${FRAME}M29 17H35V23H29Z`, "M4 20H29M32 23V36"],
  square: [FRAME, "M22 12H42V28H22Z"],
};

export class First {
  constructor(link, orders, jobs, runs, jog) {
    Object.assign(this, { link, orders, jobs, runs, jog });
    this.steps = Object.keys(PICTURES).map((name) => this.step(name));
    at("first").append(...this.steps.map(({ row }) => row));
    at("first-run").addEventListener("toggle", () => localStorage.setItem("first", at("first-run").open ? "open" : "closed"));
    link.on("sitting", (sitting) => this.begin(sitting)).on("state", ({ control }) => this.show(control));
  }

  begin(sitting) {
    if (!this.sitting) at("first-run").open = localStorage.getItem("first") === "open";
    this.sitting = sitting;
  }

  step(name) {
    const picture = document.createElementNS(SVG, "svg");
    for (const [key, value] of [["viewBox", "0 0 64 40"], ["role", "img"], ["aria-label", t(`first.${name}`)]]) picture.setAttribute(key, value);
    for (const [k, way] of PICTURES[name].entries()) {
      const path = document.createElementNS(SVG, "path");
      path.setAttribute("d", way);
      path.setAttribute("class", k ? "moves" : "there");
      picture.append(path);
    }
    const made = { name, check: make("span", { className: "tag" }), shown: make("p"), act: make("button", { type: "button", hidden: true }), back: make("button", { type: "button", hidden: true }) };
    made.field = name === "measure" ? make("input", { autocomplete: "off", placeholder: "0.3, -0.5, 1.0" }) : null;
    made.field?.setAttribute("aria-label", t("first.measure.field"));
    made.act.addEventListener("click", ({ detail }) => { if (detail < 2) made.does?.(); });
    made.back.addEventListener("click", ({ detail }) => { if (detail < 2) made.undoes?.(); });
    made.row = make("li", {}, picture, make("div", {}, make("strong", { textContent: t(`first.${name}`) }), " ", made.check, make("p", { className: "soft", textContent: t(`first.${name}.text`) }), made.shown, make("div", { className: "row" }, made.field, made.act, made.back)));
    return made;
  }

  show(control) {
    if (!at("first-run").open || !this.sitting || !control?.platform) return;
    for (const step of this.steps) {
      const { done, shown = "", act, back } = this[step.name](control, step);
      put(step.check, t(done ? "first.done" : "first.open"));
      step.check.className = `tag ${done ? "yes" : ""}`;
      put(step.shown, shown);
      step.shown.hidden = !shown;
      for (const [button, way, what] of [[step.act, act, "does"], [step.back, back, "undoes"]]) {
        button.hidden = !way;
        step[what] = way?.[1];
        if (!way) continue;
        put(button, way[0]);
        button.title = way[2] ?? "";
        button.disabled = Boolean(way[2]);
      }
    }
  }

  order(kind) { return [t(`order.${kind}`), () => this.orders.asked(kind), this.orders.why(kind)]; }

  mine(text, act) { return [text, act, this.orders.mine ? "" : this.orders.why("release")]; }

  machine() {
    const { robot, machine, lines, frame: [low, high] } = this.sitting, done = localStorage.getItem("known") === machine;
    const known = (name) => () => localStorage.setItem("known", name);
    return { done, act: done ? null : [t("first.machine.yes"), known(machine)], back: done ? [t("first.machine.no"), known("")] : null, shown: t("first.machine.shown", { robot, n: lines.length, size: high.map((v, k) => fixed(v - low[k], 2)).join(" \u00d7 ") }) };
  }

  enable({ state }) {
    const done = !["fault", "off"].includes(state);
    return { done, act: done ? null : this.order(state === "fault" ? "reset" : "enable"), back: done ? this.order("release") : null };
  }

  tension({ lines, measured }) {
    const tensions = measured ?? lines.tensions ?? [], { limits } = this.sitting;
    const held = tensions.length > 0 && tensions.every((each, i) => typeof each === "number" && each >= limits[i][0] && each <= limits[i][1]);
    const known = tensions.filter((each) => typeof each === "number");
    return {
      done: held && !lines.slack.some(Boolean), shown: known.length ? t("first.tension.shown", { low: force(Math.min(...known)), high: force(Math.max(...known)), n: lines.slack.filter(Boolean).length }) : "",
      act: this.orders.has("take up") ? this.order("take up") : null, back: this.order("release"),
    };
  }

  home({ known, platform }) {
    const there = this.orders.has("home");
    return { done: known, shown: known && platform.valid ? t("first.home.shown", { place: this.jog.here.map((v) => fixed(v, 3)).join(", ") }) : there ? "" : t("first.home.none"), act: there ? this.order("home") : null, back: there ? this.order("release") : null };
  }

  measure(control, step) {
    const { measured } = this, compare = () => {
      const place = step.field.value.trim().split(/[,;\s]+/).map(Number), { here } = this.jog;
      this.measured = here && place.length === 3 && place.every(Number.isFinite) ? Math.hypot(...here.map((v, k) => v - place[k])) : NaN;
    };
    const shown = measured === undefined ? "" : Number.isNaN(measured) ? t("first.measure.three") : t(measured <= NEAR ? "first.measure.near" : "first.measure.far", { mm: fixed(1e3 * measured, 1) });
    return { done: measured <= NEAR, shown, act: [t("first.measure.compare"), compare, control.known ? "" : t("why.hand")], back: measured === undefined ? null : [t("first.measure.again"), () => { this.measured = undefined; step.field.value = ""; }] };
  }

  square() {
    const job = this.jobs.jobs.find(({ name }) => name === SQUARE), run = this.runs.runs.find(({ name, status }) => PRINTED.test(name) && status === "finished");
    const away = () => this.jobs.tried(() => this.link.ask(`/jobs/${job.id}`, { method: "DELETE" }));
    if (run) return { done: true, shown: t("first.square.done", { run: run.name }) };
    if (!job) return { done: false, act: this.mine(t("first.square.make"), () => this.jobs.tried(() => this.link.ask("/jobs/first", { method: "POST" }))) };
    const shown = !job.check ? t("next.checking", { name: SQUARE }) : job.check.answer === "yes" ? t("job.yes") : job.check.why;
    const print = this.jobs.printable(job) ? this.mine(t("act.print", { name: SQUARE }), () => this.jobs.printing.ask(job)) : null;
    return { done: false, shown, act: print, back: job.busy || this.sitting.job?.id === job.id ? null : this.mine(t("job.remove"), away) };
  }
}
