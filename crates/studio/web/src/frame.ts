// A shape as it comes over the wire (see crates/studio/src/frame.rs): a header in JSON, then FLOATS numbers a node.
import { FLOATS, type Branch, type Header, type Scene } from "./protocol";

/** Where a quantity stands among the numbers of a node. */
export const Column = { x: 0, d1: 3, s: 6, curvature: 7, tension: 8, moment: 9, torque: 10, stretch: 11, surface: 12, set: 13, clearance: 14 } as const;

export interface Frame {
  header: Header;
  /** All nodes, branch after branch; a view on the message, nothing is copied. */
  nodes: Float32Array;
  bytes: number;
}

/** Reads a message; throws if it is not a frame. */
export function decode(buffer: ArrayBuffer): Frame {
  if (buffer.byteLength < 4) throw new Error("a frame of less than 4 bytes");
  const length = new DataView(buffer).getUint32(0, true);
  if (length % 4 !== 0 || 4 + length > buffer.byteLength) throw new Error(`a frame with a header of ${length} bytes`);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length))) as Header;
  const rest = buffer.byteLength - 4 - length;
  if (rest % (4 * FLOATS) !== 0) throw new Error(`a frame with ${rest} bytes of nodes`);
  return { header, nodes: new Float32Array(buffer, 4 + length, rest / 4), bytes: buffer.byteLength };
}

/** The number of a branch among those of the frames; -1: there is none of this name. */
export function branchOf(scene: Scene, name: string): number {
  return scene.branches.findIndex((branch) => branch.name === name);
}

/** An arc length within a branch; null: the branch is not as long. Arc lengths of nodes have 24 bits: the last may be a little longer. */
export function within(scene: Scene, branch: number, s: number): number | null {
  const { length } = scene.branches[branch];
  return s > length * (1 + 1e-6) ? null : Math.min(s, length);
}

/** Which nodes belong to which branch: the first of each, and one behind the last of all. */
export function firstNodes(scene: Scene): number[] {
  const first = [0];
  for (const branch of scene.branches) first.push(first[first.length - 1] + branch.nodes);
  return first;
}

/** Diameter (m) and smallest allowed bend radius (m) of a branch at an arc length (m). */
export function sectionAt(branch: Branch, s: number): { diameter: number; bend_radius_limit: number | null } {
  return branch.sections.find((part) => s <= part.to) ?? branch.sections[branch.sections.length - 1] ?? branch;
}

/** Whether a frame has as many nodes as the scene. */
export function fits(frame: Frame, scene: Scene): boolean {
  const first = firstNodes(scene);
  return frame.nodes.length === first[first.length - 1] * FLOATS;
}

/** Position (m) at an arc length of a branch, between nodes on a straight line; and the nodes it lies between. */
export function along(frame: Frame, scene: Scene, branch: number, s: number): { position: [number, number, number]; node: number; part: number } {
  const first = firstNodes(scene);
  let low = first[branch];
  let high = first[branch + 1] - 1;
  const n = frame.nodes;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (n[middle * FLOATS + Column.s] <= s) low = middle;
    else high = middle;
  }
  const [a, b] = [low * FLOATS, high * FLOATS];
  const length = n[b + Column.s] - n[a + Column.s];
  const part = length > 0 ? Math.min(1, Math.max(0, (s - n[a + Column.s]) / length)) : 0;
  const at = (axis: number) => n[a + axis] + part * (n[b + axis] - n[a + axis]);
  return { position: [at(0), at(1), at(2)], node: low, part };
}

/** A column's value at an arc length of a branch, between nodes on a straight line. */
export function valueAt(frame: Frame, scene: Scene, branch: number, s: number, column: number): number {
  const { node, part } = along(frame, scene, branch, s);
  const a = frame.nodes[node * FLOATS + column];
  const b = frame.nodes[(node + 1) * FLOATS + column];
  return part === 0 ? a : a + part * (b - a);
}
