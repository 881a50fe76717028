// Orders: who operates, what leads to a print, and what interrupts it. The control's own table says what a state allows.
import { Questions } from "./questions.js";
import { at, make, put } from "./words.js";

const STEPS = [
  ["reset", "Reset", "once the cause of the fault is gone"], ["enable", "Enable", "brakes open, winches hold"],
  ["take up", "Take up slack", "line by line, at a low tension"], ["home", "Home", "tests the lengths"], ["start", "Start", "goes to the path and prints"],
];
const MORE = [["resume", "Resume"], ["refilled", "Refilled"], ["stop", "End print"], ["release", "Release"]];
const CLEAR = "Keep everyone clear of the machine.";
const SURE = {
  start: ["Start the print?", `The platform moves to the start of the path and prints. ${CLEAR}`],
  resume: ["Resume the print?", `The platform moves back to the path and prints. ${CLEAR}`],
  refilled: ["Is the powder refilled?", `The platform then moves back to the path and prints. ${CLEAR}`],
  "take up": ["Take up slack?", "Winches reel in, line by line. Keep hands off the lines."],
  home: ["Home?", "Winches reel in, line by line, and the platform may move slowly."],
  stop: ["End this print?", "The platform slows down along the path. Reset then leads back to idle; the print cannot be resumed after that."],
};

export class Orders {
  constructor(link) {
    this.link = link;
    this.buttons = { pause: at("pause") };
    this.notes = {};
    this.questions = new Questions(link, () => this.situation, (text) => this.say(text));
    at("steps").append(...STEPS.map(([kind, text, note]) => make("li", {}, this.button(kind, text), this.notes[kind] = make("small", { textContent: note }))));
    at("more").append(...MORE.map(([kind, text]) => this.button(kind, text)));
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
    at("open").addEventListener("click", () => link.ask("/close", { method: "POST" }).then(() => this.say(""), (reason) => this.say(`${reason.message}.`)));
    at("name").value = localStorage.getItem("name") ?? "";
    at("name").addEventListener("change", () => {
      localStorage.setItem("name", at("name").value);
      if (this.mine) link.send({ t: "take", name: at("name").value });
    });
    link.on("hello", (hello) => { this.number = hello.number; }).on("sitting", (sitting) => { this.sitting = sitting; });
    link.on("lease", ({ refusal }) => this.say(refusal)).on("jog", ({ refusal }) => this.say(`Jog: ${refusal}.`));
    link.on("state", (message) => this.show(message)).on("lost", () => { this.operator = null; this.questions.look(); this.update(); });
  }

  button(kind, text) {
    const made = make("button", { type: "button", textContent: text, disabled: true, onclick: () => this.asked(kind) });
    this.buttons[kind] = made;
    return made;
  }

  get mine() { return Boolean(this.operator) && this.operator.number === this.number; }

  get situation() { // in which an order is asked for and given
    const { control } = this;
    return this.mine && control ? JSON.stringify([control.sitting, control.state, control.waiting, control.share > 0]) : "";
  }

  async asked(kind) {
    const place = at("place");
    place.value = "";
    const sure = !SURE[kind] || await this.sure(...SURE[kind], "Yes", { place: kind === "home" }), given = place.value.trim();
    if (sure) this.give(kind, kind === "home" && given ? { place: given.split(/[,;\s]+/).map(Number) } : {});
  }

  async shared(share) { // of the planned speed: from 0 % on the platform moves again
    const stands = this.control?.share === 0 && share > 0 && ["ready", "printing"].includes(this.control.state);
    const sure = !stands || await this.sure("Move on?", `The platform moves at ${Math.round(100 * share)} % of the planned speed. ${CLEAR}`, "Yes");
    if (sure) this.give("override", { share: [share] });
    else this.update();
  }

  async give(kind, args) {
    const refusal = await this.link.order(kind, args);
    this.say(refusal ? `Rejected: ${refusal}.` : "");
  }

  say(text) { put(at("answer"), text); }

  sure(...question) { return this.questions.ask(...question); }

  async stop() {
    this.questions.end(false);
    const alarm = at("alarm");
    const through = await this.link.stop();
    alarm.hidden = through;
    put(alarm, through ? "" : "Stop did not get through. Use the emergency stop at the machine.");
    if (!through) setTimeout(() => { alarm.hidden = true; }, 15_000);
  }

  show({ control, operator, watching }) {
    this.operator = operator;
    this.control = control;
    this.questions.look();
    put(at("operator"), (this.mine ? `You operate the machine as ${operator.title}.` : operator ? `${operator.title} operates the machine; you watch.` : "Nobody operates the machine.") + (watching > 1 ? ` ${watching} pages are open.` : ""));
    put(at("take"), this.mine ? "Hand over" : "Operate");
    at("take").disabled = Boolean(operator) && !this.mine;
    this.update();
  }

  update() {
    const { control } = this, state = control?.state, allowed = this.sitting?.orders ?? {}, share = Math.round(100 * (control?.share ?? 1));
    if (document.activeElement !== at("share") && !this.questions.open) { at("share").value = share; put(at("share-told"), `${share} %`); }
    for (const [kind, button] of Object.entries(this.buttons)) {
      const has = kind === "start" ? Boolean(this.sitting?.job) : kind === "take up" ? this.has("tensioning") : kind === "home" ? this.has("homing") : kind !== "refilled" || this.sitting?.powder != null;
      const may = (allowed[kind] ?? []).includes(state) || (kind === "pause" && Boolean(control?.waiting)); // what waits is withdrawn
      button.disabled = !this.mine || !has || !may;
      const row = button.closest("li");
      if (row) {
        row.hidden = !has && kind !== "start";
        row.classList.toggle("next", !button.disabled);
      }
    }
    put(this.notes.start, this.sitting?.job ? STEPS.at(-1)[2] : "load a job first: see Jobs");
    at("open").hidden = state !== "closed" || Boolean(control?.opening) || !this.sitting;
    at("open").disabled = !this.mine;
    at("share").disabled = !this.mine;
    document.body.classList.toggle("mine", this.mine);
  }

  has(procedure) { return this.sitting?.procedures.includes(procedure); }
}
