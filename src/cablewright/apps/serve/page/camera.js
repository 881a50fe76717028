// A picture of the machine: a stream stays open, a still is requested again and again. A failed one says since when.
import { at, clock, put, t } from "./words.js";

const AGAIN = 5000, EVERY = 1000; // ms

export class Camera {
  constructor(link) {
    link.on("hello", ({ camera }) => { if (camera && !this.address) this.begin(camera); });
  }

  begin(address) {
    this.address = address;
    this.still = /snapshot|\.(jpe?g|png)$/.test(address);
    at("camera-section").hidden = false;
    at("camera").addEventListener("load", () => {
      this.gone = null;
      at("camera").hidden = false;
      put(at("camera-told"), t("camera.note"));
      this.next(() => this.ask(), this.still ? EVERY : Infinity);
    });
    at("camera").addEventListener("error", () => this.failed());
    this.ask();
  }

  next(act, wait) { // replaces the timer that runs
    clearTimeout(this.timer);
    if (wait < Infinity) this.timer = setTimeout(act, wait);
  }

  failed() {
    this.gone ??= Date.now() / 1e3;
    at("camera").hidden = true;
    put(at("camera-told"), t("camera.gone", { time: clock(this.gone) }));
    this.next(() => this.ask(), AGAIN);
  }

  ask() { // an address again, of which nothing is kept; the last still picture does not stay for one that does not come
    at("camera").src = `${this.address}${this.still ? `${this.address.includes("?") ? "&" : "?"}t=${Date.now()}` : ""}`;
    this.next(() => this.failed(), this.still ? AGAIN : Infinity);
  }
}
