// State, reason, progress, and what is known of the platform.
import { at, fixed, put, span } from "./words.js";

// What the state is called while the winches turn, and while they stand.
const NAMES = {
  ready: ["moving to the path", "about to move"], printing: ["printing", "printing: stands at 0 %"], manual: ["moving by hand", "by hand"],
  tensioning: ["taking up slack", "taking up slack"], homing: ["homing", "homing"], idle: ["slowing down", "idle"],
  paused: ["pausing", "paused"], stopped: ["stopping", "stopped"], refilling: ["stopping to refill", "refilling"],
};
const MOVING = ["ready", "printing", "manual", "tensioning", "homing"];

export function turns(control) { return Boolean(control.speeds?.some((speed) => speed !== 0)); }

export function atRest(control) { return !MOVING.includes(control.state) && !turns(control); }

function named(control) { // the state's word, and how it looks
  const { state } = control;
  if (state === "closed") return control.opening ? ["opening", ""] : ["closed", "bad"];
  if (state === "fault") return control.fresh && !turns(control) ? ["off: reset to begin", ""] : ["fault", "bad"];
  const [moving, standing] = NAMES[state] ?? [state, state];
  return [turns(control) ? moving : standing, atRest(control) ? "" : "moves"];
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
    put(at("kind"), sitting.kind === "simulated" ? `simulated machine of ${sitting.robot}` : `machine of ${sitting.robot}`);
    at("progress").hidden = !sitting.job;
    put(at("job"), sitting.job?.name ?? "");
    document.title = `${sitting.machine}: operate`;
  }

  greyed(stale) {
    document.body.classList.toggle("stale", stale);
    const gone = (performance.now() - this.link.seen + this.link.age) / 1e3;
    const told = !stale ? "" : Number.isFinite(gone) && gone < 1e5 ? `No news for ${gone.toFixed(1)} s: what is greyed is old.` : "Nothing was heard of the machine yet.";
    put(at("stale-told"), told);
    at("stale-told").hidden = !stale;
  }

  show({ control }) {
    if (!control) return;
    const { state, reason } = control, pill = at("state"), [word, kind] = named(control);
    put(pill, word);
    pill.className = `pill ${kind}`;
    const told = control.fresh ? FRESH : control.waiting ? WAITING : reason ? reason[0].toUpperCase() + reason.slice(1) + "." : WORDS[state] ?? "";
    put(at("reason"), told);
    if (!control.platform) return;
    const { position, velocity, valid, deviation, rotation, nozzle } = control.platform;
    const spread = deviation ? `, \u00b1${fixed(1e3 * Math.max(...deviation), 1)} mm` : "";
    put(at("position"), valid ? `(${position.map((v) => fixed(v, 3)).join(", ")}) m${spread}` : "not known");
    this.fact("rotation", Boolean(nozzle), valid ? `(${rotation.map((v) => fixed((180 * v) / Math.PI, 2)).join(", ")})\u00b0` : "not known");
    this.fact("nozzle", Boolean(nozzle), valid && nozzle ? `(${nozzle.map((v) => fixed(v, 3)).join(", ")}) m` : "not known");
    put(at("speed"), valid ? `${fixed(1e3 * Math.hypot(...velocity), 0)} mm/s` : "not known");
    put(at("time"), span(control.time));
    this.fact("damping", this.sitting?.damped === true, control.damping ? "is damped" : "is not damped now");
    this.fact("powder", this.sitting?.powder != null, `${fixed(control.powder, 1)} kg`);
    this.fact("chain", Boolean(control.inputs), control.inputs?.torque_off ? "safe torque off" : control.inputs?.chain ? "closed" : "open");
    this.fact("barrier", "barrier" in control, control.barrier ? "somebody is in it" : "clear");
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
    put(at("layer"), `${control.layer} of ${path.layers}`);
    put(at("distance"), `${fixed(control.distance, 2)} of ${fixed(path.length, 2)} m`);
    const share = Math.round(100 * control.share);
    put(at("left"), control.finished ? "done" : control.left === null ? "stands at 0 % speed" : `${span(control.left)} at ${share} %`);
  }
}

const FRESH = "The machine is opened. Its brakes are closed until it is reset and enabled.";
const WAITING = "The print is to be resumed, and waits until the light barrier is clear and the winches stand. Pause withdraws that.";
const WORDS = {
  off: "Brakes are closed and the winches are off.", idle: "The winches are enabled and hold.", ready: "Moving to the path; printing begins there.",
  printing: "Follows the path.", paused: "Waits for an order to resume.", stopped: "Was stopped: resume, or reset to end the print.",
  refilling: "Waits for powder: refill, then press Refilled.", manual: "Moves by hand.", tensioning: "Takes up slack, line by line.",
  homing: "Takes up slack and tests the lengths.", fault: "Reset once the cause is gone.", closed: "The machine is closed; nothing moves.",
};
