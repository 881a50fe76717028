// The history: every run with its check, its measured results, and notes of people.
import { at, fixed, make, t } from "./words.js";

const EVERY = 2000; // ms between lists

export class Runs {
  constructor(link, orders) {
    this.link = link;
    this.orders = orders;
    this.runs = [];
    at("find").addEventListener("input", () => this.show());
    link.on("hello", () => this.list()).on("sitting", (sitting) => { this.sitting = sitting; this.list(); });
    setInterval(() => { if (!document.hidden && link.live) this.list(); }, EVERY);
  }

  async list() {
    const runs = await this.link.ask("/runs").catch(() => null);
    if (!runs) return; // the list of jobs says why
    const text = JSON.stringify([runs, this.sitting?.run, this.orders.mine]);
    if (text === this.told || document.activeElement?.closest("#runs textarea")) return; // texts being written stay
    this.told = text;
    this.runs = runs;
    this.show();
  }

  show() {
    const words = at("find").value.toLowerCase().split(/\s+/).filter(Boolean);
    const found = this.runs.filter((run) => words.every((word) => JSON.stringify(run).toLowerCase().includes(word)));
    at("runs").replaceChildren(...(found.length ? found.map((run) => this.run(run)) : [make("li", { className: "soft", textContent: t(this.runs.length ? "runs.nothing" : "runs.none") })]));
  }

  run(run) {
    const present = this.sitting?.run === run.name, { check, result } = run, error = result.max_error_in_space ?? result.max_path_error;
    const before = check ? t("run.before", { answer: check.answer }) + (typeof check.expected_error === "number" ? `, ${t("job.error", { mm: fixed(1e3 * check.expected_error, 1) })}` : "") : "";
    const after = typeof error === "number" ? t("run.after", { mm: fixed(1e3 * error, 1) }) : t("run.after.none");
    const notes = make("textarea", { rows: 2, maxLength: 2000, value: run.notes, disabled: !this.orders.mine });
    notes.setAttribute("aria-label", t("run.notes.of", { run: run.name }));
    const keep = make("button", { type: "button", textContent: t("run.notes.save"), disabled: !this.orders.mine, title: this.orders.mine ? "" : t("why.operate"), onclick: () => this.keep(run.name, notes.value) });
    return make("li", {}, make("strong", { textContent: run.name }), make("span", { className: `tag ${run.status === "finished" ? "yes" : ""}`, textContent: present ? t("run.now") : run.status }),
      run.reason && run.reason !== run.status ? make("small", { textContent: run.reason }) : null,
      run.has_report ? make("a", { href: `/runs/${run.name}/report`, target: "_blank", rel: "noopener", textContent: t("run.report") }) : run.busy ? make("small", { textContent: t("run.report.busy", { busy: run.busy }) }) : null,
      make("p", { className: "soft", textContent: before ? `${before}; ${after}` : after }),
      make("details", { open: false }, make("summary", { textContent: run.notes ? `${t("run.notes")}: ${run.notes.split("\n")[0].slice(0, 60)}` : t("run.notes") }), notes, keep));
  }

  async keep(run, text) {
    await this.link.ask(`/runs/${run}/notes`, { method: "PUT", body: text }).catch((reason) => this.orders.say(`${reason.message}.`));
    this.told = "";
    document.activeElement?.blur();
    this.list();
  }
}
