// What to do next, in words, and the one button that does it.
import { at, put, t } from "./words.js";
import { atRest } from "./state.js";

export class Next {
  constructor(link, orders, jobs, printing, runs) {
    this.link = link;
    this.runs = runs;
    this.orders = orders;
    this.jobs = jobs;
    this.printing = printing;
    at("act").addEventListener("click", ({ detail }) => { if (detail < 2) this.act?.(); }); // a double click gives one order, not the next one too
    link.on("sitting", (sitting) => { this.sitting = sitting; });
    link.on("state", () => this.show()).on("lost", () => this.show());
  }

  show() {
    const [told, label, act, kind] = this.choose(), button = at("act");
    put(at("next"), told);
    this.act = act;
    button.hidden = !act;
    if (act) put(button, label);
    this.orders.mark(kind);
  }

  choose() { // text; and of the button: text, action, and order
    const { orders, printing } = this, { control, operator, mine } = orders;
    if (!control || this.link.stale) return [""];
    if (printing.told) return [printing.told, t("act.cancel"), () => printing.end(t("print.cancel"))];
    if (!operator) return [t("next.take"), t("order.take"), () => at("take").click(), "take"];
    if (!mine) return [t("next.watch", { who: operator.title })];
    const order = (kind, told = t(`next.${kind}`)) => [told, t(`order.${kind}`), () => orders.asked(kind), kind];
    const { cut } = this.runs, begins = (control.state === "fault" && control.fresh) || ["off", "idle"].includes(control.state);
    if (cut && begins && atRest(control)) return [t("next.again", { run: cut.name }), t("act.again"), () => this.runs.resume(cut)];
    switch (control.state) {
      case "closed": return control.opening ? [t("next.opening")] : [t("next.open"), t("order.open"), () => orders.openMachine()];
      case "fault": return atRest(control) ? order("reset", t(control.fresh ? "next.reset.fresh" : "next.reset")) : [t("next.slowing")];
      case "off": return order("enable");
      case "idle": return this.idle(control, order);
      case "ready": case "printing": return order("pause");
      case "paused": case "stopped": return atRest(control) ? order("resume") : [t("next.slowing")];
      case "refilling": return atRest(control) ? order("refilled") : [t("next.slowing")];
      default: return [t("next.wait")];
    }
  }

  idle(control, order) {
    if (!atRest(control)) return [t("next.slowing")];
    if (!control.known && this.sitting?.procedures.includes("homing")) return order("home");
    if (this.sitting?.job) return order("start");
    const job = this.jobs.candidate;
    if (job) return [t("next.print", { name: job.name }), t("act.print", { name: job.name }), () => this.printing.ask(job)];
    const [newest] = this.jobs.jobs;
    if (newest) return [t(newest.busy && !newest.check ? "next.checking" : "next.refused", { name: newest.name })];
    return [t("next.send"), t("act.send"), () => { at("files").focus(); at("files").scrollIntoView({ block: "center" }); }];
  }
}
