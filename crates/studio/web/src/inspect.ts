// What helps to look at a harness: parts by name, shown and hidden; a cut through everything; measures between chosen places.
import * as THREE from "three";
import { element } from "./dom";
import { along, branchOf, Column, firstNodes, valueAt, within, type Frame } from "./frame";
import type { Hands } from "./hands";
import { FLOATS, type Scene } from "./protocol";
import type { Store } from "./store";
import { components, digits, millimetres } from "./units";
import type { View } from "./view";

export type Kind = "branch" | "constraint" | "joint" | "obstacle";
export interface Part {
  kind: Kind;
  name: string;
}
/** A place that is measured: a point of a cable, or a constraint. */
interface Place {
  words: string;
  position: THREE.Vector3;
  /** On which branch, and where (m). */
  on: { branch: string; s: number } | null;
}

/** A pattern as requirements have it: `*` stands for any characters, `?` for one; words without these stand for any that have them inside. */
export function matches(pattern: string, name: string): boolean {
  const wild = /[*?]/.test(pattern) ? pattern : `*${pattern}*`;
  const source = [...wild].map((c) => (c === "*" ? ".*" : c === "?" ? "." : c.replace(/[\\^$.|+()[\]{}]/, "\\$&"))).join("");
  return new RegExp(`^${source}$`, "is").test(name);
}

