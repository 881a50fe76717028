// Orders as text, under the same lease and with the same questions as the buttons.
import { at, make, put, t } from "./words.js";

const KINDS = ["enable", "take up", "home", "start", "pause", "resume", "refilled", "stop", "release", "reset", "park", "override", "go to", "emergency stop"];
const NUMBERS = { "go to": [2, 3], home: [0, 3, 6], override: [1] }; // how many each takes; the others take none
const KEPT = 50;

export class Console {
  constructor(orders, jog) {
    this.orders = orders;
    this.jog = jog;
    this.given = []; // lines, for the keys up and down
    put(at("console-note"), t("console.note", { kinds: KINDS.join(", ") }));
    at("console").addEventListener("submit", async (event) => {
      event.preventDefault();
      const text = at("line").value.trim();
      at("line").value = "";
      if (!text) return;
      this.given.push(text);
      this.at = this.given.length;
      this.told(text, await this.give(text.toLowerCase()));
    });
    at("line").addEventListener("keydown", (event) => {
      const by = { ArrowUp: -1, ArrowDown: 1 }[event.key];
      if (!by || !this.given.length) return;
      event.preventDefault();
      this.at = Math.max(0, Math.min(this.given.length, this.at + by));
      at("line").value = this.given[this.at] ?? "";
    });
  }

  async give(text) { // answers why not; an empty text: it was obeyed
    const kind = KINDS.find((each) => text === each || text.startsWith(`${each} `));
    const numbers = text.slice(kind?.length).trim().split(/[,;\s]+/).filter(Boolean).map(Number);
    if (text.startsWith("jog")) return t("console.jog");
    if (!kind || numbers.some((each) => !Number.isFinite(each))) return t("console.none");
    if (!(NUMBERS[kind] ?? [0]).includes(numbers.length)) return t("console.numbers", { kind, n: (NUMBERS[kind] ?? [0]).join(" / ") });
    if (kind === "emergency stop") { await this.orders.stop(); return ""; }
    if (!this.orders.mine) return this.orders.why("release");
    if (kind === "go to") return this.jog.go(this.jog.completed(numbers));
    if (kind === "override") return this.orders.shared(numbers[0] / 100);
    return this.orders.asked(kind, numbers.join(", "));
  }

  told(text, refusal) {
    const list = at("console-told");
    list.prepend(make("li", { className: refusal ? "refusal" : "" }, make("strong", { textContent: text }), make("span", { textContent: refusal || t("console.done") })));
    while (list.children.length > KEPT) list.lastChild.remove();
  }
}
