// Orders: who operates, what leads to a print, and what interrupts it. What a state allows is told by the control's own table.
import { at, make, put } from "./words.js";

const STEPS = [
  ["reset", "Reset", "once the cause of the fault is gone"], ["enable", "Enable", "brakes open, winches hold"],
  ["take up", "Take up slack", "line by line, at a low tension"], ["home", "Home", "tests the lengths"], ["start", "Start", "goes to the path and prints"],
];
const MORE = [["pause", "Pause"], ["resume", "Resume"], ["refilled", "Refilled"], ["stop", "End print"], ["release", "Release"]];
const SURE = {
  start: ["Start the print?", "The platform moves at once. Nobody may be near the machine."],
  "take up": ["Take up slack?", "Winches reel in, line by line. Keep hands off the lines."],
  home: ["Home?", "Winches reel in, line by line, and the platform may move slowly."],
  stop: ["End this print?", "The platform slows down along the path. Reset then leads back to idle; the print does not go on."],
};

export class Orders {
  constructor(link) {
    this.link = link;
    this.buttons = {};
    at("steps").append(...STEPS.map(([kind, text, note]) => make("li", {}, this.button(kind, text), make("small", { textContent: note }))));
    at("more").append(...MORE.map(([kind, text]) => this.button(kind, text)));
    at("stop").addEventListener("click", () => this.stop());
    at("take").addEventListener("click", () => link.send({ t: this.mine ? "release" : "take", name: at("name").value }));
    at("share").addEventListener("input", () => put(at("share-told"), `${at("share").value} %`));
    at("share").addEventListener("change", () => this.give("override", { share: [Number(at("share").value) / 100] }));
    at("open").addEventListener("click", () => link.ask("/close", { method: "POST" }).then(() => this.say(""), (reason) => this.say(`${reason.message}.`)));
    at("name").value = localStorage.getItem("name") ?? "";
    at("name").addEventListener("change", () => localStorage.setItem("name", at("name").value));
    link.on("hello", (hello) => { this.number = hello.number; }).on("sitting", (sitting) => { this.sitting = sitting; });
    link.on("lease", ({ refusal }) => this.say(refusal)).on("jog", ({ refusal }) => this.say(`Jog: ${refusal}.`));
    link.on("state", (message) => this.show(message)).on("lost", () => { this.operator = null; this.update(); });
  }

  button(kind, text) {
    const made = make("button", { type: "button", textContent: text, disabled: true, onclick: () => this.asked(kind) });
    this.buttons[kind] = made;
    return made;
  }

  get mine() { return Boolean(this.operator) && this.operator.number === this.number; }

  async asked(kind) {
    at("ask-place").hidden = kind !== "home";
    const sure = !SURE[kind] || await this.sure(...SURE[kind], "Yes"), place = at("place").value.trim();
    at("ask-place").hidden = true;
    if (sure) this.give(kind, kind === "home" && place ? { place: place.split(/[,;\s]+/).map(Number) } : {});
  }

  async give(kind, args) {
    const refusal = await this.link.order(kind, args);
    this.say(refusal ? `Refused: ${refusal}.` : "");
  }

  say(text) { put(at("answer"), text); }

  async stop() {
    const alarm = at("alarm");
    const through = await this.link.stop();
    alarm.hidden = through;
    put(alarm, through ? "" : "Stop did not get through. Use the emergency stop at the machine.");
    if (!through) setTimeout(() => { alarm.hidden = true; }, 15_000);
  }

  sure(title, text, yes) {
    const dialog = at("ask");
    put(at("ask-title"), title); put(at("ask-text"), text); put(at("ask-yes"), yes);
    dialog.showModal();
    return new Promise((done) => {
      const close = (answer) => { dialog.close(); done(answer); };
      at("ask-yes").onclick = () => close(true);
      at("ask-no").onclick = () => close(false);
      dialog.oncancel = () => done(false);
    });
  }

  show({ control, operator, watching }) {
    this.operator = operator;
    this.control = control;
    put(at("operator"), (this.mine ? "You operate the machine." : operator ? `${operator.title} operates the machine; you watch.` : "Nobody operates the machine.") + (watching > 1 ? ` ${watching} pages are open.` : ""));
    put(at("take"), this.mine ? "Hand over" : "Operate");
    at("take").disabled = Boolean(operator) && !this.mine;
    const share = Math.round(100 * (control?.share ?? 1));
    if (document.activeElement !== at("share")) { at("share").value = share; put(at("share-told"), `${share} %`); }
    this.update();
  }

  update() {
    const state = this.control?.state, allowed = this.sitting?.orders ?? {};
    for (const [kind, button] of Object.entries(this.buttons)) {
      const has = kind === "start" ? Boolean(this.sitting?.job) : kind === "take up" ? this.has("tensioning") : kind === "home" ? this.has("homing") : kind !== "refilled" || this.sitting?.powder != null;
      button.disabled = !this.mine || !has || !(allowed[kind] ?? []).includes(state);
      const row = button.closest("li");
      if (row) {
        row.hidden = !has && kind !== "start";
        row.classList.toggle("next", !button.disabled);
      }
    }
    at("open").hidden = state !== "closed" || !this.sitting;
    at("open").disabled = !this.mine;
    at("share").disabled = !this.mine;
    document.body.classList.toggle("mine", this.mine);
  }

  has(procedure) { return this.sitting?.procedures.includes(procedure); }
}
