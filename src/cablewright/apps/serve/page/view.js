// The 3-D view: the scene of the sitting, and the latest state in it.
import { at, make, t } from "./words.js";

const DRAWN = 40; // ms between pictures

export class LiveView {
  constructor(link) {
    this.link = link;
    this.last = 0;
    link.on("sitting", (sitting) => this.begin(sitting)).on("state", (message) => this.show(message));
  }

  async begin(sitting) {
    if (!sitting.scene || sitting.sitting === this.sitting) return;
    this.sitting = sitting.sitting;
    const answer = await fetch("/scene").catch(() => null);
    if (!answer?.ok || this.sitting !== sitting.sitting) { this.sitting = null; return; }
    const host = make("div", { className: "viewer" }, make("div", { className: "stage" }));
    at("view").replaceChildren(host);
    await window.cablewright.mount(host, await answer.json());
    if (host.dataset.reason) host.append(make("p", { className: "soft", textContent: t("view.none") }));
    this.view = host.view;
    if (this.view) this.view.live = true;
  }

  show({ control, curves }) {
    const { view } = this, now = performance.now();
    if (!view?.lines || !control?.platform || control.sitting !== this.sitting || now - this.last < DRAWN || document.hidden) return;
    this.last = now;
    const { position, rotation, valid } = control.platform;
    if (!valid) return;
    view.poses.values.set(view.poses.shape[1] > 3 ? [...position, ...rotation] : position);
    if (curves && curves.length === view.lines.curves.values.length) view.lines.curves.values.set(curves);
    const tensions = control.measured ?? control.lines.tensions;
    if (tensions) view.lines.tensions.values.set(tensions.map((each) => each ?? NaN));
    if (view.path) { view.path.now = control.piece; view.gone = false; }
    view.show(0);
    this.drawn = (this.drawn ?? 0) + 1;
  }
}
