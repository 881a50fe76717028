// The path in the frame, to turn and zoom. Plain canvas, no library; data comes from the page itself.
"use strict";
(() => {
  const canvas = document.getElementById("view");
  if (!canvas) return;
  const data = JSON.parse(document.getElementById("view-data").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const grid = new Uint16Array(bytes(data.xyz).buffer);
  const level = bytes(data.level);
  const PEN_UP = 255, SLABS = 48, INK = "#1c2430", GREY = "#8a93a0";
  const count = level.length, levels = data.ramp.length;
  const { step, origin: [ox, oy, oz], frame: [low, high] } = data;
  const middle = low.map((v, i) => (v + high[i]) / 2);
  const size = Math.hypot(...low.map((v, i) => high[i] - v));
  const [px, py, bucket, order] = [Float32Array, Float32Array, Int32Array, Int32Array].map((Kind) => new Kind(count));
  const HOME = { azimuth: -62, elevation: 22, zoom: 1 }; // degrees
  let view = { ...HOME }, waiting = false;

  function camera(width, height) {
    const a = view.azimuth * Math.PI / 180, e = view.elevation * Math.PI / 180;
    const [ca, sa, ce, se] = [Math.cos(a), Math.sin(a), Math.cos(e), Math.sin(e)];
    const scale = 1.1 * view.zoom * Math.min(width - 90, height) / size;
    const closer = Math.max(0, 1 - 1 / view.zoom); // from the middle of the frame to that of the part
    const [mx, my, mz] = middle.map((v, i) => v + closer * (data.centre[i] - v));
    return (x, y, z) => {
      x -= mx; y -= my; z -= mz;
      return [
        width / 2 + scale * (-sa * x + ca * y),
        height / 2 - scale * (-ca * se * x - sa * se * y + ce * z),
        -(ca * ce * x + sa * ce * y + se * z) / size, // depth, about -0.5 near to 0.5 far
      ];
    };
  }

  function drawPath(pen, project) {
    const starts = new Int32Array(SLABS * levels + 1);
    for (let i = 0; i < count; i++) {
      const [x, y, d] = project(ox + step * grid[3 * i], oy + step * grid[3 * i + 1], oz + step * grid[3 * i + 2]);
      px[i] = x; py[i] = y;
      const slab = Math.max(0, Math.min(SLABS - 1, Math.floor((0.5 - d) * SLABS))); // far ones first
      bucket[i] = level[i] === PEN_UP ? -1 : slab * levels + level[i];
      if (bucket[i] >= 0) starts[bucket[i] + 1]++;
    }
    for (let b = 0; b < SLABS * levels; b++) starts[b + 1] += starts[b];
    const next = starts.slice();
    for (let i = 0; i < count; i++) if (bucket[i] >= 0) order[next[bucket[i]]++] = i;
    pen.lineWidth = Math.max(1.6, 1.6 * Math.sqrt(view.zoom));
    for (let b = 0; b < SLABS * levels; b++) {
      if (starts[b] === starts[b + 1]) continue;
      pen.strokeStyle = data.ramp[b % levels];
      pen.beginPath();
      for (const i of order.subarray(starts[b], starts[b + 1])) {
        pen.moveTo(px[i - 1], py[i - 1]); pen.lineTo(px[i], py[i]);
      }
      pen.stroke();
    }
  }

  function line(pen, [x, y], [u, v], colour, width) {
    pen.strokeStyle = colour; pen.lineWidth = width;
    pen.beginPath(); pen.moveTo(x, y); pen.lineTo(u, v); pen.stroke();
  }

  function drawFrame(pen, project) {
    const corner = (k) => project(...[0, 1, 2].map((axis) => (k >> axis & 1 ? high : low)[axis]));
    for (let k = 0; k < 8; k++)
      for (let axis = 0; axis < 3; axis++)
        if (!(k >> axis & 1)) line(pen, corner(k), corner(k | 1 << axis), GREY, 1);
  }

  function drawLines(pen, project) {
    const worst = data.worst && project(...data.worst);
    pen.fillStyle = INK; pen.textAlign = "center";
    for (const { name, exit, end } of data.lines) {
      const at = project(...exit);
      if (end) line(pen, at, project(...end), INK, 0.7);
      pen.fillRect(at[0] - 3, at[1] - 3, 6, 6);
      if (data.lines.length <= 12) pen.fillText(name.slice(0, 28), at[0], at[1] - 8);
    }
    if (!worst) return;
    pen.lineWidth = 2; pen.beginPath(); pen.arc(worst[0], worst[1], 7, 0, 7); pen.stroke();
    const left = worst[0] < project(...data.centre)[0];
    pen.textAlign = left ? "right" : "left"; pen.fillText(data.label, worst[0] + (left ? -11 : 11), worst[1] + 14);
  }

  function drawScale(pen, width, height) {
    const tall = Math.min(220, height - 80), top = 44, left = width - 74;
    pen.fillStyle = "#ffffffd8"; pen.fillRect(left - 22, top - 32, 96, tall + 44);
    for (let k = 0; k < levels; k++) {
      pen.fillStyle = data.ramp[levels - 1 - k];
      pen.fillRect(left, top + k * tall / levels, 14, tall / levels + 1);
    }
    pen.fillStyle = INK; pen.textAlign = "left"; pen.fillText("error in mm", left - 14, top - 14);
    for (const share of [0, 0.25, 0.5, 0.75, 1]) {
      const value = data.low + share * (data.high - data.low);
      pen.fillText(value.toPrecision(3), left + 20, top + (1 - share) * tall + 4);
    }
  }

  function draw() {
    waiting = false;
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    canvas.width = width * ratio; canvas.height = height * ratio;
    const pen = canvas.getContext("2d"), project = camera(width, height);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.lineCap = "round"; pen.font = "13px system-ui, sans-serif";
    for (const part of [drawFrame, drawPath, drawLines]) part(pen, project);
    drawScale(pen, width, height);
  }

  function change(turn, tilt, zoom) {
    view.azimuth += turn;
    view.elevation = Math.max(-10, Math.min(90, view.elevation + tilt));
    view.zoom = Math.max(0.5, Math.min(20, view.zoom * zoom));
    if (!waiting) { waiting = true; requestAnimationFrame(draw); }
  }

  const fingers = new Map();
  const spread = (map) => { const [a, b] = [...map.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = fingers.get(event.pointerId), two = fingers.size === 2;
    if (!last) return;
    const before = two ? spread(fingers) : 1, dx = event.clientX - last.x, dy = event.clientY - last.y;
    last.x = event.clientX; last.y = event.clientY;
    if (two) change(0, 0, spread(fingers) / Math.max(1, before));
    else if (fingers.size === 1) change(-dx * 0.4, dy * 0.4, 1);
  });
  for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, (e) => fingers.delete(e.pointerId));
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas) return; // the page scrolls until the view is clicked
    event.preventDefault();
    change(0, 0, Math.exp(-event.deltaY * 0.0015));
  }, { passive: false });
  const KEYS = {
    ArrowLeft: [5, 0, 1], ArrowRight: [-5, 0, 1], ArrowUp: [0, 5, 1], ArrowDown: [0, -5, 1],
    "+": [0, 0, 1.2], "=": [0, 0, 1.2], "-": [0, 0, 1 / 1.2], "0": [0, 0, 1],
  };
  canvas.addEventListener("keydown", (event) => {
    if (!KEYS[event.key]) return;
    event.preventDefault();
    if (event.key === "0") view = { ...HOME };
    change(...KEYS[event.key]);
  });
  new ResizeObserver(draw).observe(canvas);
})();
