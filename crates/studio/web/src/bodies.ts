// What stands about the cable: constraints by kind, joints, obstacles, arrows of forces and of better places. Shapes in the frame of what they stand for: d3 is z.
import * as THREE from "three";
import type { Frame } from "./frame";
import type { Constraint, Obstacle, Placed, Scene } from "./protocol";
import { newtons } from "./units";
import type { View } from "./view";

/** Kinds of things that can be pointed at; the colour of each (readable on dark and on light). */
const COLOUR = { connector: "#2867c9", collar: "#b26a00", handle: "#c2334d", pin: "#7a3fb0", other: "#5d6b78", joint: "#6b7d90", force: "#d1470f", better: "#1f8a4c" };

/** Length of the arrow to where a requirement is kept better, as a fraction of the harness's size. */
const BETTER = 0.18;

/** At least so many pixels from end to end; fewer where there are many. */
const PIXELS = { few: 22, many: 10 };

export interface Body {
  name: string;
  kind: "constraint" | "joint" | "obstacle";
  words: string;
  object: THREE.Object3D;
  /** True size, m. */
  size: number;
  /** Its middle from its origin, in its own axes. */
  middle: THREE.Vector3;
  constraint: Constraint | null;
  /** Whether it is there in the frame shown. */
  acts: boolean;
  /** Whether it is drawn as chosen. */
  marked: boolean;
}

export interface ArrowLabel {
  place: THREE.Vector3;
  words: string;
  kind: "force" | "better";
}

export class Bodies {
  readonly group = new THREE.Group();
  bodies: Body[] = [];
  arrowLabels: ArrowLabel[] = [];
  /** Metres a newton; set by the slider, times what suits the harness. */
  arrowScale = 1;
  showArrows = true;
  chosen: string | null = null;
  /** An obstacle that is shown where it is to be, until there is a frame of that. */
  carried: { name: string; at: Placed } | null = null;
  /** The direction in which to move a constraint for a requirement. */
  better: { constraint: string; direction: THREE.Vector3; words: string } | null = null;
  private arrows = new THREE.Group();
  private perNewton = 0;
  private diameters = new Map<string, number>();
  private size = 1;
  private greatest = 0;

  constructor(private view: View) {
    this.group.add(this.arrows);
  }

  /** Whether a body is not to be seen. */
  isHidden: (kind: Body["kind"], name: string) => boolean = () => false;

  /** Whether a body is drawn as chosen. */
  isMarked: (kind: Body["kind"], name: string) => boolean = () => false;

  setScene(scene: Scene): void {
    for (const body of this.bodies) this.group.remove(body.object);
    const thickest = Math.max(1e-3, ...scene.branches.map((branch) => branch.diameter));
    this.diameters = new Map(scene.branches.map((branch) => [branch.name, branch.diameter]));
    this.size = Math.max(0.05, ...scene.branches.map((branch) => branch.length));
    this.bodies = [];
    for (const obstacle of scene.obstacles) {
      this.bodies.push({ name: obstacle.name, kind: "obstacle", words: obstacle.name, object: solid(obstacle), size: 0, middle: middle(obstacle), constraint: null, acts: true, marked: false });
    }
    for (const joint of scene.joints) {
      const widest = Math.max(1e-3, ...joint.branches.map((name) => this.diameters.get(name) ?? thickest));
      const object = jointBody(joint.model, widest);
      this.bodies.push({ name: joint.name, kind: "joint", words: joint.name, object, size: 2 * widest, middle: new THREE.Vector3(), constraint: null, acts: true, marked: false });
    }
    for (const constraint of scene.constraints) {
      const diameter = (constraint.place && this.diameters.get(constraint.place[0])) ?? thickest;
      const length = (constraint.place && scene.branches.find((branch) => branch.name === constraint.place![0])?.length) ?? 1;
      const atStart = constraint.place !== null && constraint.place[1] < length / 2;
      const object = constraintBody(constraint, diameter, atStart);
      this.bodies.push({ name: constraint.name, kind: "constraint", words: constraint.name, object, size: 3 * diameter, middle: new THREE.Vector3(), constraint, acts: false, marked: false });
    }
    for (const body of this.bodies) {
      body.object.visible = body.acts;
      this.group.add(body.object);
    }
  }

  /** The greatest force so far decides how long arrows are; forgotten with the frames. */
  forget(): void {
    this.greatest = 0;
  }

  take(frame: Frame): void {
    for (const constraint of frame.header.constraints) this.greatest = Math.max(this.greatest, Math.hypot(...constraint.force));
    this.perNewton = this.greatest > 0 ? (0.18 * this.size) / this.greatest : 0;
  }

  update(frame: Frame): void {
    const header = frame.header;
    const acting = new Map(header.constraints.map((constraint) => [constraint.name, constraint]));
    let joint = 0;
    let obstacle = 0;
    for (const body of this.bodies) {
      let at: Placed | undefined;
      if (body.kind === "joint") at = header.joints[joint++];
      else if (body.kind === "obstacle") {
        at = header.obstacles[obstacle++]?.at;
        if (at && body.name === this.carried?.name) at = this.carried.at;
      }
      else at = acting.get(body.name)?.at;
      body.acts = at !== undefined && !this.isHidden(body.kind, body.name);
      body.object.visible = body.acts;
      if (at) place(body.object, at);
      if (body.marked !== this.isMarked(body.kind, body.name)) mark(body);
    }
    this.drawArrows(frame);
  }

