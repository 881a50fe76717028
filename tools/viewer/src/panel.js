// The panel around the canvas: names, scales of colours, sliders, the object at the pointer, and the state in figures.
import { pick } from "./pick.js";
import { clock, fixed, make, number, quantity } from "./words.js";

const MOST_NAMES = 12;
const PLAY = 20; // s that a whole run takes
const FEW_LAYERS = 3; // of more, what is ahead would hide what is done

export class Panel {
  constructor(host, stage, view) {
    Object.assign(this, { host, stage, view, playing: false });
    this.names();
    this.legends = make("div", { className: "legends" });
    this.tip = make("div", { className: "tip", hidden: true });
    this.tip.setAttribute("role", "tooltip");
    stage.append(this.tip, this.tools());
    this.below = make("div", { className: "below" });
    stage.after(this.legends, this.below);
    this.time();
    this.layers();
    this.choices();
    this.readout = make("div", { className: "readout" });
    this.below.append(this.readout);
    view.hover = (event) => this.hover(event);
    view.canvas.addEventListener("pointerleave", () => { this.tip.hidden = true; });
    view.canvas.addEventListener("keydown", (event) => this.key(event));
    view.listeners.push((what) => this.told(what));
    this.legend();
    this.state();
    this.place();
  }

  told(what) {
    if (what === "drawn") this.place();
    if (what === "frame") this.state();
    if (what === "theme") this.legend();
  }

  names() {
    const { given } = this.view, shown = given.lines.length <= MOST_NAMES;
    const label = (text, at, kind = "") => ({ at, element: make("span", { className: `name ${kind}`, textContent: text }) });
    this.labels = shown ? given.lines.map(({ name, exit }) => label(name, exit)) : [];
    const { low, high } = given.frame, out = 0.03 * this.view.camera.size;
    const middle = [0, 1, 2].map((k) => (low[k] + high[k]) / 2), length = (k) => `${number(high[k] - low[k])} m`;
    this.labels.push(label(`x: ${length(0)}`, [middle[0], low[1] - out, low[2]], "side"),
      label(`y: ${length(1)}`, [high[0] + out, middle[1], low[2]], "side"), label(`z: ${length(2)}`, [low[0] - out, low[1], middle[2]], "side"));
    if (given.worst) this.labels.push(label(given.worst.label, given.worst.place, "worst"));
    this.box = make("div", { className: "names" }, ...this.labels.map(({ element }) => element));
    this.box.setAttribute("aria-hidden", "true");
    this.stage.append(this.box);
  }

  place() { // names where their points are; one that would cover another is left out
    const { width, height } = this.view.camera, taken = [];
    const order = [...this.labels].sort((a, b) => b.element.classList.contains("worst") - a.element.classList.contains("worst"));
    for (const { at, element } of order) {
      const [x, y, depth] = this.view.project(at);
      element.wide ??= element.offsetWidth;
      const w = element.wide / 2 + 2, left = Math.max(w, Math.min(width - w, x)), seen = depth < 1 && x > 0 && x < width && y > 14 && y < height;
      const free = seen && !taken.some(([u, v, s]) => Math.abs(u - left) < s + w && Math.abs(v - y) < 17);
      element.style.visibility = free ? "visible" : "hidden";
      element.style.transform = `translate(${(left - w).toFixed(1)}px, ${(y - 22).toFixed(1)}px)`;
      if (free) taken.push([left, y, w]);
    }
  }

  tools() {
    const { view } = this, go = (act) => () => { view.untouched = false; act(); view.changed(); };
    const button = (text, title, act) => make("button", { type: "button", textContent: text, title, onclick: go(act) });
    return make("div", { className: "tools" },
      button("Fit", "All in view (0)", () => view.camera.home()),
      ...(view.path ? [button("Part", "The path in view", () => this.fitPath())] : []),
      button("Front", "From the front (1)", () => view.camera.look(-90, 0)),
      button("Side", "From the side (2)", () => view.camera.look(0, 0)),
      button("Top", "From above (3)", () => view.camera.look(-90, 89.9)));
  }

  fitPath() {
    const { path, camera } = this.view, [low, high] = camera.whole.map((p) => p.clone());
    low.setScalar(Infinity); high.setScalar(-Infinity);
    for (const id of path.ids[0]) {
      const p = low.clone().set(...path.place(id));
      low.min(p); high.max(p);
    }
    if (path.n) camera.fit(low, high);
  }

  slider(name, most, value, moved) {
    const made = make("input", { type: "range", min: "0", max: String(most), step: "1", value: String(value), oninput: () => moved(Number(made.value)) });
    made.setAttribute("aria-label", name);
    return made;
  }