export class Inspect {
  readonly parts = element("div", { id: "parts" });
  readonly measures = element("div", { id: "measure" });
  /** What is not to be seen: "kind name". */
  private hidden = new Set<string>();
  private pattern = element("input", { type: "search", id: "find-part", placeholder: "name, or a pattern such as X*", "aria-label": "Names of parts" });
  private list = element("ul", { class: "long", "aria-label": "Parts" });
  private count = element("p", { class: "quiet", role: "status" });
  private axis = element("select", { id: "section-axis", "aria-label": "Cut across" }, ...["no cut", "x", "y", "z"].map((words, k) => element("option", { value: k === 0 ? "" : words }, words)));
  private offset = element("input", { type: "range", id: "section-at", min: 0, max: 1, step: 0.002, value: 0.5, "aria-label": "Place of the cut" });
  private side = element("input", { type: "checkbox", id: "section-side", "aria-label": "Other side" });
  private cutWords = element("output", { id: "section-words" });
  private plane = new THREE.Plane();
  private measuring = false;
  private places: Place[] = [];
  private line = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: "#ff9f1c", depthTest: false, transparent: true }));
  private start = element("button", { id: "measure-on", "aria-pressed": "false", title: "Then choose two places: points of cables, constraints (M)", onclick: () => this.measure(!this.measuring) }, "Measure");
  private result = element("dl", { class: "facts", id: "measured" });

  constructor(
    private store: Store,
    private view: View,
    private hands: Hands,
    /** What is shown has changed. */
    private changed: () => void,
  ) {
    const button = (id: string, words: string, title: string, act: () => void) => element("button", { id, title, onclick: act }, words);
    this.parts.append(
      this.pattern,
      element(
        "div",
        { class: "buttons" },
        button("hide-found", "Hide these", "Hides the parts of the list", () => this.hide((part) => this.isFound(part))),
        button("only-found", "Only these", "Hides all other parts", () => this.hide((part) => !this.isFound(part), true)),
        button("choose-found", "Choose these", "Chooses the parts of the list, to hide or delete them", () => this.onChoose(this.all().filter((part) => this.isFound(part)))),
        button("show-all", "Show all", "Shows every part", () => this.hide(() => false, true)),
      ),
      this.count,
      this.list,
      element("div", { class: "row" }, "Cut ", this.axis, this.offset, element("label", { class: "row" }, this.side, "other side")),
      this.cutWords,
    );
    this.measures.append(element("div", { class: "buttons" }, this.start, button("measure-clear", "Clear", "Forgets the places", () => this.clear())), this.result);
    this.pattern.addEventListener("input", () => this.show());
    for (const input of [this.axis, this.offset, this.side]) input.addEventListener("input", () => this.cut());
    this.line.frustumCulled = false;
    this.line.renderOrder = 6;
    this.line.visible = false;
    view.scene.add(this.line);
    store.on("scene", () => this.show());
    store.on("shown", () => {
      this.showMeasures();
      if (this.axis.value) this.cut();
    });
    hands.on("chosen", () => this.chosen());
    this.showMeasures();
  }

  /** The parts of the list are to be chosen. */
  onChoose: (parts: Part[]) => void = () => {};

  isHidden(kind: Kind, name: string): boolean {
    return this.hidden.has(`${kind} ${name}`);
  }

  // Parts

  all(): Part[] {
    const { scene } = this.store;
    if (!scene) return [];
    const of = (kind: Kind, list: { name: string }[]) => list.map(({ name }): Part => ({ kind, name }));
    return [...of("branch", scene.branches), ...of("constraint", scene.constraints), ...of("joint", scene.joints), ...of("obstacle", scene.obstacles)];
  }

  private isFound({ name }: Part): boolean {
    return matches(this.pattern.value.trim(), name);
  }

  /** Hides parts, beside those that are hidden already unless `anew`. */
  hide(which: (part: Part) => boolean, anew = false): void {
    if (anew) this.hidden.clear();
    for (const part of this.all()) if (which(part)) this.hidden.add(`${part.kind} ${part.name}`);
    this.show();
    this.changed();
  }

  private show(): void {
    const all = this.all();
    const found = all.filter((part) => this.isFound(part));
    const hidden = all.filter(({ kind, name }) => this.isHidden(kind, name)).length;
    this.count.textContent = `${found.length} of ${all.length} parts${hidden ? `, ${hidden} hidden` : ""}`;
    const row = ({ kind, name }: Part) => {
      const box = element("input", { type: "checkbox", checked: !this.isHidden(kind, name), "aria-label": `Show ${kind} ${name}` });
      box.addEventListener("change", () => {
        if (box.checked) this.hidden.delete(`${kind} ${name}`);
        else this.hidden.add(`${kind} ${name}`);
        this.show();
        this.changed();
      });
      return element("li", { class: "row" }, box, element("button", { class: "plain", title: "Shows the place", onclick: () => this.visit({ kind, name }) }, name), element("span", { class: "quiet" }, kind));
    };
    this.list.replaceChildren(...found.slice(0, 300).map(row), ...(found.length > 300 ? [element("li", { class: "quiet" }, `and ${found.length - 300} more: narrow the pattern`)] : []));
  }

  private visit({ kind, name }: Part): void {
    const { scene, shown } = this.store;
    if (!scene || !shown) return;
    if (kind === "branch") {
      const branch = branchOf(scene, name);
      const s = scene.branches[branch].length / 2;
      this.hands.choose({ is: "point", branch: name, s });
      this.view.visit(new THREE.Vector3(...along(shown, scene, branch, s).position));
    } else if (kind === "constraint") {
      this.hands.choose({ is: "constraint", name });
      const at = this.hands.at(name);
      if (at) this.view.visit(new THREE.Vector3(...at.at.position));
    } else {
      const index = (kind === "joint" ? scene.joints : scene.obstacles).findIndex((own) => own.name === name);
      const at = kind === "joint" ? shown.header.joints[index] : shown.header.obstacles[index]?.at;
      if (kind === "obstacle") this.hands.choose({ is: "obstacle", name });
      if (at) this.view.visit(new THREE.Vector3(...at.position));
    }
  }

  // The cut

  private cut(): void {
    const axis = this.axis.value as "" | "x" | "y" | "z";
    this.offset.disabled = this.side.disabled = axis === "";
    if (axis === "") {
      this.view.renderer.clippingPlanes = [];
      this.cutWords.textContent = "";
    } else {
      const { min, max } = this.view.bounds;
      const at = min[axis] + this.offset.valueAsNumber * (max[axis] - min[axis]);
      const sign = this.side.checked ? 1 : -1;
      this.plane.normal.set(axis === "x" ? sign : 0, axis === "y" ? sign : 0, axis === "z" ? sign : 0);
      this.plane.constant = -sign * at;
      this.view.renderer.clippingPlanes = [this.plane];
      this.cutWords.textContent = `${axis} ${this.side.checked ? "≥" : "≤"} ${millimetres(at)} is shown`;
    }
    this.view.draw();
  }

  // Measures

  measure(on: boolean): void {
    this.measuring = on;
    this.start.setAttribute("aria-pressed", String(on));
    if (on) this.places = [];
    this.showMeasures();
  }

  toggleMeasure(): void {
    this.measure(!this.measuring);
  }

  private clear(): void {
    this.places = [];
    this.showMeasures();
  }

  private chosen(): void {
    const place = this.measuring ? this.place() : null;
    if (!place) return;
    this.places = [...this.places, place].slice(-2);
    this.showMeasures();
  }

  /** The chosen place. */
  private place(): Place | null {
    const { scene, shown } = this.store;
    const { chosen } = this.hands;
    if (!scene || !shown || !chosen) return null;
    if (chosen.is === "point") {
      const { branch, s } = chosen;
      return { words: `${branch} at ${millimetres(s)}`, position: new THREE.Vector3(), on: { branch, s } };
    }
    if (chosen.is === "obstacle") return null;
    const place = this.hands.constraint()?.place;
    return { words: chosen.name, position: new THREE.Vector3(), on: place ? { branch: place[0], s: place[1] } : null };
  }

  /** Where a place is in the frame shown; null: it is not there. */
  private locate(place: Place, scene: Scene, frame: Frame): THREE.Vector3 | null {
    const at = frame.header.constraints.find(({ name }) => name === place.words);
    if (at) return place.position.set(...at.at.position);
    const on = pointOf(place, scene);
    return on ? place.position.set(...along(frame, scene, on.branch, on.s).position) : null;
  }

  private showMeasures(): void {
    const { scene, shown } = this.store;
    const facts: [string, string][] = [];
    const there = scene && shown ? this.places.map((place) => this.locate(place, scene, shown)) : [];
    this.line.visible = false;
    if (this.measuring && this.places.length < 2) facts.push(["", this.places.length === 0 ? "Choose the first place." : "Choose the second place."]);
    this.places.forEach((place, k) => facts.push([k === 0 ? "from" : "to", there[k] ? place.words : `${place.words} (not there in this frame)`]));
    const [a, b] = there;
    if (scene && shown && a && b) {
      const [first, second] = this.places.map((place) => pointOf(place, scene));
      const by = b.clone().sub(a);
      facts.push(["distance", millimetres(by.length())], ["along x, y, z", components(by.toArray(), "m", 4)]);
      if (first && second) {
        const angle = tangent(shown, scene, first).angleTo(tangent(shown, scene, second));
        facts.push(["angle of the cables", `${digits((angle * 180) / Math.PI, 4)}°`]);
        if (first.branch === second.branch) {
          facts.push(["arc length", millimetres(Math.abs(second.s - first.s))]);
          const least = leastClearance(shown, scene, first.branch, [first.s, second.s].sort((x, y) => x - y));
          if (least) facts.push(["least clearance", `${millimetres(least.value, 3)} at s = ${millimetres(least.s)}`]);
        }
      }
      this.line.geometry.setFromPoints([a, b]);
      this.line.visible = true;
    }
    for (const [k, place] of this.places.entries()) {
      const on = scene && pointOf(place, scene);
      if (!scene || !shown || !on || !there[k]) continue;
      const clearance = valueAt(shown, scene, on.branch, on.s, Column.clearance);
      if (!Number.isNaN(clearance)) facts.push([`clearance ${k === 0 ? "from" : "to"}`, millimetres(clearance, 3)]);
    }
    this.result.replaceChildren(...facts.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]));
    this.view.draw();
  }
}

