// The operator's page: its parts, each of which listens to the connection.
import { Calibrate } from "./calibrate.js";
import { Camera } from "./camera.js";
import { Chart } from "./chart.js";
import { Console } from "./console.js";
import { First } from "./first.js";
import { Jobs } from "./jobs.js";
import { Jog } from "./jog.js";
import { LineTable } from "./lines.js";
import { Link } from "./link.js";
import { Next } from "./next.js";
import { Orders } from "./orders.js";
import { Plan } from "./plan.js";
import { Printing } from "./printing.js";
import { Runs } from "./runs.js";
import { Slicers } from "./slicers.js";
import { State } from "./state.js";
import { LiveView } from "./view.js";
import { Winches } from "./winches.js";
import { at, clock, make, setTexts, t } from "./words.js";

setTexts();
const link = new Link(), orders = new Orders(link), printing = new Printing(link, orders), jog = new Jog(link, orders), jobs = new Jobs(link, orders, printing), runs = new Runs(link, orders);
const parts = {
  link, orders, printing, jog, jobs, state: new State(link), lines: new LineTable(link), plan: new Plan(link, jog), chart: new Chart(link), view: new LiveView(link),
  runs, slicers: new Slicers(link, orders), console: new Console(orders, jog), camera: new Camera(link), calibrate: new Calibrate(link, orders), winches: new Winches(link, orders, jog), first: new First(link, orders, jobs, runs, jog), next: new Next(link, orders, jobs, printing, runs),
};
window.operate = parts; // for those who test

let newest = 0, shown = "";
link.on("state", ({ control }) => {
  if (!control) return;
  const faults = [...(control.faults ?? []), ...(control.notices ?? [])], told = JSON.stringify(faults);
  if (told !== shown) {
    shown = told;
    at("faults").replaceChildren(...(faults.length ? faults : [t("faults.none")]).map((text) => make("li", { textContent: text, className: faults.length ? "" : "soft" })));
  }
  const events = control.events ?? [], last = events.at(-1)?.[0] ?? 0;
  if (last === newest) return;
  newest = last;
  at("events").replaceChildren(...[...events].reverse().map(([, utc, kind, text]) => make("li", { className: kind }, make("time", { textContent: clock(utc) }), make("span", { textContent: text }))));
});
