// The lines: tension within limits, slack, length out, winch and drive; made once, changed in place.
import { at, fixed, force, length, make, put } from "./words.js";

export class LineTable {
  constructor(link) { link.on("sitting", (sitting) => this.begin(sitting)).on("state", ({ control }) => control?.lines && this.show(control)); }

  begin(sitting) {
    this.sitting = sitting;
    this.rows = sitting.lines.map((name) => {
      const cells = ["tension", "within its limits", "slack", "length", "winch", "drive"].map((what) => make("td", { "data-name": what, className: what === "winch" ? "turns" : "" }));
      const mark = make("span", { className: "mark" }), gauge = make("div", { className: "gauge" }, mark), word = make("small");
      cells[1].append(gauge, word);
      return { row: make("tr", {}, make("th", { scope: "row", textContent: name }), ...cells), cells, mark, gauge, word };
    });
    at("lines").replaceChildren(...this.rows.map(({ row }) => row));
  }

  show(control) {
    if (control.sitting !== this.sitting?.sitting) return;
    const { lines, measured, modes, speeds, drives } = control, { limits, stops_at, cable, winches, hosts } = this.sitting;
    at("drive-head").hidden = !drives;
    put(at("tension-note"), measured ? "Tensions are measured." : "Tensions are those of the model at the estimated lengths: nothing measures them here.");
    this.rows.forEach(({ cells, mark, gauge, word }, i) => {
      const winch = winches[i], own = hosts[winch] === i; // -1: a counterweight
      const tension = measured?.[i] ?? lines.tensions?.[i], [low, high] = limits[i], top = Math.max(stops_at[i], high) * 1.05;
      put(cells[0], force(tension));
      const out = tension > high ? "above its limit" : tension < low ? "below its limit" : "";
      mark.hidden = typeof tension !== "number";
      mark.style.left = `${Math.max(0, Math.min(100, 100 * tension / top))}%`;
      gauge.style.setProperty("--low", `${100 * low / top}%`);
      gauge.style.setProperty("--high", `${100 * high / top}%`);
      gauge.style.setProperty("--stop", `${100 * stops_at[i] / top}%`);
      put(word, out || `${force(low)} to ${force(high)}`);
      cells[1].classList.toggle("out", Boolean(out));
      put(cells[2], lines.slack[i] ? `slack by ${length(lines.excess[i])}` : lines.excess[i] === null ? "not known" : "taut");
      cells[2].classList.toggle("out", lines.slack[i]);
      put(cells[3], winch < 0 ? `${fixed(lines.lengths[i], 3)}\u00a0m` : `${fixed(lines.lengths[i], 3)} of\u00a0${fixed(cable, 0)}\u00a0m`);
      if (winch < 0) put(cells[4], "counterweight");
      else if (!own) put(cells[4], `winch of ${this.sitting.lines[hosts[winch]]}`);
      else put(cells[4], modes[winch] === "off" ? "brake" : `${speeds[winch] ? fixed(speeds[winch], 2) + "\u00a0rad/s" : "holds"}`);
      cells[5].hidden = !drives;
      if (drives && own && winch >= 0) put(cells[5], drives.faults[winch] || drives.states[winch]);
    });
  }
}
