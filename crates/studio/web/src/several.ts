// Several parts that are chosen together: with a box that is drawn over the picture, with Shift and a click, or by their names. They are
// hidden, isolated or deleted as one.
import * as THREE from "three";
import type { Bodies } from "./bodies";
import { byId, element } from "./dom";
import { firstNodes } from "./frame";
import type { Hands } from "./hands";
import type { Inspect, Kind, Part } from "./inspect";
import type { Link } from "./link";
import { FLOATS, type PartKind } from "./protocol";
import type { Store } from "./store";
import type { View } from "./view";

/** Corners of an obstacle that are looked for in a box, at most. */
const CORNERS = 20_000;
/** Kinds of parts that can be deleted by themselves: a joint goes with its branches. */
const DELETED: Partial<Record<Kind, PartKind>> = { branch: "branch", constraint: "constraint", obstacle: "obstacle" };
const PLURALS: Record<Kind, string> = { branch: "branches", constraint: "constraints", joint: "joints", obstacle: "obstacles" };

interface Box {
  pointer: number;
  from: [number, number];
  to: [number, number];
  /** Whether what is in it is added to what is chosen. */
  adds: boolean;
}

export class Several {
  private chosen = new Map<string, Part>();
  private box: Box | null = null;
  private rectangle = element("div", { id: "box", "aria-hidden": "true", hidden: true });
  private bar = element("div", { id: "several", role: "group", "aria-label": "Chosen parts", hidden: true });
  private button = byId("box-on");
  /** Whether a drag draws a box, also without Shift. */
  drawing = false;

  constructor(
    private store: Store,
    private view: View,
    private hands: Hands,
    private bodies: Bodies,
    private inspect: Inspect,
    private link: Link,
    /** Other parts are chosen. */
    private changed: (words: string) => void,
  ) {
    const stage = byId("stage");
    const canvas = view.renderer.domElement;
    stage.append(this.rectangle, this.bar);
    // Before hands and camera, which listen to the canvas itself.
    stage.addEventListener("pointerdown", (event) => event.target === canvas && this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.addEventListener("pointercancel", () => this.endBox());
    this.button.addEventListener("click", () => this.draw(!this.drawing));
    inspect.onChoose = (parts) => this.choose(parts);
    store.on("scene", () => this.keep());
  }

  has(kind: Kind, name: string): boolean {
    return this.chosen.has(`${kind} ${name}`);
  }

  get count(): number {
    return this.chosen.size;
  }

  /** Names of the chosen branches. */
  branches(): string[] {
    return [...this.chosen.values()].filter(({ kind }) => kind === "branch").map(({ name }) => name);
  }

  /** Whether the next drags draw boxes. */
  draw(on: boolean): void {
    this.drawing = on;
    this.button.setAttribute("aria-pressed", String(on));
    byId("stage").classList.toggle("drawing", on);
  }

  choose(parts: Iterable<Part>): void {
    this.chosen = new Map([...parts].map((part) => [`${part.kind} ${part.name}`, part]));
    this.show();
  }

  delete(): void {
    const parts = [...this.chosen.values()].flatMap(({ kind, name }) => {
      const part = DELETED[kind];
      return part ? [[part, name] as [PartKind, string]] : [];
    });
    if (this.hands.live && parts.length > 0) this.link.send({ do: "edit", edit: { is: "delete_all", parts } });
  }

  /** Parts that are gone are chosen no longer. */
  private keep(): void {
    const there = new Set(this.inspect.all().map(({ kind, name }) => `${kind} ${name}`));
    const left = [...this.chosen.values()].filter(({ kind, name }) => there.has(`${kind} ${name}`));
    if (left.length < this.chosen.size) this.choose(left);
  }

  private show(): void {
    const counts = (Object.keys(PLURALS) as Kind[]).map((kind) => [kind, [...this.chosen.values()].filter((part) => part.kind === kind).length] as const);
    const list = counts.filter(([, count]) => count > 0).map(([kind, count]) => (count === 1 ? `1 ${kind}` : `${count} ${PLURALS[kind]}`));
    const words = this.count === 0 ? "No parts are chosen." : `Chosen: ${list.join(", ")}.`;
    this.bar.hidden = this.count === 0;
    const act = (id: string, words: string, title: string, run: () => void) => element("button", { id, title, onclick: run }, words);
    const isChosen = ({ kind, name }: Part) => this.has(kind, name);
    this.bar.replaceChildren(
      element("span", {}, words),
      act("several-hide", "Hide", "Hides them", () => (this.inspect.hide(isChosen), this.choose([]))),
      act("several-only", "Only these", "Hides all other parts", () => this.inspect.hide((part) => !isChosen(part), true)),
      ...(this.hands.live ? [act("several-delete", "Delete", "Deletes them from the text, with what is of no use without them (Delete)", () => this.delete())] : []),
      act("several-none", "Forget", "They are chosen no longer (Escape)", () => this.choose([])),
    );
    this.changed(words);
  }

  // The box

  private where(event: PointerEvent): [number, number] {
    const bounds = this.view.renderer.domElement.getBoundingClientRect();
    return [event.clientX - bounds.left, event.clientY - bounds.top];
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0 || event.ctrlKey || event.metaKey || !(this.drawing || event.shiftKey)) return;
    event.stopPropagation();
    (event.target as Element).setPointerCapture(event.pointerId);
    const at = this.where(event);
    this.box = { pointer: event.pointerId, from: at, to: at, adds: event.shiftKey };
  }