  /** Shows an obstacle elsewhere. */
  carry(name: string, at: Placed): void {
    this.carried = { name, at };
    const body = this.find("obstacle", name);
    if (body) place(body.object, at);
  }

  private drawArrows(frame: Frame): void {
    this.arrowLabels = [];
    let used = 0;
    const thick = 0.0022 * this.size;
    const one = (at: [number, number, number], direction: THREE.Vector3, length: number, kind: ArrowLabel["kind"], words: string) => {
      if (length < 3 * thick) return;
      let arrow = this.arrows.children[used] as THREE.Group | undefined;
      if (!arrow) this.arrows.add((arrow = arrowBody()));
      used++;
      arrow.visible = true;
      arrow.position.set(...at);
      arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), direction);
      const [shaft, head] = arrow.children as THREE.Mesh<THREE.BufferGeometry, THREE.MeshPhongMaterial>[];
      shaft.material.color.set(COLOUR[kind]);
      shaft.material.emissive.set(COLOUR[kind]);
      const headLength = Math.min(7 * thick, 0.5 * length);
      shaft.scale.set(thick, thick, length - headLength);
      head.position.z = length - headLength;
      head.scale.set(2.6 * thick, 2.6 * thick, headLength);
      this.arrowLabels.push({ place: new THREE.Vector3(...at).addScaledVector(direction, length), words, kind });
    };
    const better = this.better;
    const held = better && frame.header.constraints.find(({ name }) => name === better.constraint);
    if (held && !this.isHidden("constraint", held.name)) one(held.at.position, better.direction, BETTER * this.size, "better", better.words);
    if (this.showArrows) {
      const scale = this.perNewton * this.arrowScale;
      const force = (at: [number, number, number], force: [number, number, number]) => {
        const size = Math.hypot(...force);
        if (size > 0) one(at, new THREE.Vector3(...force).divideScalar(size), size * scale, "force", newtons(size));
      };
      for (const constraint of frame.header.constraints) if (!this.isHidden("constraint", constraint.name)) force(constraint.at.position, constraint.force);
      for (const obstacle of frame.header.obstacles) if (obstacle.contacts > 0) force(obstacle.at.position, obstacle.force);
    }
    for (const arrow of this.arrows.children.slice(used)) arrow.visible = false;
  }

  /** Small things are drawn larger than they are, so that they can be seen and taken hold of. */
  atLeast(): void {
    const acting = this.bodies.filter((body) => body.acts && body.kind === "constraint").length;
    const pixels = Math.max(PIXELS.many, PIXELS.few * Math.min(1, Math.sqrt(12 / Math.max(1, acting))));
    for (const body of this.bodies) {
      if (!body.acts || body.kind === "obstacle") continue;
      const wanted = (body.kind === "joint" ? 0.6 : 1) * pixels * this.view.metresPerPixel(body.object.position);
      body.object.scale.setScalar(Math.max(1, wanted / body.size) * (body.name === this.chosen && body.kind === "constraint" ? 1.25 : 1));
    }
  }

  /** The constraint or joint under a pixel. */
  pick(x: number, y: number, slack: number): Body | null {
    let best: Body | null = null;
    let nearest = Infinity;
    for (const body of this.bodies) {
      if (!body.acts || body.kind === "obstacle") continue;
      const at = this.view.toScreen(body.object.position);
      if (at.z > 1) continue;
      const reach = Math.max(slack, (0.5 * body.size * body.object.scale.x) / this.view.metresPerPixel(body.object.position));
      const distance = Math.hypot(at.x - x, at.y - y) + (body.kind === "joint" ? 4 : 0);
      if (distance < reach && distance < nearest) [best, nearest] = [body, distance];
    }
    return best;
  }

  /** The obstacle whose surface is in front under a pixel. */
  obstacleUnder(x: number, y: number): Body | null {
    const caster = new THREE.Raycaster();
    caster.ray.copy(this.view.ray(x, y));
    let [front, nearest]: [Body | null, number] = [null, Infinity];
    for (const body of this.bodies) {
      if (!body.acts || body.kind !== "obstacle") continue;
      body.object.updateMatrixWorld();
      // Behind the surface come its edges, if they are drawn.
      const [hit] = caster.intersectObject(body.object.children[0], false);
      if (hit && hit.distance < nearest) [front, nearest] = [body, hit.distance];
    }
    return front;
  }

  find(kind: Body["kind"], name: string): Body | undefined {
    return this.bodies.find((body) => body.name === name && body.kind === kind);
  }
}

export function place(object: THREE.Object3D, at: Placed): void {
  const [w, x, y, z] = at.orientation;
  object.position.set(...at.position);
  object.quaternion.set(x, y, z, w).normalize();
}

const paint = (colour: string) => new THREE.MeshPhongMaterial({ color: colour, shininess: 20, specular: "#333333" });

