// The previous shape, kept as a ghost, and what differs from it.
import { along, Column, firstNodes, type Frame } from "./frame";
import { FLOATS, type Scene, type Tightest } from "./protocol";

export interface Ghost {
  scene: Scene;
  frame: Frame;
  words: string;
}

export interface Difference {
  /** Greatest distance of points of the same arc length, m, and where. */
  greatest: number;
  branch: string;
  s: number;
  position: [number, number, number];
  /** Mean distance, weighted by length, m. */
  mean: number;
  tightest: { was: Tightest | null; is: Tightest | null };
}

/** Compares branches of the same name at the nodes of the present shape; where lengths differ, at the same part of the length. */
export function difference(ghost: Ghost, scene: Scene, frame: Frame): Difference | null {
  const first = firstNodes(scene);
  let greatest = -1;
  let at = { branch: 0, node: 0 };
  let [sum, weight] = [0, 0];
  for (let b = 0; b < scene.branches.length; b++) {
    const branch = scene.branches[b];
    const other = ghost.scene.branches.findIndex((each) => each.name === branch.name);
    if (other < 0) continue;
    const ratio = ghost.scene.branches[other].length / branch.length;
    const share = branch.length / branch.nodes;
    for (let node = first[b]; node < first[b + 1]; node++) {
      const n = node * FLOATS;
      const p = along(ghost.frame, ghost.scene, other, frame.nodes[n + Column.s] * ratio).position;
      const distance = Math.hypot(frame.nodes[n] - p[0], frame.nodes[n + 1] - p[1], frame.nodes[n + 2] - p[2]);
      sum += share * distance;
      weight += share;
      if (distance > greatest) [greatest, at] = [distance, { branch: b, node }];
    }
  }
  if (greatest < 0) return null;
  const n = at.node * FLOATS;
  return {
    greatest,
    branch: scene.branches[at.branch].name,
    s: frame.nodes[n + Column.s],
    position: [frame.nodes[n], frame.nodes[n + 1], frame.nodes[n + 2]],
    mean: sum / weight,
    tightest: { was: ghost.frame.header.tightest, is: frame.header.tightest },
  };
}
