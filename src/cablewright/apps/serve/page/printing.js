// One confirmation, and what follows from it: the job is loaded, the machine is reset and enabled, and the print starts.
// Whatever comes between ends it: Stop, another operator, a lost connection, a state that was not expected, or time.
import { fixed, t, worded } from "./words.js";

const LOAD = 120e3, STEP = 20e3; // ms for a load and for each order
const SILENCE = 5e3; // ms without a word of the server: a machine that is being opened is silent for less
const AGAIN = 400; // ms until a rejected order is sent again

export class Printing {
  constructor(link, orders) {
    this.link = link;
    this.orders = orders;
    this.told = "";
    link.on("sitting", (sitting) => { this.sitting = sitting; this.look(); }).on("state", ({ stops }) => { this.stops = stops; this.look(); }).on("lost", () => this.end(t("print.lost")));
  }

  async ask(job) {
    const { expected_error: error } = job.check, text = { error: error === null ? "" : `, ${t("job.error", { mm: fixed(1e3 * error, 1) })}`, clear: t("clear") };
    if (this.told || !await this.orders.sure(t("sure.print", { name: job.name }), t("sure.print.text", text), t("sure.print.yes"))) return;
    this.job = job.id;
    this.pressed = this.orders.stops;
    this.stopped = this.stops; // by whoever
    try {
      if (this.sitting?.job?.id !== job.id) {
        this.step(t("print.load"), LOAD);
        await this.link.ask(`/jobs/${job.id}/load`, { method: "POST", body: JSON.stringify({ confirmed: "" }) });
      }
      await this.until((control, sitting) => sitting.job?.id === job.id && sitting.sitting === control.sitting && ["fault", "off", "idle"].includes(control.state));
      await this.order("reset", "fault", "off", t("print.reset"));
      await this.order("enable", "off", "idle", t("print.enable"));
      await this.until((control) => control.known).catch((reason) => { throw this.sitting?.procedures.includes("homing") ? new Error(t("print.home")) : reason; });
      await this.order("start", "idle", "ready", t("print.start"));
      this.told = "";
    } catch (reason) {
      this.orders.say(t("print.ended", { why: reason.message }));
      this.told = "";
    }
    this.orders.update();
  }

  async order(kind, from, to, told) {
    this.step(told, STEP);
    await this.until((control) => control.state !== from || control.fresh || this.orders.may(kind));
    const { state, fresh } = this.orders.control;
    if (state !== from) return;
    if (state === "fault" && !fresh) throw new Error(t("print.state", { state: worded("state", state) })); // a person looks at its cause
    let refusal = ""; // such as of a machine that was just opened, or of an order that came late
    do {
      if (refusal) await new Promise((done) => { setTimeout(done, AGAIN); });
      if (refusal && performance.now() > this.late) throw new Error(refusal);
      this.check();
      refusal = await this.link.order(kind);
    } while (refusal && this.orders.control.state === from); // one that was obeyed may be answered late
    await this.until((control) => control.state === to || (to === "ready" && control.state === "printing"), [from]);
  }

  step(told, patience) { this.told = told; this.late = performance.now() + patience; this.why = ""; }

  until(condition, states = null) { // of the control and the sitting
    this.check();
    return new Promise((done, failed) => { this.waiting = { condition, states, done, failed }; this.look(); });
  }

  reason() {
    const { orders, link } = this;
    return this.why || (orders.stops !== this.pressed || this.stops !== this.stopped ? t("print.stop") : !orders.mine ? t("print.lease") : performance.now() - link.seen > SILENCE ? t("print.lost") : performance.now() > this.late ? t("print.late") : "");
  }

  check() { const why = this.reason(); if (why) throw new Error(why); }

  look() {
    const { waiting } = this, { control } = this.orders;
    if (!waiting || !control) return;
    const why = this.reason();
    if (!why && (this.link.stale || !this.sitting)) return; // an old state answers nothing
    const met = !why && waiting.condition(control, this.sitting);
    const other = !why && !met && waiting.states && !waiting.states.includes(control.state) ? t("print.state", { state: worded("state", control.state) }) : "";
    if (!why && !met && !other) return;
    this.waiting = null;
    if (met) waiting.done(); else waiting.failed(new Error(why || other));
  }

  end(why) { if (this.told) { this.why = why; this.look(); } }
}