  poses() { // each value of a slider is one of those that were solved
    const { view } = this, axes = view.given.frames.lattice, places = [];
    const moved = () => view.show(places.reduceRight((sum, { at, axis }) => sum * axis.length + at(), 0));
    axes.forEach((axis, k) => {
      const made = this.slider(`Nozzle, ${"xyz"[k]}`, axis.length - 1, 0, moved), told = make("output", { className: "clock" });
      made.classList.add("pose");
      places.push({ axis, made, told, at: () => Number(made.value) });
      if (axis.length > 1) this.below.append(make("div", { className: "row" }, make("span", { className: "word", textContent: `nozzle ${"xyz"[k]}` }), made, told));
    });
    this.sliders = places;
  }

  posed() {
    let rest = this.view.frame;
    for (const { axis, made, told } of this.sliders) {
      const at = rest % axis.length;
      rest = (rest - at) / axis.length;
      made.value = String(at);
      told.textContent = `${fixed(axis[at], 3)} m`;
      made.setAttribute("aria-valuetext", told.textContent);
    }
  }

  time() {
    const { view } = this;
    if (view.given.frames.lattice) { this.poses(); return; }
    if (view.count < 2) return;
    this.playButton = make("button", { type: "button", className: "play", textContent: "Play", onclick: () => this.play(!this.playing) });
    this.scrub = this.slider("Time", view.count - 1, view.frame, (value) => { this.play(false); view.gone = true; view.show(value); });
    this.scrub.classList.add("scrub");
    this.clock = make("output", { className: "clock" });
    this.below.append(make("div", { className: "row" }, this.playButton, this.scrub, this.clock));
  }

  play(on) {
    this.playing = on;
    if (!this.playButton) return;
    this.playButton.textContent = on ? "Pause" : "Play";
    if (!on) return;
    this.view.gone = true;
    const { view } = this, last = view.count - 1, share = view.frame >= last ? 0 : view.frame / last, begun = performance.now() - share * PLAY * 1e3;
    const step = () => {
      if (!this.playing) return;
      const gone = Math.min(1, (performance.now() - begun) / (PLAY * 1e3)), frame = Math.round(gone * last);
      if (frame !== view.frame) view.show(frame);
      if (gone >= 1) this.play(false); else requestAnimationFrame(step);
    };
    step();
  }

  layers() {
    const { path } = this.view;
    if (!path || path.layers.length < 2) return;
    const last = path.layers.length - 1;
    this.layer = this.slider("Layer", last, last, () => this.layered());
    this.layer.classList.add("layer");
    this.only = make("input", { type: "checkbox", onchange: () => this.layered() });
    this.layerName = make("output", { className: "clock" });
    this.below.append(make("div", { className: "row" }, make("span", { className: "word", textContent: "Layers" }), this.layer, this.layerName,
      make("label", {}, this.only, " only this one")));
    this.layered();
  }

  layered() {
    const { path } = this.view, at = Number(this.layer.value);
    path.only({ low: this.only.checked ? at : 0, high: at });
    this.layerName.textContent = `${this.only.checked ? "" : "to "}${path.layers[at]}`;
    this.view.changed();
  }

  choices() {
    const { view } = this, { groups, path } = view, row = make("div", { className: "row choices" });
    if (path && path.quantities.length) {
      const select = make("select", { onchange: () => { view.colourBy(select.value); this.legend(); } },
        ...path.quantities.map(({ key, label }) => make("option", { value: key, textContent: label })), make("option", { value: "", textContent: "one colour" }));
      select.value = path.quantity.key;
      row.append(make("label", {}, "Path coloured by ", select));
    }
    const tick = (text, on, act) => {
      const box = make("input", { type: "checkbox", checked: on, onchange: () => { act(box.checked); view.changed(); } });
      row.append(make("label", {}, box, ` ${text}`));
    };
    const group = (text, name, on = true) => { groups[name].visible = on; tick(text, on, (value) => { groups[name].visible = value; }); };
    if (path) {
      group("path", "path");
      if (path.kind.includes(2)) tick("travel", !path.kind.includes(1), (travel) => path.only({ travel }));
      path.only({ travel: !path.kind.includes(1) });
      if (view.samples) tick("path ahead", path.layers.length <= FEW_LAYERS, (ahead) => path.only({ ahead }));
      path.only({ ahead: path.layers.length <= FEW_LAYERS });
      if (path.deposit) tick("deposit", false, (on) => { path.deposit.visible = on; });
    }
    group("lines", "lines");
    if (view.given.walls.length) group("walls", "walls");
    if (view.scans) group("lidar points", "scans");
    if (view.estimates) tick("estimate", true, (on) => { view.wantsEstimate = on; view.show(view.frame); });
    if (view.ellipsoids) tick(view.given.frames.ellipsoid_label, true, (on) => { view.wantsEllipsoid = on; view.show(view.frame); });
    for (const [name, object] of Object.entries(view.extras)) tick(name, object.visible, (on) => { object.visible = on; });
    tick("names", true, (on) => { this.box.hidden = !on; });
    this.below.append(row);
  }