  private move(event: PointerEvent): void {
    if (this.box?.pointer !== event.pointerId) return;
    this.box.to = this.where(event);
    const [left, top, right, bottom] = corners(this.box);
    this.rectangle.hidden = false;
    Object.assign(this.rectangle.style, { left: `${left}px`, top: `${top}px`, width: `${right - left}px`, height: `${bottom - top}px` });
  }

  private up(event: PointerEvent): void {
    const { box } = this;
    if (box?.pointer !== event.pointerId) return;
    this.endBox();
    const before = box.adds ? [...this.chosen.values()] : [];
    const [x, y] = box.to;
    if (Math.hypot(x - box.from[0], y - box.from[1]) >= 4) return this.choose([...before, ...this.within(corners(box))]);
    const part = this.under(x, y);
    if (!part) return;
    const others = before.filter(({ kind, name }) => kind !== part.kind || name !== part.name);
    this.choose(others.length < before.length ? others : [...before, part]);
  }

  private endBox(): void {
    this.box = null;
    this.rectangle.hidden = true;
  }

  private under(x: number, y: number): Part | null {
    const body = this.bodies.pick(x, y, 11);
    if (body) return body;
    const point = this.hands.pointUnder(x, y);
    if (point) return { kind: "branch", name: this.store.scene!.branches[point.branch].name };
    return this.bodies.obstacleUnder(x, y);
  }

  /** Parts that are shown and have a point in a rectangle of the screen, pixels. */
  private within([left, top, right, bottom]: [number, number, number, number]): Part[] {
    const { scene, shown } = this.store;
    if (!scene || !shown) return [];
    const place = new THREE.Vector3();
    const inside = () => {
      const at = this.view.toScreen(place);
      return at.z <= 1 && at.x >= left && at.x <= right && at.y >= top && at.y <= bottom;
    };
    const first = firstNodes(scene);
    const parts: Part[] = scene.branches
      .filter(({ name }, b) => {
        if (this.inspect.isHidden("branch", name)) return false;
        for (let i = first[b] * FLOATS; i < first[b + 1] * FLOATS; i += FLOATS) if ((place.fromArray(shown.nodes, i), inside())) return true;
        return false;
      })
      .map(({ name }) => ({ kind: "branch", name }));
    for (const { kind, name, acts, object } of this.bodies.bodies) {
      if (!acts) continue;
      const points = kind === "obstacle" ? (scene.obstacles.find((own) => own.name === name)?.corners ?? []) : [0, 0, 0];
      const step = 3 * Math.max(1, Math.ceil(points.length / 3 / CORNERS));
      object.updateMatrixWorld();
      for (let i = 0; i < points.length; i += step) {
        place.fromArray(points, i).applyMatrix4(object.matrixWorld);
        if (!inside()) continue;
        parts.push({ kind, name });
        break;
      }
    }
    return parts;
  }
}

/** Left, upper, right and lower side. */
function corners({ from, to }: Box): [number, number, number, number] {
  return [Math.min(from[0], to[0]), Math.min(from[1], to[1]), Math.max(from[0], to[0]), Math.max(from[1], to[1])];
}
