// The operator's page: its parts, each of which listens to the connection.
import { Chart } from "./chart.js";
import { Jobs } from "./jobs.js";
import { Jog } from "./jog.js";
import { LineTable } from "./lines.js";
import { Link } from "./link.js";
import { Orders } from "./orders.js";
import { State } from "./state.js";
import { LiveView } from "./view.js";
import { at, clock, make } from "./words.js";

const link = new Link(), orders = new Orders(link);
const parts = { link, orders, state: new State(link), lines: new LineTable(link), jog: new Jog(link, orders), chart: new Chart(link), view: new LiveView(link), jobs: new Jobs(link, orders) };
window.operate = parts; // for those who test

let newest = 0, shown = "";
link.on("state", ({ control }) => {
  if (!control) return;
  const faults = [...(control.faults ?? []), ...(control.notices ?? [])], told = JSON.stringify(faults);
  if (told !== shown) {
    shown = told;
    at("faults").replaceChildren(...(faults.length ? faults : ["No fault is reported."]).map((text) => make("li", { textContent: text, className: faults.length ? "" : "soft" })));
  }
  const events = control.events ?? [], last = events.at(-1)?.[0] ?? 0;
  if (last === newest) return;
  newest = last;
  at("events").replaceChildren(...[...events].reverse().map(([, utc, kind, text]) => make("li", { className: kind }, make("time", { textContent: clock(utc) }), make("span", { textContent: text }))));
});
