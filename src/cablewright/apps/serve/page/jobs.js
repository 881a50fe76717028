// Jobs that were sent, their checks, and the runs.
import { at, clock, make, put } from "./words.js";

const EVERY = 2000; // ms between lists

export class Jobs {
  constructor(link, orders) {
    this.link = link;
    this.orders = orders;
    at("upload").addEventListener("submit", (event) => { event.preventDefault(); this.send(); });
    link.on("hello", () => this.list()).on("sitting", (sitting) => { this.sitting = sitting; this.told = ""; this.list(); });
    setInterval(() => { if (!document.hidden && link.live) this.list(); }, EVERY);
  }

  say(text) { put(at("upload-told"), text); }

  async tried(work) {
    try { await work(); } catch (reason) { this.say(reason.message); this.orders.say(`Refused: ${reason.message}.`); }
    this.list();
  }

  send() {
    const files = [...at("files").files];
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
      if (!await this.orders.sure(`The check of ${job.name} said no`, `${check.why} Load it all the same?`, "I have read it: load")) return;
      confirmed = check.subject;
    }
    await this.tried(() => this.link.ask(`/jobs/${job.id}/load`, { method: "POST", body: JSON.stringify({ confirmed }) }));
  }

  async list() {
    const [jobs, runs] = await Promise.all(["/jobs", "/runs"].map((path) => fetch(path).then((answer) => answer.ok ? answer.json() : null).catch(() => null)));
    if (!jobs || !runs) return;
    const text = JSON.stringify([jobs, runs, this.sitting?.job?.id, this.orders.mine, this.orders.control?.state]);
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
      make("small", { textContent: clock(job.utc) }), check && check.answer !== "yes" ? make("p", { textContent: check.why }) : null, row);
  }

  run(run) {
    const present = this.sitting?.run === run.name;
    return make("li", {}, make("strong", { textContent: run.name }), make("span", { className: `tag ${run.status === "finished" ? "yes" : ""}`, textContent: present ? "runs now" : run.status }),
      run.reason && run.reason !== run.status ? make("small", { textContent: run.reason }) : null,
      run.has_report ? make("a", { href: `/runs/${run.name}/report`, target: "_blank", rel: "noopener", textContent: "report" }) : run.busy ? make("small", { textContent: `report ${run.busy}` }) : null);
  }
}