function mesh(geometry: THREE.BufferGeometry, material: THREE.Material, x = 0, y = 0, z = 0): THREE.Mesh {
  const made = new THREE.Mesh(geometry, material);
  made.position.set(x, y, z);
  return made;
}

/** A plug with a latch on d1's side; a ring with a foot; a ball between two plates of fingers; a pin; a block. */
function constraintBody(constraint: Constraint, d: number, atStart: boolean): THREE.Group {
  const group = new THREE.Group();
  const along = atStart ? -1 : 1;
  const round = (radius: number, length: number, sides = 24) => new THREE.CylinderGeometry(radius, radius, length, sides).rotateX(Math.PI / 2);
  if (constraint.kind === "connector") {
    const material = paint(COLOUR.connector);
    group.add(mesh(new THREE.BoxGeometry(1.7 * d, 2.3 * d, 2.6 * d), material, 0, 0, along * 1.1 * d));
    group.add(mesh(new THREE.BoxGeometry(0.5 * d, 0.8 * d, 1.8 * d), paint("#86b4f5"), 1.05 * d, 0, along * 1.1 * d));
    group.add(mesh(round(0.75 * d, 0.8 * d), paint("#22303f"), 0, 0, -along * 0.3 * d));
  } else if (constraint.kind === "collar" || constraint.kind === "clip") {
    const material = paint(COLOUR.collar);
    group.add(mesh(new THREE.TorusGeometry(0.78 * d, 0.28 * d, 12, 32), material));
    group.add(mesh(round(0.85 * d, 0.7 * d), material));
    group.add(mesh(new THREE.BoxGeometry(1.1 * d, 0.9 * d, 0.8 * d), paint("#e2a33c"), -1.2 * d, 0, 0));
  } else if (constraint.kind === "handle") {
    const material = paint(COLOUR.handle);
    group.add(mesh(new THREE.SphereGeometry(0.95 * d, 24, 16), new THREE.MeshPhongMaterial({ color: COLOUR.handle, transparent: true, opacity: 0.75 })));
    for (const side of [-1, 1]) group.add(mesh(new THREE.BoxGeometry(0.35 * d, 1.2 * d, 2.2 * d), material, side * 0.85 * d, 0, 0));
  } else if (constraint.kind === "pin") {
    group.add(mesh(new THREE.ConeGeometry(0.7 * d, 2.4 * d, 16).rotateZ(-Math.PI / 2), paint(COLOUR.pin), -1.3 * d, 0, 0));
    group.add(mesh(round(0.75 * d, 0.9 * d), paint(COLOUR.pin)));
  } else {
    group.add(mesh(new THREE.OctahedronGeometry(1.3 * d), paint(COLOUR.other)));
  }
  return group;
}

/** A box for a rigid body, a capsule for one whose arms give way, a ball for arms that meet in a point. */
function jointBody(model: string, d: number): THREE.Group {
  const group = new THREE.Group();
  const material = paint(COLOUR.joint);
  if (model === "rigid-body") group.add(mesh(new THREE.BoxGeometry(1.9 * d, 1.5 * d, 1.9 * d), material));
  else if (model === "compliant-hub") group.add(mesh(new THREE.CapsuleGeometry(0.95 * d, 0.9 * d, 6, 20), material));
  else if (model === "fused") group.add(mesh(new THREE.DodecahedronGeometry(0.95 * d), material));
  else group.add(mesh(new THREE.SphereGeometry(0.9 * d, 20, 14), material));
  return group;
}

function solid(obstacle: Obstacle): THREE.Group {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(obstacle.corners, 3));
  geometry.setIndex(obstacle.triangles);
  const group = new THREE.Group();
  const material = new THREE.MeshPhongMaterial({ color: "#9aa7b4", flatShading: true, transparent: true, opacity: 0.55, side: THREE.DoubleSide, depthWrite: false });
  const surface = new THREE.Mesh(geometry, material);
  surface.renderOrder = 1;
  group.add(surface);
  if (obstacle.triangles.length < 60_000) {
    group.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 25), new THREE.LineBasicMaterial({ color: "#66727e" })));
  }
  return group;
}

/** Draws a body as chosen, or no longer so. */
function mark(body: Body): void {
  body.marked = !body.marked;
  for (const part of body.object.children) {
    const { material } = part as THREE.Mesh;
    if (material instanceof THREE.MeshPhongMaterial) material.emissive.set(body.marked ? "#b35c00" : "#000000");
  }
}

function middle(obstacle: Obstacle): THREE.Vector3 {
  return new THREE.Box3().setFromArray(obstacle.corners).getCenter(new THREE.Vector3());
}

function arrowBody(): THREE.Group {
  const group = new THREE.Group();
  const material = new THREE.MeshPhongMaterial({ emissiveIntensity: 0.25 });
  group.add(new THREE.Mesh(new THREE.CylinderGeometry(1, 1, 1, 12).rotateX(Math.PI / 2).translate(0, 0, 0.5), material));
  group.add(new THREE.Mesh(new THREE.ConeGeometry(1, 1, 16).rotateX(Math.PI / 2).translate(0, 0, 0.5), material));
  return group;
}