  legend() {
    const { view } = this, { given, path } = view, made = [];
    const scale = given.tension_scale;
    if (scale) made.push(this.scale("tension", scale.low, scale.high, "N", view.ramp("tension"), `limits ${scale.limits}`));
    const own = path?.quantity;
    if (own) made.push(this.scale(own.label, own.low, own.high, own.unit, view.ramp(own.colours), own.note ?? ""));
    this.legends.replaceChildren(...made);
  }

  scale(label, low, high, unit, colours, note) {
    const bar = make("canvas", { width: colours.length, height: 1, className: "scale" }), pen = bar.getContext("2d");
    colours.forEach((colour, k) => { pen.fillStyle = colour; pen.fillRect(k, 0, 1, 1); });
    bar.setAttribute("aria-hidden", "true");
    return make("div", { className: "legend" }, make("div", { className: "what", textContent: label }), bar,
      make("div", { className: "ends" }, make("span", { textContent: quantity(low, unit, Math.max(Math.abs(low), Math.abs(high))) }),
        make("span", { textContent: quantity(high, unit, Math.max(Math.abs(low), Math.abs(high))) })),
      note ? make("div", { className: "note", textContent: note }) : null);
  }

  state() {
    if (this.view.live) return; // the operator's page shows it itself
    const { view } = this, { given, path } = view, frame = view.frame, told = [];
    const item = (what, value, kind = "") => told.push(make("div", { className: `item ${kind}` }, make("span", { className: "what", textContent: what }), make("span", { textContent: value })));
    const pose = view.pose(), turned = pose.length > 3;
    if (given.frames.names) item("state", given.frames.names[frame]);
    if (view.times) item("time", clock(view.times.values[frame]));
    if (view.layers && path.layers.length > 1) item("layer", String(view.layers.values[frame]));
    if (view.fileLines) item(path.line_name, String(view.fileLines.values[frame]));
    item("position", `(${pose.slice(0, 3).map((v) => fixed(v, 3)).join(", ")}) m`);
    if (turned) item("rotation vector", `(${pose.slice(3).map((v) => fixed(v * 180 / Math.PI, 2)).join(", ")})\u00b0`);
    given.lines.forEach(({ name, limits }, i) => {
      const t = view.lines.tension(frame, i), out = Number.isFinite(t) && (t < limits[0] * (1 - 1e-9) || t > limits[1] * (1 + 1e-9));
      item(name, Number.isFinite(t) ? `${quantity(t, "N")}${out ? t < limits[0] ? ", below its limit" : ", above its limit" : ""}` : "not known", out ? "out" : "");
    });
    const note = given.frames.notes?.[frame];
    if (note) told.push(make("p", { className: "soft", textContent: note }));
    this.readout?.replaceChildren(...told);
    if (this.sliders) this.posed();
    if (this.scrub) {
      this.scrub.value = String(frame);
      this.clock.textContent = given.frames.names ? `${frame + 1} of ${view.count}` : view.times ? clock(view.times.values[frame]) : `${frame + 1}`;
      this.scrub.setAttribute("aria-valuetext", this.clock.textContent);
    }
  }

  hover(event) {
    const box = this.view.canvas.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    cancelAnimationFrame(this.looking);
    this.looking = requestAnimationFrame(() => this.showTip(pick(this.view, x, y), x, y));
  }

  showTip(found, x, y) {
    this.tip.hidden = !found;
    if (!found) return;
    const { given, path, lines, frame } = this.view, rows = [];
    if (found.vertex !== undefined) {
      const i = found.vertex;
      const where = [path.layers.length > 1 && `layer ${path.layers[path.layer[i]]}`, path.line && `${path.line_name} ${path.line[i]}`].filter(Boolean);
      if (where.length) rows.push(where.join(", "));
      if (path.time) rows.push(clock(path.time[i] / 1e3));
      rows.push(`(${path.place(i).map((v) => fixed(v, 3)).join(", ")}) m`);
      for (const each of path.quantities.slice(0, 6)) rows.push(`${each.label}: ${quantity(path.value(each, i), each.unit)}`);
    } else {
      const { name, limits } = given.lines[found.line], t = lines.tension(frame, found.line);
      rows.push(name, `tension ${quantity(t, "N")}`, `limits ${quantity(limits[0], "N")} to ${quantity(limits[1], "N")}`);
    }
    this.tip.replaceChildren(...rows.map((text) => make("div", { textContent: text })));
    const { width, height } = this.view.camera;
    this.tip.style.transform = `translate(${Math.min(x + 14, width - this.tip.offsetWidth - 4)}px, ${Math.min(y + 14, height - this.tip.offsetHeight - 4)}px)`;
  }

  step(by) { this.view.gone = true; this.view.show(this.view.frame + by); }

  key(event) {
    const { view } = this, layer = (by) => { if (this.layer) { this.layer.value = String(Number(this.layer.value) + by); this.layered(); } };
    const keys = { " ": () => this.play(!this.playing), ",": () => this.step(-1), ".": () => this.step(1), "[": () => layer(-1), "]": () => layer(1) };
    if (!keys[event.key] || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    keys[event.key]();
  }
}
