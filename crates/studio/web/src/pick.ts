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
  // Distance in pixels from the segment behind a node, the part of it that is nearest, and its depth.
  const near = { distance: Infinity, part: 0, depth: 0 };
  const measure = (node: number) => {
    const i = node * FLOATS;
    const j = i + FLOATS;
    project(n[i], n[i + 1], n[i + 2], a);
    project(n[j], n[j + 1], n[j + 2], b);
    near.distance = Infinity;
    if (a[2] > 1 || b[2] > 1) return;
    const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    const length = dx * dx + dy * dy;
    near.part = length > 0 ? Math.min(1, Math.max(0, ((x - a[0]) * dx + (y - a[1]) * dy) / length)) : 0;
    near.distance = Math.hypot(a[0] + near.part * dx - x, a[1] + near.part * dy - y);
    near.depth = a[2] + near.part * (b[2] - a[2]);
  };
  const at = (node: number, part: number): [number, number, number] => {
    const i = node * FLOATS;
    return [0, 1, 2].map((axis) => n[i + axis] + part * (n[i + FLOATS + axis] - n[i + axis])) as [number, number, number];
  };
  // Of all that lies under the pointer, what is in front ...
  let front: { branch: number; node: number; depth: number } | null = null;
  for (let branch = 0; branch < scene.branches.length; branch++) {
    for (let node = first[branch]; node + 1 < first[branch + 1]; node++) {
      measure(node);
      if (near.distance > 60 || near.distance > reach(branch, at(node, near.part))) continue;
      if (!front || near.depth < front.depth) front = { branch, node, depth: near.depth };
    }
  }
  if (!front) return null;
  // ... and from there along the cable to where it is nearest to the pointer.
  const { branch } = front;
  let node = front.node;
  measure(node);
  for (const by of [-1, 1]) {
    for (let distance = near.distance; node + by >= first[branch] && node + by + 1 < first[branch + 1]; distance = near.distance) {
      measure(node + by);
      if (near.distance > distance) break;
      node += by;
    }
    measure(node);
  }
  const part = near.part;
  const s = n[node * FLOATS + Column.s];
  return { branch, node, s: s + part * (n[(node + 1) * FLOATS + Column.s] - s), position: at(node, part) };
}
