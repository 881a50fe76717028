// The history: every run with its check, its measured results, and notes of people.
import { at, fixed, make, put, t, worded } from "./words.js";

const EVERY = 2000; // ms between lists

export class Runs {
  constructor(link, orders) {
    this.link = link;
    this.orders = orders;
    this.runs = [];
    at("find").addEventListener("input", () => this.show());
    link.on("hello", () => this.list()).on("sitting", (sitting) => {
      if (sitting.rejected && this.cut) this.leave(this.cut.name); // why stands at its job
      this.sitting = sitting;
      this.list();
    });
    setInterval(() => { if (!document.hidden && link.live) this.list(); }, EVERY);
  }

  async list() {
    const runs = await this.link.ask("/runs").catch(() => null);
    if (!runs) return; // the list of jobs says why
    const text = JSON.stringify([runs, this.sitting?.run, this.sitting?.job?.id, this.orders.mine]);
    if (text === this.told || document.activeElement?.closest("#runs textarea")) return; // texts being written stay
    this.told = text;
    this.runs = runs;
    this.show();
    this.wear();
  }

  show() {
    const words = at("find").value.toLowerCase().split(/\s+/).filter(Boolean);
    const found = this.runs.filter((run) => words.every((word) => JSON.stringify(run).toLowerCase().includes(word)));
    at("runs").replaceChildren(...(found.length ? found.map((run) => this.run(run)) : [make("li", { className: "soft", textContent: t(this.runs.length ? "runs.nothing" : "runs.none") })]));
  }

  wear() { // of each line, over all runs that are listed
    const sums = {};
    for (const { wear } of this.runs) for (const { name, wound, hours } of wear) {
      const sum = sums[name] ??= { wound: 0, hours: 0 };
      sum.wound += wound ?? 0;
      sum.hours += hours ?? 0;
    }
    const lines = Object.entries(sums).map(([name, { wound, hours }]) => t("runs.line", { name, m: fixed(wound, 0), h: fixed(hours, 1) }));
    put(at("wear"), lines.length ? t("runs.wear", { lines: lines.join("; ") }) : "");
  }

  get cut() { // the newest run, where it was cut off and no person has left it
    const [newest] = this.runs;
    return newest?.cut_off && newest.can_resume && !this.sitting?.job && newest.name !== localStorage.getItem("aside") ? newest : null;
  }

  leave(run) { localStorage.setItem("aside", run); } // it stays in the history

  async resume(run) {
    const { orders } = this, asked = await orders.sure(t("sure.again", { run: run.name }), t("sure.again.text", { clear: t("clear") }), t("sure.again.yes"));
    if (asked === false) this.leave(run.name);
    else if (asked) await this.link.ask(`/runs/${run.name}/resume`, { method: "POST" }).catch((reason) => orders.say(t("rejected", { why: reason.message })));
  }

  run(run) {
    const present = this.sitting?.run === run.name, { check, result } = run, error = result.max_error_in_space ?? result.max_path_error;
    const before = check ? t("run.before", { answer: check.answer }) + (typeof check.expected_error === "number" ? `, ${t("job.error", { mm: fixed(1e3 * check.expected_error, 1) })}` : "") : "";
    const after = typeof error === "number" ? t("run.after", { mm: fixed(1e3 * error, 1) }) : t("run.after.none");
    const used = typeof run.laid === "number" ? t("run.laid", { m: fixed(run.laid, 1) }) + (typeof check?.section === "number" ? t("run.material", { l: fixed(1e3 * run.laid * check.section, 2) }) : "") : "";
    const wear = run.wear.map(({ name, wound }) => t("run.wound", { name, m: fixed(wound, 0) })).join(", ");
    const notes = make("textarea", { rows: 2, maxLength: 2000, value: run.notes, disabled: !this.orders.mine });
    notes.setAttribute("aria-label", t("run.notes.of", { run: run.name }));
    const keep = make("button", { type: "button", textContent: t("run.notes.save"), disabled: !this.orders.mine, title: this.orders.mine ? "" : t("why.operate"), onclick: () => this.keep(run.name, notes.value) });
    return make("li", {}, make("strong", { textContent: run.name }), make("span", { className: `tag ${run.status === "finished" ? "yes" : ""}`, textContent: present ? t("run.now") : worded("status", worded("state", run.status)) }),
      run.reason && run.reason !== run.status ? make("small", { textContent: worded("reason", run.reason) }) : null,
      run.has_report ? make("a", { href: `/runs/${run.name}/report`, target: "_blank", rel: "noopener", textContent: t("run.report") }) : run.busy ? make("small", { textContent: t("run.report.busy", { busy: worded("busy", run.busy) }) }) : null,
      run.can_resume && !this.sitting?.job ? make("button", { type: "button", textContent: t("run.resume"), disabled: !this.orders.mine, title: this.orders.mine ? "" : t("why.operate"), onclick: () => this.resume(run) }) : null,
      make("p", { className: "soft", textContent: [before, after, used].filter(Boolean).join("; ") }),
      wear ? make("p", { className: "soft", textContent: t("run.wear", { wear }) }) : null,
      make("details", { open: false }, make("summary", { textContent: run.notes ? `${t("run.notes")}: ${run.notes.split("\n")[0].slice(0, 60)}` : t("run.notes") }), notes, keep));
  }

  async keep(run, text) {
    await this.link.ask(`/runs/${run}/notes`, { method: "PUT", body: text }).catch((reason) => this.orders.say(`${reason.message}.`));
    this.told = "";
    document.activeElement?.blur();
    this.list();
  }
}
