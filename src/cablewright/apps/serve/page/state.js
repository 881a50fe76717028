// State, reason, progress, and the estimate of the platform.
import { at, fixed, has, put, span, t, worded } from "./words.js";

const MOVING = ["ready", "printing", "manual", "tensioning", "homing"];

export function turns(control) { return Boolean(control.speeds?.some((speed) => speed !== 0)); }

export function atRest(control) { return !MOVING.includes(control.state) && !turns(control); }

const capital = (text) => `${text[0].toUpperCase()}${text.slice(1)}.`;

function named(control) { // the state's word, and how it looks
  const { state } = control;
  if (state === "closed") return control.opening ? [t("name.opening"), ""] : [t("name.closed"), "bad"];
  if (state === "fault") return control.fresh && !turns(control) ? [t("name.fresh"), ""] : [t("name.fault"), "bad"];
  const key = `name.${state}.${turns(control) ? "moving" : "standing"}`;
  return [has(key) ? t(key) : state, atRest(control) ? "" : "moves"];
}

export class State {
  constructor(link) {
    link.on("sitting", (sitting) => this.begin(sitting)).on("state", (message) => this.show(message));
    link.on("lost", () => this.greyed(true));
    this.link = link;
    setInterval(() => this.greyed(link.stale), 100);
  }

  begin(sitting) {
    this.sitting = sitting;
    put(at("machine"), sitting.machine);
    put(at("kind"), t(sitting.kind === "simulated" ? "kind.simulated" : "kind.real", { robot: sitting.robot }));
    at("progress").hidden = !sitting.job;
    put(at("job"), sitting.job?.name ?? "");
    document.title = t("title", { machine: sitting.machine });
  }

  greyed(stale) {
    document.body.classList.toggle("stale", stale);
    const gone = (performance.now() - this.link.seen + this.link.age) / 1e3;
    const told = !stale ? "" : Number.isFinite(gone) && gone < 1e5 ? t("stale", { s: gone.toFixed(1) }) : t("unheard");
    put(at("stale-told"), told);
    at("stale-told").hidden = !stale;
  }

  show({ control }) {
    if (!control) return;
    const { state, reason } = control, pill = at("state"), [word, kind] = named(control);
    put(pill, word);
    pill.className = `pill ${kind}`;
    const told = control.fresh ? t("told.fresh") : control.waiting ? t("told.waiting") : reason ? capital(worded("reason", reason)) : has(`told.${state}`) ? t(`told.${state}`) : "";
    put(at("reason"), told);
    if (!control.platform) return;
    const { position, velocity, valid, deviation, rotation, nozzle } = control.platform;
    const spread = deviation ? `, \u00b1${fixed(1e3 * Math.max(...deviation), 1)} mm` : "";
    put(at("position"), valid ? `(${position.map((v) => fixed(v, 3)).join(", ")}) m${spread}` : t("unknown"));
    this.fact("rotation", Boolean(nozzle), valid ? `(${rotation.map((v) => fixed((180 * v) / Math.PI, 2)).join(", ")})\u00b0` : t("unknown"));
    this.fact("nozzle", Boolean(nozzle), valid && nozzle ? `(${nozzle.map((v) => fixed(v, 3)).join(", ")}) m` : t("unknown"));
    put(at("speed"), valid ? `${fixed(1e3 * Math.hypot(...velocity), 0)} mm/s` : t("unknown"));
    put(at("time"), span(control.time));
    this.fact("damping", this.sitting?.damped === true, t(control.damping ? "damped" : "undamped"));
    this.fact("powder", this.sitting?.powder != null, `${fixed(control.powder, 1)} kg`);
    this.fact("chain", Boolean(control.inputs), t(control.inputs?.torque_off ? "chain.off" : control.inputs?.chain ? "chain.closed" : "chain.open"));
    this.fact("barrier", "barrier" in control, t(control.barrier ? "barrier.broken" : "barrier.clear"));
    this.progress(control);
  }

  fact(name, known, text) {
    at(`${name}-fact`).hidden = !known;
    if (known) put(at(name), text);
  }

  progress(control) {
    const path = this.sitting?.path;
    if (!path || control.distance === undefined) return;
    at("bar").value = Math.min(1, control.distance / path.length);
    put(at("layer"), t("of", { a: control.layer, b: path.layers }));
    put(at("distance"), t("of.m", { a: fixed(control.distance, 2), b: fixed(path.length, 2) }));
    const share = Math.round(100 * control.share);
    put(at("left"), control.finished ? t("left.done") : control.left === null ? t("left.stands") : t("left.at", { time: span(control.left), share }));
  }
}
