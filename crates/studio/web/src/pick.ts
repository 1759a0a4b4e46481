// Where on a cable one points: nearest point of all centre lines on the screen.
import { firstNodes, type Frame, Column } from "./frame";
import { FLOATS, type Scene } from "./protocol";

export interface CablePoint {
  branch: number;
  /** Arc length, m. */
  s: number;
  position: [number, number, number];
  /** Node before it. */
  node: number;
}

/** Projects: pixels and depth (beyond 1: not to be seen). */
export type Projection = (x: number, y: number, z: number, out: Float64Array) => void;

/** The nearest point within `reach(branch, position)` pixels; of several, the one in front. */
export function pickCable(
  scene: Scene,
  frame: Frame,
  project: Projection,
  x: number,
  y: number,
  reach: (branch: number, position: [number, number, number]) => number,
): CablePoint | null {
  const first = firstNodes(scene);
  const n = frame.nodes;
  const [a, b] = [new Float64Array(3), new Float64Array(3)];
  let best: CablePoint | null = null;
  let bestScore = Infinity;
  for (let branch = 0; branch < scene.branches.length; branch++) {
    for (let node = first[branch]; node + 1 < first[branch + 1]; node++) {
      const i = node * FLOATS;
      const j = i + FLOATS;
      project(n[i], n[i + 1], n[i + 2], a);
      project(n[j], n[j + 1], n[j + 2], b);
      if (a[2] > 1 || b[2] > 1) continue;
      const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
      const length = dx * dx + dy * dy;
      const part = length > 0 ? Math.min(1, Math.max(0, ((x - a[0]) * dx + (y - a[1]) * dy) / length)) : 0;
      const distance = Math.hypot(a[0] + part * dx - x, a[1] + part * dy - y);
      if (distance > 60) continue;
      const at = (axis: number) => n[i + axis] + part * (n[j + axis] - n[i + axis]);
      const position: [number, number, number] = [at(0), at(1), at(2)];
      const allowed = reach(branch, position);
      if (distance > allowed) continue;
      // Half a cable's width to the side counts as much as nothing; what lies in front wins among those.
      const score = Math.max(0, distance - 0.5 * allowed) + 1e3 * (a[2] + part * (b[2] - a[2]));
      if (score < bestScore) {
        bestScore = score;
        const s = n[i + Column.s] + part * (n[j + Column.s] - n[i + Column.s]);
        best = { branch, s, position, node };
      }
    }
  }
  return best;
}
