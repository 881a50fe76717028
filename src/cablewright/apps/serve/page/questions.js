// Questions before an order: one at a time, below the bar with Stop, Pause and the state, which it never covers.
// A question ends with the situation in which it was asked; its answer counts in that situation alone.
import { at, put, t } from "./words.js";

export class Questions {
  constructor(link, situation, say) {
    this.link = link;
    this.situation = situation; // a text that changes with the state and the lease; empty: nothing can be ordered
    this.say = say;
    at("ask-yes").addEventListener("click", ({ detail }) => { if (detail < 2) this.answer(true); }); // not by a double click on the button that asked
    at("ask-no").addEventListener("click", () => this.answer(false));
  }

  ask(title, text, yes, { place = false } = {}) { // true for yes, false for no, null where the question was withdrawn
    this.end(null);
    const asked = this.situation(), opener = document.activeElement;
    if (!asked) return Promise.resolve(null);
    put(at("ask-title"), title); put(at("ask-text"), text); put(at("ask-yes"), yes);
    at("ask-place").hidden = !place;
    at("ask").show();
    at("ask-no").focus();
    return new Promise((done) => { this.open = { asked, opener, done }; });
  }

  answer(yes) {
    if (yes && this.link.stale) this.withdraw(t("withdrawn.old"));
    this.look();
    this.end(yes);
  }

  look() {
    if (this.open && this.open.asked !== this.situation()) this.withdraw(t("withdrawn.changed"));
  }

  withdraw(why) {
    this.end(null);
    this.say(t("withdrawn", { why }));
  }

  end(yes) {
    const { open } = this;
    if (!open) return;
    this.open = null;
    const inside = at("ask").contains(document.activeElement);
    at("ask").close();
    if (inside) open.opener?.focus();
    open.done(yes);
  }
}
