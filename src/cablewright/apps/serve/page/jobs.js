// Jobs that were sent, by people and by slicers, and their checks.
import { atRest } from "./state.js";
import { at, clock, fixed, make, put, span, t, worded } from "./words.js";

const EVERY = 2000; // ms between lists

export class Jobs {
  constructor(link, orders, printing) {
    this.link = link;
    this.orders = orders;
    this.printing = printing;
    this.jobs = [];
    this.rejected = {}; // why a job was not loaded, by its number: shown at its button
    at("upload").addEventListener("submit", (event) => { event.preventDefault(); this.send([...at("files").files]); });
    for (const kind of ["dragover", "drop"]) window.addEventListener(kind, (event) => event.preventDefault()); // or the browser leaves for the file
    window.addEventListener("drop", ({ dataTransfer }) => { if (dataTransfer.files.length) this.send([...dataTransfer.files]); });
    link.on("hello", () => this.list()).on("sitting", (sitting) => this.begin(sitting)).on("state", ({ control }) => this.allow(control));
    setInterval(() => { if (!document.hidden && link.live) this.list(); }, EVERY);
  }

  get candidate() { // the newest job, where it can be printed with one confirmation
    const [newest] = this.jobs;
    return newest && this.printable(newest) ? newest : null;
  }

  printable({ check }) { return check?.answer === "yes" && !this.sitting?.job; }

  begin(sitting) {
    this.sitting = sitting;
    if (sitting.job) delete this.rejected[sitting.job.id];
    if (sitting.rejected) this.reject(sitting.rejected.job, sitting.rejected.why);
    this.told = "";
    this.list();
  }

  allow(control) { // the browser's file picker covers the page, and Stop with it
    const { mine } = this.orders;
    at("files").disabled = !mine || !control || !atRest(control);
    put(at("upload-note"), !mine ? t("upload.operate") : at("files").disabled ? t("upload.moving") : "");
    put(at("jobs-note"), !this.jobs.length ? "" : !mine ? t("jobs.grey") : this.jobs.some((job) => this.printable(job)) && !control?.fresh && !["off", "idle"].includes(control?.state) ? t("jobs.grey.print") : "");
  }

  say(text) { put(at("upload-told"), text); }

  reject(job, why) {
    this.rejected[job] = why;
    this.orders.say(t("rejected", { why }));
  }

  async tried(work, rejected = this.say.bind(this)) {
    try { await work(); } catch (reason) { rejected(reason.message); this.orders.say(t("rejected", { why: reason.message })); }
    this.list();
  }

  send(files) {
    return this.tried(async () => {
      if (!files.length) throw new Error(t("upload.none"));
      if (!this.orders.mine) throw new Error(t("upload.watch"));
      const { id } = await this.link.ask("/jobs", { method: "POST", body: JSON.stringify({ name: files[0].name }) });
      for (const file of files) {
        this.say(t("upload.sends", { name: file.name }));
        await this.link.ask(`/jobs/${id}/${file.name.toLowerCase().endsWith(".toml") ? "settings" : "gcode"}`, { method: "PUT", body: file });
      }
      await this.link.ask(`/jobs/${id}/check`, { method: "POST" });
      this.say(t("upload.sent"));
      at("upload").reset();
    });
  }

  async load(job) {
    const { check } = job;
    let confirmed = "";
    if (check.answer === "no") {
      if (!await this.orders.sure(t("sure.load", { name: job.name }), check.why, t("sure.load.yes"))) return;
      confirmed = check.subject;
    }
    delete this.rejected[job.id];
    await this.tried(() => this.link.ask(`/jobs/${job.id}/load`, { method: "POST", body: JSON.stringify({ confirmed }) }), (why) => this.reject(job.id, why));
  }

  async moved(job) { // the exit points, to those of a stage
    const sure = await this.orders.sure(t("sure.stage", { name: job.name }), t("sure.stage.text"), t("sure.stage.yes"));
    if (sure) await this.tried(() => this.link.ask(`/calibration/stage/${job.id}`, { method: "POST" }), (why) => this.reject(job.id, why));
  }

  async list() {
    const jobs = await this.link.ask("/jobs").catch((reason) => reason.message);
    put(at("list-told"), typeof jobs === "string" ? t("list.failed", { why: jobs }) : "");
    if (typeof jobs === "string") return;
    this.jobs = jobs;
    const text = JSON.stringify([jobs, this.sitting?.job?.id, this.orders.mine, this.orders.control?.state, this.rejected]);
    if (text === this.told) return; // the focus stays
    this.told = text;
    at("jobs").replaceChildren(...(jobs.length ? jobs.map((job) => this.job(job)) : [make("li", { className: "soft", textContent: t("jobs.none") })]));
  }

  job(job) {
    const { check } = job, loaded = this.sitting?.job?.id === job.id, mine = this.orders.mine, row = make("div", { className: "row" });
    const answer = job.busy && !check ? worded("busy", job.busy) : t(!check ? "job.unchecked" : { yes: "job.yes", no: "job.no", failed: "job.unchecked" }[check.answer]);
    const button = (text, act, disabled = false) => row.append(make("button", { type: "button", textContent: text, disabled: disabled || !mine, onclick: act }));
    if (check?.has_report) row.append(make("a", { href: `/jobs/${job.id}/report`, target: "_blank", rel: "noopener", textContent: t("job.report") }));
    const { control } = this.orders, begins = control && (control.fresh || ["off", "idle"].includes(control.state));
    if (this.printable(job)) button(t("job.print"), () => this.printing.ask(job), !begins);
    if (check && check.answer !== "failed" && !loaded) button(t("job.load"), () => this.load(job));
    if (loaded) button(t("job.away"), () => this.tried(() => this.link.ask("/close", { method: "POST" })));
    if (!job.busy && !loaded) {
      if (check?.answer !== "yes" || this.rejected[job.id]) button(t("job.again"), () => this.tried(() => this.link.ask(`/jobs/${job.id}/check`, { method: "POST" })));
      if (job.stage > 1) button(t("job.stage"), () => this.moved(job));
      button(t("job.remove"), () => this.tried(() => this.link.ask(`/jobs/${job.id}`, { method: "DELETE" })));
    }
    const about = [
      check && typeof check.expected_error === "number" ? t("job.error", { mm: fixed(1e3 * check.expected_error, 1) }) : "", check && typeof check.duration === "number" ? t("job.takes", { time: span(check.duration) }) : "",
      job.by ? t("job.by", { by: job.by }) : "", job.wants_print ? t("job.wants") : "",
    ].filter(Boolean).join("; ");
    return make("li", { className: loaded ? "loaded" : "" }, job.has_picture ? make("img", { src: `/jobs/${job.id}/picture`, alt: t("job.picture", { name: job.name }), className: "part" }) : null,
      make("strong", { textContent: job.name }), make("span", { className: `tag ${check?.answer ?? ""}`, textContent: loaded ? t("job.loaded", { answer }) : answer }),
      make("small", { textContent: clock(job.utc) }), about ? make("small", { textContent: about }) : null, check && check.answer !== "yes" ? make("p", { textContent: check.why }) : null, row,
      this.rejected[job.id] ? make("p", { className: "answer", role: "alert", textContent: t("job.rejected", { why: this.rejected[job.id] }) }) : null);
  }
}
