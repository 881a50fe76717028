// API keys of slicers: made and removed by who operates; a key is shown once.
import { at, clock, make, put, t } from "./words.js";

export class Slicers {
  constructor(link, orders) {
    this.link = link;
    this.orders = orders;
    put(at("slicers-note"), t("slicers.note", { origin: location.origin }));
    at("key-scope").append(...["upload", "operate"].map((scope, k) => make("label", {}, make("input", { type: "radio", name: "scope", value: scope, defaultChecked: k === 0 }), t(`scope.${scope}`)))); // no list: its popup takes Esc from Stop
    at("slicers").addEventListener("submit", (event) => { event.preventDefault(); this.make(); });
    link.on("hello", () => this.list()).on("state", () => this.allow());
  }

  allow() {
    const { mine } = this.orders;
    if (this.mine === mine) return;
    this.mine = mine;
    for (const each of [at("key-make"), ...at("keys").querySelectorAll("button")]) each.disabled = !mine;
    put(at("slicers-why"), mine ? "" : t("upload.operate"));
  }

  async make() {
    const body = JSON.stringify({ name: at("key-name").value, scope: at("slicers").elements.scope.value });
    const made = await this.link.ask("/keys", { method: "POST", body }).catch((reason) => this.orders.say(`${reason.message}.`));
    if (!made) return;
    at("slicers").reset();
    at("key-told").replaceChildren(`${t("slicers.key")} `, make("code", { textContent: made.key }));
    this.list();
  }

  async remove(number) {
    await this.link.ask(`/keys/${number}`, { method: "DELETE" }).catch((reason) => this.orders.say(`${reason.message}.`));
    this.list();
  }

  async list() {
    const keys = await this.link.ask("/keys").catch(() => []);
    at("keys").replaceChildren(...(keys.length ? keys.map((key) => make("li", {}, make("strong", { textContent: key.name }), make("span", { className: "tag", textContent: t(`scope.${key.scope}`) }),
      make("small", { textContent: clock(key.utc) }), make("button", { type: "button", textContent: t("slicers.remove"), onclick: () => this.remove(key.id) }))) : [make("li", { className: "soft", textContent: t("slicers.none") })]));
    this.mine = null;
    this.allow();
  }
}