/** Where a place is among the branches of a scene; null: it has no such branch, or one that is not as long. */
function pointOf({ on }: Place, scene: Scene): { branch: number; s: number } | null {
  const branch = on ? branchOf(scene, on.branch) : -1;
  const s = on && branch >= 0 ? within(scene, branch, on.s) : null;
  return s === null ? null : { branch, s };
}

/** Direction of a branch, from its start to its end. */
function tangent(frame: Frame, scene: Scene, { branch, s }: { branch: number; s: number }): THREE.Vector3 {
  const { node } = along(frame, scene, branch, s);
  const n = frame.nodes;
  const at = (node: number) => new THREE.Vector3(n[node * FLOATS], n[node * FLOATS + 1], n[node * FLOATS + 2]);
  return at(node + 1).sub(at(node)).normalize();
}

/** The smallest distance from obstacles at the nodes between two arc lengths; null: not known. */
function leastClearance(frame: Frame, scene: Scene, branch: number, [from, to]: number[]): { value: number; s: number } | null {
  const first = firstNodes(scene);
  let least: { value: number; s: number } | null = null;
  for (let node = first[branch]; node < first[branch + 1]; node++) {
    const [s, value] = [frame.nodes[node * FLOATS + Column.s], frame.nodes[node * FLOATS + Column.clearance]];
    if (s >= from && s <= to && !Number.isNaN(value) && (!least || value < least.value)) least = { value, s };
  }
  return least;
}
