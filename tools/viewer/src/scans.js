// Points that lidars saw, of one state at a time: a dot of a few pixels each.
import { unpacked } from "./data.js";
import { LAID, lineMaterial, Ribbon, UNKNOWN } from "./ribbon.js";

export class Scans {
  static async of(frames, grid) {
    const points = await unpacked(frames.scans), ends = await unpacked(frames.scan_ends);
    if (!points) return null;
    const made = new Scans(), counts = [...ends.values].map((end, k) => end - (k ? ends.values[k - 1] : 0)), most = Math.max(...counts);
    Object.assign(made, { points: points.values, ends: ends.values, material: grid.apply(lineMaterial(3, 1e-5)) });
    const marks = new Uint8Array(8 * most);
    for (let k = 0; k < 2 * most; k++) { marks[4 * k] = k % 2 ? LAID : 0; marks[4 * k + 1] = UNKNOWN; }
    made.ribbon = new Ribbon(new Uint16Array(8 * most), marks, made.material);
    return made;
  }

  show(frame) { // a dot is a line from a point to itself
    const from = frame ? this.ends[frame - 1] : 0, to = this.ends[frame], places = this.ribbon.places.array;
    for (let k = from; k < to; k++) for (let axis = 0; axis < 3; axis++) {
      const at = 8 * (k - from) + axis;
      places[at] = places[at + 4] = this.points[3 * k + axis];
    }
    this.ribbon.mesh.geometry.instanceCount = Math.max(0, 2 * (to - from) - 1);
    this.ribbon.changed();
  }
}
