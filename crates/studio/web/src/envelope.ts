// The tolerance envelope of a sweep: tubes that hold each branch in a share of the points at the end of a step, and the surface of all that was swept.
import * as THREE from "three";
import type { EnvelopeHeader, EnvelopeTube } from "./protocol";

const AROUND = 16;
/** Rings of a rounded end. */
const RINGS = 4;
/** What is shown: a percentile, all that was swept, or nothing. */
export type Choice = number | "swept" | "none";

interface Tube extends EnvelopeTube {
  centre: Float32Array;
  /** By percentile. */
  radii: Float32Array[];
}

export class Envelope {
  readonly group = new THREE.Group();
  private tubes: Tube[] = [];
  private surface: THREE.BufferGeometry | null = null;
  private drawn = "";

  /** Reads what the server sends; throws if that is not an envelope. */
  read(buffer: ArrayBuffer): void {
    const length = new DataView(buffer).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length))) as EnvelopeHeader;
    let at = 4 + length;
    const floats = (count: number) => new Float32Array(buffer, (at += 4 * count) - 4 * count, count);
    this.tubes = header.tubes.map((tube) => ({ ...tube, centre: floats(3 * tube.stations), radii: tube.percentiles.map(() => floats(tube.stations)) }));
    const corners = floats(3 * header.corners);
    const triangles = new Uint32Array(buffer, at, 3 * header.triangles);
    if (header.triangles === 0) return;
    this.surface = new THREE.BufferGeometry();
    this.surface.setAttribute("position", new THREE.BufferAttribute(corners, 3));
    this.surface.setIndex(new THREE.BufferAttribute(triangles, 1));
    this.surface.computeVertexNormals();
  }

  /** What can be shown, with words. */
  choices(): [Choice, string][] {
    const percentiles = this.tubes[0]?.percentiles ?? [];
    const words = (percent: number): [Choice, string] => [percent, percent === 100 ? "all points" : `${percent} % of the points`];
    return [["none", "none"], ...percentiles.map(words), ...(this.surface ? [["swept", "all that was swept"] as [Choice, string]] : [])];
  }

  /** The step whose tubes belong to a frame: that of the same name; for the start the first one, for what was added after it the last one. */
  step(shown: string, isStart: boolean): string | null {
    const steps = this.tubes.map((tube) => tube.step);
    return steps.includes(shown) ? shown : ((isStart ? steps[0] : steps[steps.length - 1]) ?? null);
  }

  /** Shows a choice at a step; returns what it is, in words. */
  show(choice: Choice, step: string | null): string {
    const own = choice === "none" || choice === "swept" ? [] : this.tubes.filter((tube) => tube.step === step && tube.percentiles.includes(choice));
    const key = own.length > 0 ? `${choice} ${step}` : choice === "swept" ? "swept" : "";
    if (key !== this.drawn) {
      this.drawn = key;
      for (const child of this.group.children as THREE.Mesh<THREE.BufferGeometry, THREE.Material>[]) {
        if (child.geometry !== this.surface) child.geometry.dispose();
        child.material.dispose();
      }
      this.group.clear();
      const shapes = own.map((tube) => round(tube.centre, tube.radii[tube.percentiles.indexOf(choice as number)]));
      if (choice === "swept" && this.surface) shapes.push(this.surface);
      // Later than the cables, which are seen through it.
      for (const shape of shapes) this.group.add(Object.assign(new THREE.Mesh(shape, seenThrough()), { renderOrder: 1 }));
    }
    if (choice === "swept" && this.surface) return "at all points, in all steps";
    return own.length > 0 ? `${own[0].points} points, at the end of step ${step}` : "";
  }
}

function seenThrough(): THREE.MeshPhongMaterial {
  return new THREE.MeshPhongMaterial({ color: "#e68a1a", transparent: true, opacity: 0.35, depthWrite: false, side: THREE.DoubleSide });
}

/** A tube of these radii along a line, with hemispheres at its ends. */
function round(centre: Float32Array, radii: Float32Array): THREE.BufferGeometry {
  const last = radii.length - 1;
  const at = (k: number) => new THREE.Vector3().fromArray(centre, 3 * k);
  const tangents: THREE.Vector3[] = [];
  for (let k = 0; k <= last; k++) {
    const tangent = at(Math.min(k + 1, last)).sub(at(Math.max(k - 1, 0)));
    const before = tangents[k - 1] ?? new THREE.Vector3(1, 0, 0);
    const usable = tangent.length() > 1e-9 && (k === 0 || tangent.dot(before) > 0);
    tangents.push(usable ? tangent.normalize() : before.clone());
  }
  const across = new THREE.Vector3(1, 0, 0);
  if (Math.abs(tangents[0].x) > 0.7) across.set(0, 1, 0);
  const rings: [number, number][] = [];
  for (let k = RINGS; k > 0; k--) rings.push([0, (-k / RINGS) * (Math.PI / 2)]);
  for (let k = 0; k <= last; k++) rings.push([k, 0]);
  for (let k = 1; k <= RINGS; k++) rings.push([last, (k / RINGS) * (Math.PI / 2)]);
  const position = new Float32Array(3 * rings.length * AROUND);
  const normal = new Float32Array(position.length);
  const index: number[] = [];
  rings.forEach(([k, latitude], ring) => {
    const tangent = tangents[k];
    across.addScaledVector(tangent, -across.dot(tangent)).normalize();
    const other = new THREE.Vector3().crossVectors(tangent, across);
    for (let a = 0; a < AROUND; a++) {
      const angle = (2 * Math.PI * a) / AROUND;
      const outward = across.clone().multiplyScalar(Math.cos(angle)).addScaledVector(other, Math.sin(angle));
      outward.multiplyScalar(Math.cos(latitude)).addScaledVector(tangent, Math.sin(latitude));
      const corner = ring * AROUND + a;
      outward.toArray(normal, 3 * corner);
      at(k).addScaledVector(outward, radii[k]).toArray(position, 3 * corner);
      if (ring === 0) continue;
      const next = ring * AROUND + ((a + 1) % AROUND);
      index.push(corner - AROUND, next - AROUND, next, corner - AROUND, next, corner);
    }
  });
  const shape = new THREE.BufferGeometry();
  shape.setAttribute("position", new THREE.BufferAttribute(position, 3));
  shape.setAttribute("normal", new THREE.BufferAttribute(normal, 3));
  shape.setIndex(index);
  return shape;
}
