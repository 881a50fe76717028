// What is under the pointer: a vertex of the path, a line, or the nozzle.
import { Matrix4 } from "three";

const REACH = 9; // pixels
const MOST = 60_000; // vertices looked at

export function pick(view, x, y) {
  const line = nearestLine(view, x, y), vertex = view.path && view.groups.path.visible ? nearestVertex(view, x, y) : null;
  if (vertex && (!line || vertex.gap < line.gap + 3)) return vertex;
  return line;
}

function nearestVertex(view, x, y) {
  const { path, camera } = view, m = new Matrix4().multiplyMatrices(camera.eye.projectionMatrix, camera.eye.matrixWorldInverse).elements;
  const { pairs, pieces } = path, every = Math.max(1, Math.ceil(pieces / MOST)); // of drawn pieces
  let best = null;
  for (let k = 0; k < pieces; k += every) {
    const i = pairs[2 * k + 1];
    const [px, py, pz] = [0, 1, 2].map((axis) => path.origin[axis] + path.step * path.places[3 * i + axis]);
    const w = m[3] * px + m[7] * py + m[11] * pz + m[15];
    if (w <= 0) continue;
    const sx = ((m[0] * px + m[4] * py + m[8] * pz + m[12]) / w + 1) / 2 * camera.width;
    const sy = (1 - (m[1] * px + m[5] * py + m[9] * pz + m[13]) / w) / 2 * camera.height;
    const gap = Math.hypot(sx - x, sy - y);
    if (gap < REACH && (!best || gap < best.gap - 2 || (gap < best.gap + 2 && w < best.depth))) best = { vertex: i, gap, depth: w };
  }
  return best;
}

function nearestLine(view, x, y) {
  let best = null;
  for (let i = 0; i < view.lines.m; i++) {
    const points = view.lines.points(view.frame, i).map((p) => view.project(p));
    for (let k = 1; k < points.length; k++) {
      const gap = fromSegment(x, y, points[k - 1], points[k]);
      if (gap < REACH && (!best || gap < best.gap)) best = { line: i, gap };
    }
  }
  return best;
}

function fromSegment(x, y, [ax, ay, az], [bx, by, bz]) {
  if (az > 1 || bz > 1) return Infinity;
  const dx = bx - ax, dy = by - ay, size = dx * dx + dy * dy;
  const share = size > 0 ? Math.max(0, Math.min(1, ((x - ax) * dx + (y - ay) * dy) / size)) : 0;
  return Math.hypot(x - ax - share * dx, y - ay - share * dy);
}
