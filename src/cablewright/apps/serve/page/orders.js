// Orders: who operates, what leads to a print, and what interrupts it. The control's own table says what a state allows.
import { Questions } from "./questions.js";
import { at, has, make, put, t, worded } from "./words.js";

const STEPS = ["reset", "enable", "take up", "home", "start"];
const MORE = ["resume", "refilled", "stop", "release"];

export class Orders {
  constructor(link) {
    this.link = link;
    this.buttons = { pause: at("pause") };
    this.notes = {};
    this.stops = 0; // how often Stop was pressed here
    this.questions = new Questions(link, () => this.situation, (text) => this.say(text));
    for (const [list, kinds] of [["steps", STEPS], ["more", MORE]])
      at(list).append(...kinds.map((kind) => make("li", {}, this.button(kind), this.notes[kind] = make("small", { textContent: t(`note.${kind}`) }))));
    at("pause").addEventListener("click", () => this.asked("pause"));
    for (const kind of ["pointerdown", "click"]) at("stop").addEventListener(kind, () => this.stop()); // a finger that slips stops, too
    window.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      event.preventDefault();
      if (!event.repeat) this.stop();
    }, true); // before whatever has the focus
    at("take").addEventListener("click", () => link.send({ t: this.mine ? "release" : "take", name: at("name").value }));
    at("share").addEventListener("input", () => put(at("share-told"), `${at("share").value} %`));
    at("share").addEventListener("change", () => this.shared(Number(at("share").value) / 100));
    at("name").value = localStorage.getItem("name") ?? "";
    at("name").addEventListener("change", () => {
      localStorage.setItem("name", at("name").value);
      if (this.mine) link.send({ t: "take", name: at("name").value });
    });
    link.on("hello", (hello) => { this.number = hello.number; }).on("sitting", (sitting) => { this.sitting = sitting; });
    link.on("lease", ({ refusal }) => this.say(refusal)).on("jog", ({ refusal }) => this.say(t("jog.rejected", { why: refusal })));
    link.on("state", (message) => this.show(message)).on("lost", () => { this.operator = null; this.questions.look(); this.update(); });
  }

  button(kind) {
    const made = make("button", { type: "button", textContent: t(`order.${kind}`), disabled: true, onclick: () => this.asked(kind) });
    this.buttons[kind] = made;
    return made;
  }

  get mine() { return Boolean(this.operator) && this.operator.number === this.number; }

  get situation() { // in which an order is confirmed and sent
    const { control } = this;
    return this.mine && control ? JSON.stringify([control.sitting, control.state, control.waiting, control.share > 0]) : "";
  }

  async asked(kind, measured = "") { // whether it was given; why not is said. `measured`: where the platform is, to home
    const place = at("place"), key = `sure.${kind}`;
    place.value = measured;
    const text = has(key) ? t(kind === "start" && this.sitting?.resumed ? "sure.start.resumed" : `${key}.text`, { clear: t("clear") }) : "";
    const sure = !has(key) || await this.sure(t(key), text, t("yes"), { place: kind === "home" }), given = place.value.trim();
    return sure ? this.give(kind, kind === "home" && given ? { place: given.split(/[,;\s]+/).map(Number) } : {}) : t("console.asked");
  }

  async shared(share) { // of the planned speed: from 0 % on the platform moves again
    const stands = this.control?.share === 0 && share > 0 && ["ready", "printing"].includes(this.control.state);
    const sure = !stands || await this.sure(t("sure.move"), t("sure.move.text", { share: Math.round(100 * share), clear: t("clear") }), t("yes"));
    if (sure) return this.give("override", { share: [share] });
    this.update();
    return t("console.asked");
  }

  async give(kind, args) {
    const refusal = await this.link.order(kind, args);
    this.say(refusal ? t("rejected", { why: refusal }) : "");
    return refusal;
  }

  openMachine() { this.link.ask("/close", { method: "POST" }).then(() => this.say(""), (reason) => this.say(`${reason.message}.`)); }

  say(text) { put(at("answer"), text); }

  sure(...question) { return this.questions.ask(...question); }

  async stop() {
    this.stops += 1;
    this.questions.end(null);
    const alarm = at("alarm");
    const through = await this.link.stop();
    alarm.hidden = through;
    put(alarm, through ? "" : t("stop.failed"));
    if (!through) setTimeout(() => { alarm.hidden = true; }, 15_000);
  }

  show({ control, operator, watching }) {
    this.operator = operator;
    this.control = control;
    this.questions.look();
    const who = operator?.title;
    put(at("operator"), t(this.mine ? "operator.me" : operator ? "operator.other" : "operator.none", { who }) + (watching > 1 ? t("operator.pages", { n: watching }) : ""));
    put(at("take"), t(this.mine ? "order.leave" : "order.take"));
    at("take").disabled = Boolean(operator) && !this.mine;
    this.update();
  }

  has(kind) { // whether this machine and sitting have the order at all
    if (kind === "start") return Boolean(this.sitting?.job);
    if (kind === "take up") return this.sitting?.procedures.includes("tensioning");
    if (kind === "home") return this.sitting?.procedures.includes("homing");
    return kind !== "refilled" || this.sitting?.powder != null;
  }

  may(kind) { // whether the state gives it an effect
    const { control } = this;
    return (this.sitting?.orders[kind] ?? []).includes(control?.state) || (kind === "pause" && Boolean(control?.waiting)); // what waits is withdrawn
  }

  why(kind) { // why it cannot be given now; empty: it can
    if (kind === "start" && !this.sitting?.job) return t("why.nojob");
    if (!this.mine) return this.operator ? t("why.other", { who: this.operator.title }) : t("why.operate");
    return this.may(kind) ? "" : t("why.state", { states: (this.sitting?.orders[kind] ?? []).map((state) => worded("state", state)).join(", ") });
  }

  update() {
    const { control } = this, share = Math.round(100 * (control?.share ?? 1));
    if (document.activeElement !== at("share") && !this.questions.open) { at("share").value = share; put(at("share-told"), `${share} %`); }
    for (const [kind, button] of Object.entries(this.buttons)) {
      const there = this.has(kind), why = this.why(kind);
      button.disabled = !there || Boolean(why);
      button.title = why;
      if (this.notes[kind]) put(this.notes[kind], why || t(`note.${kind}`));
      const row = button.closest("li");
      if (row) row.hidden = !there && kind !== "start";
    }
    at("share").disabled = !this.mine;
    document.body.classList.toggle("mine", this.mine);
  }

  mark(kind) { // the one that comes next
    for (const [each, button] of Object.entries(this.buttons)) (button.closest("li") ?? button).classList.toggle("next", each === kind);
  }
}
