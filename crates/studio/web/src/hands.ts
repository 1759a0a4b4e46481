// Hands: pointing, dragging, turning. A drag sends the newest target at most once a picture; old ones are never queued.
import * as THREE from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";
import { place, type Bodies } from "./bodies";
import { Emitter } from "./emitter";
import { along, branchOf, Column, firstNodes, within } from "./frame";
import type { Link } from "./link";
import { pickCable, type CablePoint } from "./pick";
import { FLOATS, type Constraint, type ConstraintFrame, type Holding, type Placed } from "./protocol";
import type { Store } from "./store";
import type { View } from "./view";

export type Axis = "x" | "y" | "z";
/** What is chosen: a constraint, an obstacle, or a point of a branch; by name, which edits of other parts leave as it is. */
export type Chosen = { is: "constraint"; name: string } | { is: "obstacle"; name: string } | { is: "point"; branch: string; s: number } | null;

interface Events {
  chosen: Chosen;
  /** What the pointer is over. */
  over: { x: number; y: number; name: string | null; point: CablePoint | null } | null;
  mode: void;
  dragging: boolean;
}

/** A drag: of a constraint, or of a point of a cable whose handle has been asked for and is not there yet. */
interface Drag {
  constraint: string | null;
  offset: THREE.Vector3;
  from: THREE.Vector3;
  target: THREE.Vector3;
  moved: boolean;
  pointer: number;
  x: number;
  y: number;
}

export class Hands extends Emitter<Events> {
  chosen: Chosen = null;
  axis: Axis | null = null;
  mode: "none" | "translate" | "rotate" = "none";
  private drag: Drag | null = null;
  /** Held before a `hold` was sent: what is held beyond it is the new handle. */
  private heldBefore: Set<string> | null = null;
  private dropWhenHeld = false;
  /** Constraints that have had targets and no drop yet. */
  private open = new Set<string>();
  private waiting = new Map<string, { position: [number, number, number] | null; orientation: [number, number, number, number] | null }>();
  private sending = false;
  private gizmo: TransformControls;
  private proxy = new THREE.Object3D();
  private marker: THREE.LineSegments;
  /** The chosen point of a cable. */
  private dot = new THREE.Mesh(new THREE.SphereGeometry(1, 20, 14), new THREE.MeshBasicMaterial({ color: "#ff9f1c", depthTest: false, transparent: true, opacity: 0.9 }));
  private settle = 0;
  /** Where a click on what lies behind cables and constraints began, pixels. */
  private pressed: { pointer: number; x: number; y: number } | null = null;
  /** The chosen obstacle as it was when it was taken hold of, and where it is wanted since. */
  private carried: { name: string; from: Placed; to: Placed } | null = null;

