// Jobs that were sent, their checks, and the runs.
import { atRest } from "./state.js";
import { at, clock, make, put } from "./words.js";

const EVERY = 2000; // ms between lists

export class Jobs {
  constructor(link, orders) {
    this.link = link;
    this.orders = orders;
    this.rejected = {}; // why a job was not loaded, by its number: shown at its button
    at("upload").addEventListener("submit", (event) => { event.preventDefault(); this.send([...at("files").files]); });
    for (const kind of ["dragover", "drop"]) window.addEventListener(kind, (event) => event.preventDefault()); // or the browser leaves for the file
    window.addEventListener("drop", ({ dataTransfer }) => { if (dataTransfer.files.length) this.send([...dataTransfer.files]); });
    link.on("hello", () => this.list()).on("sitting", (sitting) => this.begin(sitting)).on("state", ({ control }) => this.allow(control));
    setInterval(() => { if (!document.hidden && link.live) this.list(); }, EVERY);
  }

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
    put(at("upload-note"), !mine ? "Press Operate first." : at("files").disabled ? "While the machine moves, drop files on this page: the browser's file picker would cover Stop." : "");
  }

  say(text) { put(at("upload-told"), text); }

  reject(job, why) {
    this.rejected[job] = why;
    this.orders.say(`Rejected: ${why}.`);
  }

  async tried(work, rejected = this.say.bind(this)) {
    try { await work(); } catch (reason) { rejected(reason.message); this.orders.say(`Rejected: ${reason.message}.`); }
    this.list();
  }

  send(files) {
    return this.tried(async () => {
      if (!files.length) throw new Error("choose a file first");
      if (!this.orders.mine) throw new Error("press Operate first: you only watch");
      const { id } = await this.link.ask("/jobs", { method: "POST", body: JSON.stringify({ name: files[0].name }) });
      for (const file of files) {
        this.say(`sends ${file.name}`);
        await this.link.ask(`/jobs/${id}/${file.name.toLowerCase().endsWith(".toml") ? "settings" : "gcode"}`, { method: "PUT", body: file });
      }
      await this.link.ask(`/jobs/${id}/check`, { method: "POST" });
      this.say("sent; it is being checked");
      at("upload").reset();
    });
  }

  async load(job) {
    const { check } = job;
    let confirmed = "";
    if (check.answer === "no") {
      if (!await this.orders.sure(`The check of ${job.name} said no. Load it all the same?`, check.why, "I have read it: load")) return;
      confirmed = check.subject;
    }
    delete this.rejected[job.id];
    await this.tried(() => this.link.ask(`/jobs/${job.id}/load`, { method: "POST", body: JSON.stringify({ confirmed }) }), (why) => this.reject(job.id, why));
  }

  async list() {
    const found = await Promise.all(["/jobs", "/runs"].map((path) => this.link.ask(path))).catch((reason) => reason.message);
    put(at("list-told"), typeof found === "string" ? `Jobs and runs cannot be listed: ${found}.` : "");
    if (typeof found === "string") return;
    const [jobs, runs] = found;
    const text = JSON.stringify([jobs, runs, this.sitting?.job?.id, this.orders.mine, this.orders.control?.state, this.rejected]);
    if (text === this.told) return; // what is focused stays so
    this.told = text;
    at("jobs").replaceChildren(...(jobs.length ? jobs.map((job) => this.job(job)) : [make("li", { className: "soft", textContent: "No job was sent yet." })]));
    at("runs").replaceChildren(...(runs.length ? runs.map((run) => this.run(run)) : [make("li", { className: "soft", textContent: "Nothing was printed yet." })]));
  }

  job(job) {
    const { check } = job, loaded = this.sitting?.job?.id === job.id, mine = this.orders.mine, row = make("div", { className: "row" });
    const answer = job.busy || (!check ? "not checked" : { yes: "check: yes", no: "check: no", failed: "not checked" }[check.answer]);
    const button = (text, act, disabled = false) => row.append(make("button", { type: "button", textContent: text, disabled: disabled || !mine, onclick: act }));
    if (check?.has_report) row.append(make("a", { href: `/jobs/${job.id}/report`, target: "_blank", rel: "noopener", textContent: "report of the check" }));
    if (check && check.answer !== "failed" && !loaded) button("Load", () => this.load(job));
    if (loaded) button("Put away", () => this.tried(() => this.link.ask("/close", { method: "POST" })));
    if (!job.busy && !loaded) {
      if (check?.answer !== "yes") button("Check again", () => this.tried(() => this.link.ask(`/jobs/${job.id}/check`, { method: "POST" })));
      button("Remove", () => this.tried(() => this.link.ask(`/jobs/${job.id}`, { method: "DELETE" })));
    }
    return make("li", { className: loaded ? "loaded" : "" }, make("strong", { textContent: job.name }), make("span", { className: `tag ${check?.answer ?? ""}`, textContent: loaded ? `loaded; ${answer}` : answer }),
      make("small", { textContent: clock(job.utc) }), check && check.answer !== "yes" ? make("p", { textContent: check.why }) : null, row,
      this.rejected[job.id] ? make("p", { className: "answer", role: "alert", textContent: `Not loaded: ${this.rejected[job.id]}.` }) : null);
  }

  run(run) {
    const present = this.sitting?.run === run.name;
    return make("li", {}, make("strong", { textContent: run.name }), make("span", { className: `tag ${run.status === "finished" ? "yes" : ""}`, textContent: present ? "runs now" : run.status }),
      run.reason && run.reason !== run.status ? make("small", { textContent: run.reason }) : null,
      run.has_report ? make("a", { href: `/runs/${run.name}/report`, target: "_blank", rel: "noopener", textContent: "report" }) : run.busy ? make("small", { textContent: `report ${run.busy}` }) : null);
  }
}
