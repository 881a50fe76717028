// Calibration by camera: files and pictures go to the server, which says what they show and which picture to take next.
import { at, fixed, make, put, t, worded } from "./words.js";

const EVERY = 2000, PARTS = ["tags", "camera", "plan"]; // ms between looks; files, of which the last may be missing

export class Calibrate {
  constructor(link, orders) {
    Object.assign(this, { link, orders, found: {} });
    at("calibrate-files").append(...PARTS.map((part) => make("label", {}, `${t(`calibrate.${part}`)} `, make("span", { id: `calibrate-${part}`, className: "tag" }), make("input", { type: "file", accept: ".toml", onchange: ({ target }) => this.send(`/calibration/${part}`, "PUT", target) }))));
    at("calibrate-back").after(" ", ...[["again", () => this.tried("/calibration/guide", { method: "POST" })], ["anew", () => this.anew()]].map(([name, onclick]) => make("button", { id: `calibrate-${name}`, type: "button", textContent: t(`calibrate.${name}`), onclick })));
    at("calibrate-send").addEventListener("change", ({ target }) => this.send("/calibration/pictures", "POST", target));
    at("calibrate-take").addEventListener("click", () => this.tried("/calibration/pictures", { method: "POST" }));
    at("calibrate-back").addEventListener("click", () => this.tried("/calibration/pictures", { method: "DELETE" }));
    at("calibrate-accept").addEventListener("click", ({ detail }) => { if (detail < 2) this.accept(); });
    at("calibrate-adopt").addEventListener("click", () => this.tried("/calibration/adopt", { method: "POST" }));
    at("calibrate-run").addEventListener("toggle", () => this.look());
    link.on("hello", () => this.look()).on("state", ({ control }) => { this.moves = control?.speeds?.some(Boolean); this.allow(); });
    setInterval(() => { if (!document.hidden && link.live) this.look(); }, EVERY);
  }

  async look() {
    if (!at("calibrate-run").open) return;
    const found = await this.link.ask("/calibration").catch(() => null), text = JSON.stringify(found);
    if (!found || text === this.text) return;
    Object.assign(this, { found, text });
    this.show();
    this.allow();
  }

  async send(path, method, field) { // the file of a field
    const [body] = field.files;
    field.value = "";
    if (body) await this.tried(path, { method, body });
  }

  async tried(path, options) {
    const done = await this.link.ask(path, options).catch((reason) => { put(at("calibrate-told"), t("rejected", { why: reason.message })); return null; });
    if (done) put(at("calibrate-told"), done.missing?.length ? t("calibrate.missing", { what: done.missing.map((part) => t(`calibrate.${part}`)).join(", ") }) : done.why ? t("calibrate.later", { why: done.why }) : "");
    await this.look();
    return done;
  }

  async accept() {
    const { answer } = this.found, doubtful = answer.verdict === "doubtful", [why] = answer.reasons;
    const sure = await this.orders.sure(t("calibrate.sure"), doubtful ? t("calibrate.sure.doubtful", { why }) : t("calibrate.sure.good"), t(doubtful ? "calibrate.sure.read" : "yes"));
    if (sure) await this.tried("/calibration/accept", { method: "POST", body: JSON.stringify({ confirmed: answer.subject }) });
  }

  async anew() {
    const sure = await this.orders.sure(t("calibrate.anew.sure"), t("calibrate.anew.text"), t("calibrate.anew"));
    if (sure) await this.tried("/calibration/anew", { method: "POST" });
  }

  allow() {
    const { found, orders } = this, may = orders.mine && !found.busy && !this.moves; // a file picker would cover Stop
    for (const each of document.querySelectorAll("#calibrate-files input, #calibrate-send")) each.disabled = !may;
    at("calibrate-take").hidden = !found.live;
    at("calibrate-take").disabled = !may;
    for (const each of ["back", "anew"]) at(`calibrate-${each}`).disabled = !may || !found.pictures;
    at("calibrate-again").disabled = !may || !["tags", "camera"].every((part) => found.parts?.includes(part));
    at("calibrate-accept").hidden = !["good", "doubtful"].includes(found.answer?.verdict);
    at("calibrate-accept").disabled = !may;
    at("calibrate-adopt").hidden = !found.accepted;
    at("calibrate-adopt").disabled = !may;
    put(at("calibrate-why"), orders.mine ? found.busy ? t("calibrate.busy", { busy: worded("busy", found.busy) }) : this.moves ? t("calibrate.moves") : "" : t("upload.operate"));
  }

  show() {
    const { found } = this, { answer } = found, mm = (value) => fixed(1e3 * value, 1);
    for (const part of PARTS) {
      const there = found.parts.includes(part);
      put(at(`calibrate-${part}`), t(there ? "first.done" : part === "plan" ? "calibrate.may" : "first.open"));
      at(`calibrate-${part}`).classList.toggle("yes", there);
    }
    put(at("calibrate-count"), t("calibrate.count", { n: found.pictures }));
    const words = !answer ? [] : answer.failed ? [answer.failed] : [answer.camera, answer.words, ...answer.reasons];
    if (typeof answer?.sigma === "number") words.unshift(t("calibrate.sigma", { mm: mm(answer.sigma), need: mm(answer.need), verdict: worded("verdict", answer.verdict) }));
    at("calibrate-words").replaceChildren(...words.filter(Boolean).map((text) => make("li", { textContent: text })));
    at("calibrate-next").replaceChildren(...(answer?.next ?? []).map(({ pose, why }) => {
      const place = pose.slice(0, 3).map((v) => v.toFixed(3)).join(", ");
      return make("li", {}, `(${place}) m: ${why} `, make("button", { type: "button", textContent: t("calibrate.goal"), onclick: () => { at("goal").value = place; at("goal").focus(); } }));
    }));
    at("calibrate-shown").replaceChildren(...(answer?.pictures ?? []).map(({ name, tags, left_out }) => make("li", { textContent: t("calibrate.shown", { name, tags: tags.join(", ") || t("calibrate.none"), out: left_out.length ? `; ${left_out.join("; ")}` : "" }) })));
    at("calibrate-sigmas").replaceChildren(...(answer?.exits ?? []).map(({ line, now }) => make("li", { textContent: t("calibrate.exit", { line, mm: mm(now) }) })));
    at("calibrate-room").hidden = !found.room || !answer || Boolean(answer.failed);
    if (found.room && answer?.subject !== this.drawn) at("calibrate-room").src = `/calibration/room?${this.drawn = answer?.subject}`;
    put(at("calibrate-accepted"), found.accepted ? t("calibrate.accepted", { file: found.accepted }) : "");
  }
}
