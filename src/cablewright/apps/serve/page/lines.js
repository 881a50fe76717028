// The lines: tension within limits, slack, length out, winch and drive; made once, changed in place.
import { at, fixed, force, length, make, put, t, worded } from "./words.js";

export class LineTable {
  constructor(link) { link.on("sitting", (sitting) => this.begin(sitting)).on("state", ({ control }) => control?.lines && this.show(control)); }

  begin(sitting) {
    this.sitting = sitting;
    this.rows = sitting.lines.map((name) => {
      const cells = ["tension", "limits", "slack", "length", "winch", "drive"].map((what) => make("td", { "data-name": t(`lines.${what}`), className: what === "winch" ? "turns" : "" }));
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
    put(at("tension-note"), t(measured ? "lines.measured" : "lines.model"));
    this.margin(measured ?? lines.tensions);
    this.rows.forEach(({ cells, mark, gauge, word }, i) => {
      const winch = winches[i], own = hosts[winch] === i; // -1: a counterweight
      const tension = measured?.[i] ?? lines.tensions?.[i], [low, high] = limits[i], top = Math.max(stops_at[i], high) * 1.05;
      put(cells[0], force(tension));
      const out = tension > high ? t("lines.above") : tension < low ? t("lines.below") : "";
      mark.hidden = typeof tension !== "number";
      mark.style.left = `${Math.max(0, Math.min(100, 100 * tension / top))}%`;
      gauge.style.setProperty("--low", `${100 * low / top}%`);
      gauge.style.setProperty("--high", `${100 * high / top}%`);
      gauge.style.setProperty("--stop", `${100 * stops_at[i] / top}%`);
      put(word, out || t("lines.range", { low: force(low), high: force(high) }));
      cells[1].classList.toggle("out", Boolean(out));
      put(cells[2], lines.slack[i] ? t("lines.slackby", { by: length(lines.excess[i]) }) : lines.excess[i] === null ? t("unknown") : t("lines.taut"));
      cells[2].classList.toggle("out", lines.slack[i]);
      put(cells[3], winch < 0 ? `${fixed(lines.lengths[i], 3)}\u00a0m` : t("lines.out", { a: fixed(lines.lengths[i], 3), b: fixed(cable, 0) }));
      if (winch < 0) put(cells[4], t("lines.counterweight"));
      else if (!own) put(cells[4], t("lines.host", { line: this.sitting.lines[hosts[winch]] }));
      else put(cells[4], modes[winch] === "off" ? t("lines.brake") : `${speeds[winch] ? fixed(speeds[winch], 2) + "\u00a0rad/s" : t("lines.holds")}`);
      cells[5].hidden = !drives;
      if (drives && own && winch >= 0) put(cells[5], drives.faults[winch] || worded("drive", drives.states[winch]));
    });
  }

  margin(tensions) { // of the line that is nearest to one of its limits, as a share of its range
    const { limits, lines } = this.sitting;
    const shares = (tensions ?? []).map((tension, i) => typeof tension === "number" ? (tension - limits[i][0]) / (limits[i][1] - limits[i][0]) : null);
    const known = shares.map((share, i) => ({ share, line: lines[i] })).filter(({ share }) => share !== null);
    at("margin-fact").hidden = !known.length;
    if (!known.length) return;
    const { share, line } = known.reduce((worst, each) => Math.min(each.share, 1 - each.share) < Math.min(worst.share, 1 - worst.share) ? each : worst);
    const end = t(share < 0.5 ? "margin.lower" : "margin.upper"), left = Math.min(share, 1 - share), out = left < 0;
    put(at("margin"), out ? t("margin.out", { line, end }) : t("margin.told", { line, share: Math.round(100 * left), end }));
    at("margin").classList.toggle("out", out);
    at("margin-gauge").firstChild.style.left = `${Math.max(0, Math.min(100, 100 * share))}%`;
  }
}