  constructor(
    private store: Store,
    private view: View,
    private bodies: Bodies,
    private link: Link,
  ) {
    super();
    const canvas = view.renderer.domElement;
    canvas.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.addEventListener("pointercancel", (event) => this.up(event));
    canvas.addEventListener("pointerleave", () => this.tell("over", null));
    this.gizmo = new TransformControls(view.camera, canvas);
    this.gizmo.setSize(0.8);
    view.scene.add(this.proxy, this.gizmo.getHelper());
    this.gizmo.addEventListener("change", () => view.draw());
    this.gizmo.addEventListener("objectChange", () => this.gizmoMoved());
    this.gizmo.addEventListener("mouseDown", () => {
      view.controls.enabled = false;
      if (this.constraintName()) this.backToShown();
      this.tell("dragging", true);
    });
    this.gizmo.addEventListener("mouseUp", () => {
      view.controls.enabled = true;
      const name = this.constraintName();
      if (name) this.drop(name);
      this.putDown();
      this.tell("dragging", false);
    });
    const line = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(new Float32Array(6 + 18), 3));
    this.marker = new THREE.LineSegments(line, new THREE.LineBasicMaterial({ color: "#c2334d", depthTest: false, transparent: true }));
    this.marker.visible = false;
    this.marker.frustumCulled = false;
    this.marker.renderOrder = 5;
    this.dot.renderOrder = 4;
    view.scene.add(this.marker, this.dot);
    view.before.push(() => this.drawDot());
    store.on("session", () => this.lookForHandle());
    store.on("scene", () => this.sceneChanged());
    store.on("shown", () => this.follow());
  }

  /** Whether a branch is not to be seen, and so not to be picked. */
  isHidden: (branch: string) => boolean = () => false;

  get live(): boolean {
    return this.store.scene?.live === true;
  }

  get dragging(): boolean {
    return this.drag !== null || this.gizmo.dragging || this.open.size > 0;
  }

  constraintName(): string | null {
    return this.chosen?.is === "constraint" ? this.chosen.name : null;
  }

  constraint(): Constraint | null {
    const name = this.constraintName();
    return this.store.scene?.constraints.find((constraint) => constraint.name === name) ?? null;
  }

  obstacleName(): string | null {
    return this.chosen?.is === "obstacle" ? this.chosen.name : null;
  }

  /** The part of the gizmo that is pointed at. */
  ring(): string | null {
    return this.gizmo.axis;
  }

  /** Where a constraint is in the frame shown. */
  at(name: string): ConstraintFrame | null {
    return this.store.shown?.header.constraints.find((constraint) => constraint.name === name) ?? null;
  }

  /** Where an obstacle is in the frame shown. */
  obstacleAt(name: string): Placed | null {
    const index = this.store.scene?.obstacles.findIndex((obstacle) => obstacle.name === name) ?? -1;
    return this.store.shown?.header.obstacles[index]?.at ?? null;
  }

  choose(chosen: Chosen): void {
    this.dropAll();
    this.chosen = chosen;
    this.bodies.chosen = this.constraintName();
    this.attach();
    this.tell("chosen", chosen);
    this.view.draw();
  }

  setMode(mode: "none" | "translate" | "rotate"): void {
    this.mode = mode;
    this.attach();
    this.tell("mode", undefined);
  }

  setAxis(axis: Axis | null): void {
    this.axis = axis;
    this.tell("mode", undefined);
  }

  private sceneChanged(): void {
    this.carried = null;
    this.bodies.carried = null;
    const obstacle = this.obstacleName();
    if (this.chosen?.is === "constraint" && !this.constraint()) this.choose(null);
    else if (obstacle !== null && !this.store.scene?.obstacles.some(({ name }) => name === obstacle)) this.choose(null);
    else if (this.chosen?.is === "point" && !this.chosenPoint()) this.choose(null);
    else {
      this.bodies.chosen = this.constraintName();
      this.attach();
    }
    this.lookForHandle();
  }

  private attach(): void {
    this.gizmo.camera = this.view.camera;
    const constraint = this.constraint();
    const at = this.handleAt();
    const useful = at && this.live && (constraint === null || (this.mode === "translate" && constraint.moves) || (this.mode === "rotate" && constraint.turns));
    if (useful && this.mode !== "none") {
      place(this.proxy, at);
      this.gizmo.setMode(this.mode);
      this.gizmo.setSpace(this.mode === "rotate" ? "local" : "world");
      this.gizmo.attach(this.proxy);
    } else this.gizmo.detach();
    this.view.draw();
  }

  /** The camera is another one. */
  cameraChanged(): void {
    this.gizmo.camera = this.view.camera;
  }

  /** Where the gizmo of what is chosen stands: at the held point of a constraint, in the middle of an obstacle. */
  private handleAt(): Placed | null {
    const constraint = this.constraintName();
    if (constraint) return this.at(constraint)?.at ?? null;
    const obstacle = this.obstacleName();
    const at = obstacle && this.obstacleAt(obstacle);
    if (!at) return null;
    return { ...at, position: this.middle(obstacle).applyQuaternion(rotation(at)).add(new THREE.Vector3(...at.position)).toArray() };
  }

  /** The middle of an obstacle from its origin, in its own axes. */
  private middle(obstacle: string): THREE.Vector3 {
    return this.bodies.find("obstacle", obstacle)?.middle.clone() ?? new THREE.Vector3();
  }

  private follow(): void {
    if ((this.constraintName() || this.obstacleName()) && !this.gizmo.dragging) {
      const at = this.handleAt();
      if (at) place(this.proxy, at);
      if (!at || !this.gizmo.object) this.attach();
    }
    this.drawMarker();
  }

  /** Shows the chosen obstacle at another pose, where it is to be; `putDown` sends that. */
  private carry(to: Placed): void {
    const name = this.obstacleName();
    const from = name && (this.carried?.name === name ? this.carried.from : this.obstacleAt(name));
    if (!from) return;
    this.carried = { name, from, to };
    this.bodies.carry(name, to);
    this.view.draw();
  }

  /** Moves and turns the chosen obstacle in the text, to where it has been carried. */
  private putDown(): void {
    const { carried } = this;
    this.carried = null;
    if (carried) this.link.send({ do: "edit", edit: { is: "move", obstacle: carried.name, from: carried.from, to: carried.to } });
  }

  private gizmoMoved(): void {
    const obstacle = this.obstacleName();
    if (obstacle && this.gizmo.dragging) {
      const { position, quaternion: q } = this.proxy;
      const origin = position.clone().sub(this.middle(obstacle).applyQuaternion(q));
      return this.carry({ position: origin.toArray(), orientation: [q.w, q.x, q.y, q.z] });
    }
    const name = this.constraintName();
    if (!name || !this.gizmo.dragging) return;
    const q = this.proxy.quaternion;
    if (this.mode === "rotate") this.aim(name, this.proxy.position.toArray() as [number, number, number], [q.w, q.x, q.y, q.z]);
    else this.aim(name, this.proxy.position.toArray() as [number, number, number], null);
  }

  // Targets

  /** Hands act at the end of what has been done: at a scrubbed place the session goes back there first. */
  backToShown(): void {
    if (!this.store.following && this.store.wanted < this.store.newest()) {
      this.link.send({ do: "go", frame: this.store.wanted });
      this.store.following = true;
    }
  }

  /** Brings a constraint somewhere with the next picture; what was wanted of it before and has not been sent is forgotten. */
  aim(constraint: string, position: [number, number, number] | null, orientation: [number, number, number, number] | null): void {
    this.waiting.set(constraint, { position, orientation });
    this.open.add(constraint);
    if (this.sending) return;
    this.sending = true;
    requestAnimationFrame(() => this.flush());
  }

  private flush(): void {
    this.sending = false;
    for (const [constraint, target] of this.waiting) this.link.send({ do: "target", constraint, ...target });
    this.waiting.clear();
  }

  private drop(constraint: string): void {
    this.flush();
    if (this.open.delete(constraint)) this.link.send({ do: "drop", constraint });
  }

  private dropAll(): void {
    clearTimeout(this.settle);
    for (const constraint of [...this.open]) this.drop(constraint);
    this.putDown();
  }

  /** An exact pose: one target, and the end of it. */
  bring(name: string, pose: Placed, turned: boolean): void {
    this.backToShown();
    this.aim(name, pose.position, turned ? pose.orientation : null);
    this.drop(name);
  }

  /** A step of an arrow key: targets follow each other like a drag that ends when the keys rest. */
  nudge(right: number, up: number, towards: number): void {
    if (!this.live) return;
    const [x, y, z] = this.view.axes().map(alongAxis);
    const obstacle = this.obstacleName();
    const stands = obstacle && (this.carried?.to ?? this.obstacleAt(obstacle));
    if (stands) {
      const to = new THREE.Vector3(...stands.position).addScaledVector(x, right).addScaledVector(y, up).addScaledVector(z, towards);
      this.carry({ ...stands, position: to.toArray() });
      clearTimeout(this.settle);
      this.settle = window.setTimeout(() => this.dropAll(), 700);
    }
    const constraint = this.constraint();
    const at = constraint && this.at(constraint.name);
    if (!constraint || !at || !constraint.moves) return;
    if (!this.open.has(constraint.name)) this.backToShown();
    const from = this.nudged?.constraint === constraint.name && this.open.has(constraint.name) ? this.nudged.at : new THREE.Vector3(...at.at.position);
    const to = from.clone().addScaledVector(x, right).addScaledVector(y, up).addScaledVector(z, towards);
    this.nudged = { constraint: constraint.name, at: to };
    this.aim(constraint.name, to.toArray() as [number, number, number], null);
    clearTimeout(this.settle);
    this.settle = window.setTimeout(() => this.dropAll(), 700);
  }
  private nudged: { constraint: string; at: THREE.Vector3 } | null = null;

  /** Asks for a hand, a pin or a clip at a point of a branch. */
  hold(branch: string, s: number, how: Holding): void {
    const scene = this.store.scene;
    if (!scene || !this.live) return;
    this.backToShown();
    this.heldBefore = new Set(scene.constraints.map((constraint) => constraint.name));
    this.link.send({ do: "hold", branch, s, how });
  }

  /** Releases the chosen constraint; an obstacle is deleted from the text. */
  release(): void {
    const obstacle = this.obstacleName();
    if (obstacle && this.live) this.link.send({ do: "edit", edit: { is: "delete", part: "obstacle", name: obstacle } });
    const name = this.constraintName();
    if (!name || !this.live) return;
    this.dropAll();
    this.backToShown();
    this.link.send({ do: "release", constraint: name });
  }

  pin(): void {
    if (!this.live) return;
    if (this.chosen?.is === "point") return this.hold(this.chosen.branch, this.chosen.s, "pin");
    const name = this.constraintName();
    if (!name) return;
    this.dropAll();
    this.backToShown();
    this.link.send({ do: "pin", constraint: name });
  }

  /** A `hold` has been answered when a constraint is there that was not there before. */
  private lookForHandle(): void {
    if (!this.heldBefore || !this.store.scene) return;
    const made = this.store.scene.constraints.find((constraint) => constraint.by_hand && !this.heldBefore!.has(constraint.name));
    if (!made) return;
    this.heldBefore = null;
    const drag = this.drag;
    if (drag && drag.constraint === null) {
      drag.constraint = made.name;
      this.chosen = { is: "constraint", name: made.name };
      this.bodies.chosen = made.name;
      this.tell("chosen", this.chosen);
      if (drag.moved) this.aim(made.name, drag.target.toArray() as [number, number, number], null);
    } else if (this.dropWhenHeld && this.lastTarget) {
      this.aim(made.name, this.lastTarget, null);
      this.drop(made.name);
      this.choose({ is: "constraint", name: made.name });
    } else this.choose({ is: "constraint", name: made.name });
    this.dropWhenHeld = false;
    this.lastTarget = null;
  }
  private lastTarget: [number, number, number] | null = null;

  /** The server refused something, or is another one: what hands were at ends. */
  refused(): void {
    this.heldBefore = null;
    this.lastTarget = null;
    this.dropWhenHeld = false;
    this.waiting.clear();
    this.carried = null;
    this.bodies.carried = null;
    const open = [...this.open];
    this.open.clear();
    for (const constraint of open) this.link.send({ do: "drop", constraint });
    if (this.drag) this.endDrag();
  }

  // The pointer

  private where(event: PointerEvent): [number, number] {
    const box = this.view.renderer.domElement.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  pointUnder(x: number, y: number): CablePoint | null {
    const { scene, shown } = this.store;
    if (!scene || !shown) return null;
    const matrix = new THREE.Matrix4().multiplyMatrices(this.view.camera.projectionMatrix, this.view.camera.matrixWorldInverse).elements;
    const [w, h] = [this.view.width, this.view.height];
    return pickCable(
      scene,
      shown,
      (px, py, pz, out) => {
        const d = matrix[3] * px + matrix[7] * py + matrix[11] * pz + matrix[15];
        out[0] = (((matrix[0] * px + matrix[4] * py + matrix[8] * pz + matrix[12]) / d + 1) / 2) * w;
        out[1] = ((1 - (matrix[1] * px + matrix[5] * py + matrix[9] * pz + matrix[13]) / d) / 2) * h;
        out[2] = d > 0 ? (matrix[2] * px + matrix[6] * py + matrix[10] * pz + matrix[14]) / d : 2;
      },
      x,
      y,
      (branch, position) => this.isHidden(scene.branches[branch].name) ? -1 : 5 + scene.branches[branch].diameter / 2 / this.view.metresPerPixel(new THREE.Vector3(...position)),
    );
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0 || event.ctrlKey || event.metaKey || this.drag) return;
    if (this.gizmo.object && this.gizmo.axis !== null) return;
    const [x, y] = this.where(event);
    const body = this.bodies.pick(x, y, 11);
    const constraint = body?.constraint ?? null;
    const point = constraint ? null : this.pointUnder(x, y);
    if (!constraint && !point) {
      this.pressed = { pointer: event.pointerId, x, y };
      return;
    }
    // From here on the pointer is ours, not the camera's.
    event.stopImmediatePropagation();
    (event.target as Element).setPointerCapture(event.pointerId);
    const from = constraint ? new THREE.Vector3(...this.at(constraint.name)!.at.position) : new THREE.Vector3(...point!.position);
    this.choose(constraint ? { is: "constraint", name: constraint.name } : { is: "point", branch: this.store.scene!.branches[point!.branch].name, s: point!.s });
    const movable = this.live && (constraint === null || constraint.moves);
    this.drag = { constraint: constraint?.name ?? null, offset: new THREE.Vector3(), from, target: from.clone(), moved: false, pointer: event.pointerId, x, y };
    this.drag.offset.copy(from).sub(this.onPlane(x, y));
    if (!movable) this.drag.pointer = -1;
  }

  /** Where the pointer leads: in the plane of the view through the beginning, or along an axis. */
  private onPlane(x: number, y: number): THREE.Vector3 {
    const drag = this.drag!;
    const ray = this.view.ray(x, y);
    const [, , towards] = this.view.axes();
    const out = new THREE.Vector3();
    if (!ray.intersectPlane(new THREE.Plane().setFromNormalAndCoplanarPoint(towards, drag.from), out)) out.copy(drag.from);
    return out;
  }

  private alongAxis(x: number, y: number): THREE.Vector3 {
    const drag = this.drag!;
    const axis = { x: new THREE.Vector3(1, 0, 0), y: new THREE.Vector3(0, 1, 0), z: new THREE.Vector3(0, 0, 1) }[this.axis!];
    const parameter = (px: number, py: number) => {
      const ray = this.view.ray(px, py);
      // The point of the line from + t·axis that is nearest to the ray.
      const w = new THREE.Vector3().subVectors(drag.from, ray.origin);
      const b = axis.dot(ray.direction);
      const d = 1 - b * b;
      return d < 1e-6 ? 0 : (b * ray.direction.dot(w) - axis.dot(w)) / d;
    };
    return drag.from.clone().addScaledVector(axis, parameter(x, y) - parameter(drag.x, drag.y));
  }

  private move(event: PointerEvent): void {
    const [x, y] = this.where(event);
    const drag = this.drag;
    if (!drag) {
      if (event.buttons === 0) this.hover(x, y);
      return;
    }
    if (drag.pointer !== event.pointerId) return;
    if (!drag.moved && Math.hypot(x - drag.x, y - drag.y) < 4) return;
    if (!drag.moved) {
      drag.moved = true;
      this.view.renderer.domElement.style.cursor = "grabbing";
      this.tell("dragging", true);
      if (drag.constraint === null && this.chosen?.is === "point") this.hold(this.chosen.branch, this.chosen.s, "handle");
      else this.backToShown();
    }
    drag.target.copy(this.axis ? this.alongAxis(x, y) : this.onPlane(x, y).add(drag.offset));
    if (drag.constraint !== null) this.aim(drag.constraint, drag.target.toArray() as [number, number, number], null);
    this.drawMarker();
    this.view.draw();
  }

  private up(event: PointerEvent): void {
    const { drag, pressed } = this;
    this.pressed = null;
    if (pressed?.pointer === event.pointerId && event.type === "pointerup") {
      const [x, y] = this.where(event);
      const obstacle = Math.hypot(x - pressed.x, y - pressed.y) < 4 ? this.bodies.obstacleUnder(x, y) : null;
      if (obstacle) this.choose({ is: "obstacle", name: obstacle.name });
    }
    if (!drag || (drag.pointer !== event.pointerId && drag.pointer !== -1)) return;
    if (drag.moved && drag.constraint !== null) this.drop(drag.constraint);
    else if (drag.moved && this.heldBefore) {
      this.dropWhenHeld = true;
      this.lastTarget = drag.target.toArray() as [number, number, number];
    }
    this.endDrag();
  }

  private endDrag(): void {
    const moved = this.drag?.moved;
    this.drag = null;
    this.marker.visible = false;
    this.view.renderer.domElement.style.cursor = "";
    if (moved) this.tell("dragging", false);
    this.view.draw();
  }

  private hover(x: number, y: number): void {
    const body = this.bodies.pick(x, y, 11);
    const point = body?.kind === "constraint" ? null : this.pointUnder(x, y);
    this.view.renderer.domElement.style.cursor = body?.constraint ? (this.live && body.constraint.moves ? "grab" : "pointer") : point ? (this.live ? "grab" : "pointer") : "";
    this.tell("over", body || point ? { x, y, name: body?.name ?? null, point } : null);
  }

  private drawDot(): void {
    const { scene, shown } = this.store;
    const point = this.chosen?.is === "point" ? this.chosenPoint() : null;
    this.dot.visible = point !== null && shown !== null;
    if (!point || !scene || !shown) return;
    this.dot.position.set(...along(shown, scene, point.branch, point.s).position);
    this.dot.scale.setScalar(Math.max(5 * this.view.metresPerPixel(this.dot.position), 0.65 * scene.branches[point.branch].diameter));
  }

  /** A line from where the held point is to where it is wanted, with a cross there. */
  private drawMarker(): void {
    const drag = this.drag;
    this.marker.visible = drag !== null && drag.moved;
    if (!drag || !drag.moved) return;
    const at = drag.constraint ? this.at(drag.constraint)?.at.position : undefined;
    const size = 9 * this.view.metresPerPixel(drag.target);
    const p = this.marker.geometry.getAttribute("position") as THREE.BufferAttribute;
    const from = at ? new THREE.Vector3(...at) : drag.from;
    p.setXYZ(0, from.x, from.y, from.z);
    p.setXYZ(1, drag.target.x, drag.target.y, drag.target.z);
    for (let axis = 0; axis < 3; axis++) {
      const step = new THREE.Vector3().setComponent(axis, size);
      p.setXYZ(2 + 2 * axis, drag.target.x - step.x, drag.target.y - step.y, drag.target.z - step.z);
      p.setXYZ(3 + 2 * axis, drag.target.x + step.x, drag.target.y + step.y, drag.target.z + step.z);
    }
    p.needsUpdate = true;
  }

  /** The point that is chosen, in the frame shown: for plots and the marker; null: there is no such branch, or it is not as long. */
  chosenPoint(): { branch: number; s: number } | null {
    const { scene } = this.store;
    if (!scene) return null;
    if (this.chosen?.is === "point") {
      const branch = branchOf(scene, this.chosen.branch);
      const s = branch < 0 ? null : within(scene, branch, this.chosen.s);
      return s === null ? null : { branch, s };
    }
    const constraint = this.constraint();
    if (!constraint?.place) return null;
    const branch = branchOf(scene, constraint.place[0]);
    return branch < 0 ? null : { branch, s: this.at(constraint.name)?.slid_to ?? constraint.place[1] };
  }

  /** Goes along the branch, from node to node; where nothing is chosen, to the start of the first. */
  walk(by: number): void {
    const { scene, shown } = this.store;
    const point = this.chosenPoint();
    if (!scene || !shown) return;
    if (!point) return this.choose({ is: "point", branch: scene.branches[0].name, s: 0 });
    const branch = scene.branches[point.branch];
    const spacing = branch.length / Math.max(1, branch.nodes - 1);
    const node = Math.min(branch.nodes - 1, Math.max(0, Math.round(point.s / spacing) + by));
    this.choose({ is: "point", branch: branch.name, s: shown.nodes[(firstNodes(scene)[point.branch] + node) * FLOATS + Column.s] });
  }

  /** To the middle of the next branch, or of the one before. */
  nextBranch(by: number): void {
    const { scene } = this.store;
    if (!scene) return;
    const now = this.chosenPoint()?.branch ?? (by > 0 ? -1 : 0);
    const branch = scene.branches[(now + by + scene.branches.length) % scene.branches.length];
    this.choose({ is: "point", branch: branch.name, s: branch.length / 2 });
  }
}

/** An orientation as three.js has it. */
function rotation({ orientation: [w, x, y, z] }: Placed): THREE.Quaternion {
  return new THREE.Quaternion(x, y, z, w).normalize();
}

/** The axis of the world that a direction of the screen is nearest to. */
function alongAxis(direction: THREE.Vector3): THREE.Vector3 {
  const parts = direction.toArray();
  const greatest = parts.reduce((best, value, axis) => (Math.abs(value) > Math.abs(parts[best]) ? axis : best), 0);
  return new THREE.Vector3().setComponent(greatest, Math.sign(parts[greatest]));
}
