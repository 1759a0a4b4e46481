// Forms that change the scenario: each sends one command, which the session writes into the text. Values are typed as the file has them:
// a number in SI units, or one with a unit such as 620 mm.
import * as THREE from "three";
import { element } from "./dom";
import { SURFACE_ENDINGS } from "./files";
import { along, branchOf, Column } from "./frame";
import type { Hands } from "./hands";
import type { Link } from "./link";
import { FLOATS, type Document, type Edit, type PartKind } from "./protocol";
import type { Store } from "./store";

type Entry = Record<string, unknown>;
/** An entry of the text, and the path to it. */
interface Found {
  entry: Entry;
  path: string;
}

const BEGINNINGS = ["add", "grasp", "clip", "mate"];
const HOLDS = ["position", "tangent", "twist"];
/** Parameters of the shapes that can be added here, with values to begin with. */
const SHAPES: Record<string, Entry> = {
  box: { size: ["100 mm", "100 mm", "100 mm"] },
  sphere: { radius: "50 mm" },
  cylinder: { radius: "30 mm", length: "200 mm" },
};

/** A name as a part of the path to a key. */
export function quoted(name: string): string {
  const plain = name !== "" && name.trim() === name && name !== "*" && !/[."']/.test(name);
  if (plain) return name;
  return name.includes('"') ? `'${name}'` : `"${name}"`;
}

/** What was typed, as the file has it: a number, words in quotes, or a list of these. */
export function typed(text: string): unknown {
  const plain = text.trim().replaceAll("−", "-");
  const list = plain.startsWith("[") && plain.endsWith("]") ? plain.slice(1, -1) : plain.includes(",") ? plain : null;
  if (list !== null) return list.split(",").map((part) => typed(part.trim().replace(/^"(.*)"$/, "$1")));
  if (plain === "true" || plain === "false") return plain === "true";
  return plain !== "" && Number.isFinite(Number(plain)) ? Number(plain) : plain;
}

/** A value of the file in the words in which it is typed. */
export function shownAs(value: unknown): string {
  if (value === undefined || value === null) return "";
  return Array.isArray(value) ? value.map(shownAs).join(", ") : String(value);
}

const list = (value: unknown): Entry[] => (Array.isArray(value) ? (value as Entry[]) : []);
const rounded = (x: number, digits = 5) => Number(x.toFixed(digits)) + 0;

export class Build {
  readonly element = element("div", { id: "build" });
  private part = element("div", {});
  private obstacles = element("details", {});
  private requirements = element("details", {});
  private document: Document | null = null;
  /** What the forms were made for. */
  private made = "";

  constructor(
    private store: Store,
    private hands: Hands,
    private link: Link,
    /** Shows the place of a part in the text. */
    private showText: (name: string) => void,
    /** Adds an obstacle with the surface in a file. */
    private takeSurface: (file: File) => void,
  ) {
    this.element.append(this.part, this.obstacles, this.requirements);
    store.on("document", (document) => {
      this.document = document;
      this.show();
    });
    hands.on("chosen", () => this.show());
    store.on("refused", () => {
      this.made = "";
      this.show();
    });
  }

  private send(edit: Edit): void {
    this.link.send({ do: "edit", edit });
  }

  private get entries(): Entry {
    return (this.document?.entries ?? {}) as Entry;
  }

  private branch(name: string): Found | null {
    const entry = list(this.entries.branches).find((own) => own.name === name);
    return entry ? { entry, path: `branches.${quoted(name)}` } : null;
  }

  private constraint(name: string): Found | null {
    const own = list(this.entries.constraints).find((entry) => entry.name === name);
    if (own) return { entry: own, path: `constraints.${quoted(name)}` };
    for (const [k, step] of list(this.entries.steps).entries()) {
      for (const key of BEGINNINGS) {
        const entry = list(step[key]).find((each) => each.name === name);
        if (entry) return { entry, path: `steps.${typeof step.name === "string" ? quoted(step.name) : k}.${key}.${quoted(name)}` };
      }
    }
    return null;
  }

  /** Makes the forms anew, unless nothing of what they show has changed. */
  show(): void {
    if (!this.document) return;
    const now = JSON.stringify([this.document.version, this.hands.chosen]);
    if (now === this.made) return;
    this.made = now;
    this.showPart();
    this.showObstacles();
    this.showRequirements();
  }

  // Fields

  private field(words: string, value: string, change: (value: string) => void, more: Entry = {}): HTMLElement {
    const input = element("input", { type: "text", autocomplete: "off", spellcheck: "false", value, "aria-label": words, ...(more as Record<string, string>) });
    input.addEventListener("change", () => change(input.value));
    input.addEventListener("keydown", (event) => event.key === "Escape" && (input.value = value));
    return element("label", { class: "setting" }, element("span", {}, words), element("span", { class: "field" }, input));
  }

  /** A field for the value of a key; emptied, the key is removed. */
  private value(words: string, found: Found, key: string): HTMLElement {
    const path = `${found.path}.${key}`;
    return this.field(words, shownAs(found.entry[key]), (text) => {
      if (text.trim() !== "") this.send({ is: "put", key: path, value: typed(text) });
      else if (found.entry[key] !== undefined) this.send({ is: "remove", key: path });
    });
  }

  private choice(words: string, value: string, all: [string, string][], change: (value: string) => void): HTMLElement {
    const known = all.some(([word]) => word === value) ? all : [[value, ""] as [string, string], ...all];
    const select = element("select", { "aria-label": words }, ...known.map(([word, doc]) => element("option", { value: word, title: doc, selected: word === value }, word)));
    select.addEventListener("change", () => change(select.value));
    return element("label", { class: "setting" }, element("span", {}, words), element("span", { class: "field" }, select));
  }

  private flag(words: string, on: boolean, change: (on: boolean) => void): HTMLElement {
    const input = element("input", { type: "checkbox", checked: on, "aria-label": words });
    input.addEventListener("change", () => change(input.checked));
    return element("label", { class: "row" }, input, words);
  }

  private name(part: PartKind, name: string, words = `name of the ${part}`): HTMLElement {
    return this.field(words, name, (to) => to !== name && this.send({ is: "rename", part, name, to }));
  }

  private button(words: string, title: string, act: () => void): HTMLElement {
    return element("button", { title, onclick: act }, words);
  }

  private remove(part: PartKind, name: string): HTMLElement {
    return this.button(`Delete ${part}`, `Deletes ${name} from the text, with what is of no use without it`, () => this.send({ is: "delete", part, name }));
  }

  private inText(name: string): HTMLElement {
    return this.button("In the text", "Shows it in the text", () => this.showText(name));
  }

  // The chosen part

  private showPart(): void {
    const { scene } = this.store;
    const { chosen } = this.hands;
    if (!scene || !chosen) {
      this.part.replaceChildren(element("p", { class: "quiet" }, "Choose a point of a cable, a constraint or an obstacle to change it here."));
    } else if (chosen.is === "obstacle") this.showObstacle(chosen.name);
    else if (chosen.is === "constraint") this.showConstraint(chosen.name);
    else if (branchOf(scene, chosen.branch) >= 0) this.showBranch(chosen.branch, branchOf(scene, chosen.branch), chosen.s);
  }

  private showBranch(name: string, index: number, s: number): void {
    const found = this.branch(name);
    if (!found) return this.part.replaceChildren(element("p", { class: "quiet" }, `Branch ${name} is in a file that the text includes.`));
    const sections: [string, string][] = Object.keys((this.entries.sections ?? {}) as Entry).map((section) => [section, ""]);
    const place = { name: "tap", section: String(found.entry.section ?? ""), length: "200 mm" };
    const kind = { kind: "collar", name: "" };
    this.part.replaceChildren(
      element("h3", {}, `Branch ${name}`),
      this.name("branch", name),
      this.value("length", found, "length"),
      this.choice("section", String(found.entry.section ?? ""), sections, (value) => this.send({ is: "put", key: `${found.path}.section`, value })),
      element("div", { class: "buttons" }, this.remove("branch", name), this.inText(name)),
      ...this.sectionParts(found, index, s, sections),
      element("h3", {}, `At s = ${(1000 * s).toFixed(1)} mm`),
      this.choice("kind of clip", kind.kind, this.document!.constraint_kinds, (value) => (kind.kind = value)),
      this.field("name of the clip", this.unused("clip"), (value) => (kind.name = value)),
      element(
        "div",
        { class: "buttons" },
        this.button("Add clip", "Adds it where the cable is now; it acts from the start", () => this.addClip(name, index, s, kind.kind, kind.name || this.unused("clip"))),
        this.button("Split here", "Splits the branch into two that meet in a joint", () => this.send({ is: "split", branch: name, s: rounded(s) })),
      ),
      this.field("name of the new branch", place.name, (value) => (place.name = value)),
      this.field("its length", place.length, (value) => (place.length = value)),
      this.choice("its section", place.section, sections, (value) => (place.section = value)),
      element(
        "div",
        { class: "buttons" },
        this.button("Add branch here", "Adds a branch with a free end, at a joint in this place", () => this.addBranch(name, index, s, place)),
      ),
    );
  }

  /** The parts of a branch with another section, and a new one from the chosen place on. */
  private sectionParts(found: Found, index: number, s: number, sections: [string, string][]): HTMLElement[] {
    const parts = list(found.entry.sections);
    const put = (value: Entry[]) => this.send(value.length ? { is: "put", key: `${found.path}.sections`, value } : { is: "remove", key: `${found.path}.sections` });
    const length = this.store.scene?.branches[index].length ?? s;
    const millimetres = (at: number) => `${rounded(1000 * at, 3)} mm`;
    const added = { section: sections.find(([section]) => section !== found.entry.section)?.[0] ?? "", from: millimetres(s), to: millimetres(Math.min(s + 0.1, length)) };
    const shown = parts.flatMap((entry, k) => {
      const own = { entry, path: `${found.path}.sections.${k}` };
      return [
        this.choice(`section of part ${k + 1}`, String(entry.section ?? ""), sections, (value) => this.send({ is: "put", key: `${own.path}.section`, value })),
        this.value(`part ${k + 1} from`, own, "from"),
        this.value(`part ${k + 1} to`, own, "to"),
        element("div", { class: "buttons" }, this.button(`Delete part ${k + 1}`, "It has the section of the branch again", () => put(parts.filter((other) => other !== entry)))),
      ];
    });
    return [
      element("h3", {}, "Parts with another section"),
      ...shown,
      this.choice("section of a new part", added.section, sections, (value) => (added.section = value)),
      this.field("new part from", added.from, (value) => (added.from = value)),
      this.field("new part to", added.to, (value) => (added.to = value)),
      element(
        "div",
        { class: "buttons" },
        this.button("Add part", "Gives this part of the branch another section, such as under a tube", () => put([...parts, { section: added.section, from: typed(added.from), to: typed(added.to) }])),
      ),
    ];
  }

  /** An unused name of a constraint: "clip 1". */
  private unused(word: string): string {
    for (let k = 1; ; k++) if (!this.constraint(`${word} ${k}`)) return `${word} ${k}`;
  }

  private addClip(branch: string, index: number, s: number, kind: string, name: string): void {
    const { scene, shown } = this.store;
    if (!scene || !shown) return;
    const { position, node, part } = along(shown, scene, index, s);
    const n = shown.nodes;
    const from = [0, 1, 2].map((axis) => n[node * FLOATS + axis]);
    const to = [0, 1, 2].map((axis) => n[(node + 1) * FLOATS + axis]);
    const tangent = new THREE.Vector3(to[0] - from[0], to[1] - from[1], to[2] - from[2]).normalize();
    const place = part === 0 ? { branch, s: rounded(n[node * FLOATS + Column.s], 6) } : { branch, s: rounded(s, 6) };
    this.send({ is: "add", list: "constraints", entry: { name, kind, at: place, position: position.map((x) => rounded(x)), tangent: tangent.toArray().map((x) => rounded(x)) } });
  }

  private addBranch(branch: string, index: number, s: number, { name, section, length }: { name: string; section: string; length: string }): void {
    const found = this.branch(branch);
    const { scene } = this.store;
    if (!found || !scene) return;
    const whole = scene.branches[index].length;
    // At an end of the branch: at its vertex, which is a joint or a free end.
    const vertex = s < 1e-6 * whole ? String(found.entry.from) : s > (1 - 1e-6) * whole ? String(found.entry.to) : null;
    const joint = vertex !== null && list(this.entries.joints).some((own) => own.name === vertex);
    this.send({ is: "branch", name, section, length: typed(length), from: vertex === null ? { point: { branch, s: rounded(s) } } : joint ? { joint: vertex } : { end: vertex } });
  }

  private showConstraint(name: string): void {
    const found = this.constraint(name);
    if (!found) return this.part.replaceChildren(element("p", { class: "quiet" }, `Constraint ${name} is not in this text.`));
    const { entry, path } = found;
    const kind = typeof entry.kind === "string" ? entry.kind : (this.store.scene?.constraints.find((own) => own.name === name)?.kind ?? "");
    const hold = Array.isArray(entry.hold) ? (entry.hold as string[]) : null;
    const set = (word: string, on: boolean) => {
      const now = new Set(hold ?? []);
      if (on) now.add(word);
      else now.delete(word);
      const words = HOLDS.filter((each) => now.has(each));
      this.send(words.length ? { is: "put", key: `${path}.hold`, value: words } : { is: "remove", key: `${path}.hold` });
    };
    this.part.replaceChildren(
      element("h3", {}, `Constraint ${name}`),
      this.name("constraint", name),
      this.choice("kind", kind, this.document!.constraint_kinds, (value) => this.send({ is: "put", key: `${path}.kind`, value })),
      element(
        "fieldset",
        {},
        element("legend", {}, hold ? "holds" : "holds what its kind holds; or:"),
        ...HOLDS.map((word) => this.flag(word, hold?.includes(word) ?? false, (on) => set(word, on))),
        this.flag("slides", entry.slide === true, (on) => this.send(on ? { is: "put", key: `${path}.slide`, value: true } : { is: "remove", key: `${path}.slide` })),
      ),
      this.value("position", found, "position"),
      this.value("tangent", found, "tangent"),
      this.value("pull-out force", found, "pull_out_force"),
      element("div", { class: "buttons" }, this.remove("constraint", name), this.inText(name)),
    );
  }

  private showObstacle(name: string): void {
    const there = list(this.entries.obstacles).some((own) => own.name === name);
    if (!there) return this.part.replaceChildren(element("p", { class: "quiet" }, `Obstacle ${name} is not in this text.`));
    const toFields = this.button("Its place and size", "Goes to its fields below", () => {
      this.obstacles.open = true;
      const entry = [...this.obstacles.querySelectorAll("li")].find((item) => item.dataset.name === name);
      entry?.querySelector("input")?.focus();
    });
    this.part.replaceChildren(
      element("h3", {}, `Obstacle ${name}`),
      element("p", { class: "quiet" }, "G shows arrows to move it, R rings to turn it; the arrow keys move it by 1 mm."),
      element("div", { class: "buttons" }, toFields, this.remove("obstacle", name), this.inText(name)),
    );
  }

  // Obstacles

  private showObstacles(): void {
    const all = list(this.entries.obstacles).filter((entry) => typeof entry.name === "string");
    const add = Object.keys(SHAPES).map((shape) =>
      this.button(`Add ${shape}`, `Adds a ${shape} beside the harness; then give its place and size`, () => {
        let name = shape;
        for (let k = 2; all.some((own) => own.name === name); k++) name = `${shape} ${k}`;
        this.send({ is: "add", list: "obstacles", entry: { name, shape, ...SHAPES[shape], position: this.beside() } });
      }),
    );
    const file = element("input", { type: "file", id: "build-surface", accept: SURFACE_ENDINGS });
    file.addEventListener("change", () => {
      const [chosen] = file.files ?? [];
      if (chosen) this.takeSurface(chosen);
      file.value = "";
    });
    add.push(element("label", { class: "setting" }, element("span", {}, "Add from a file"), element("span", { class: "field" }, file)));
    const form = (entry: Entry) => {
      const name = String(entry.name);
      const found = { entry, path: `obstacles.${quoted(name)}` };
      const shape = String(entry.shape ?? "mesh");
      return element(
        "li",
        { class: "entry", "data-name": name },
        element("strong", {}, name),
        element("span", { class: "quiet" }, ` ${shape}`),
        this.name("obstacle", name, `name of ${name}`),
        ...(shape === "mesh" ? ["mesh", "scale"] : Object.keys(SHAPES[shape] ?? {})).map((key) => this.value(`${key} of ${name}`, found, key)),
        this.value(`position of ${name}`, found, "position"),
        this.field(`angles of ${name}, °`, angles(entry.orientation), (text) => {
          const degrees = typed(text);
          const list = Array.isArray(degrees) && degrees.length === 3 && degrees.every((x) => typeof x === "number") ? (degrees as number[]) : null;
          if (text.trim() === "" && entry.orientation !== undefined) this.send({ is: "remove", key: `${found.path}.orientation` });
          // What is no list of three numbers is sent as it is, and refused with its reason.
          else this.send({ is: "put", key: `${found.path}.orientation`, value: list ? quaternion(list) : degrees });
        }, { title: "Rotated about the world's x, then y, then z" }),
        this.value(`least clearance of ${name}`, found, "min_clearance"),
        element("div", { class: "buttons" }, this.remove("obstacle", name), this.inText(name)),
      );
    };
    this.fill(this.obstacles, "obstacles", `Obstacles (${all.length})`, all.map(form), add);
  }

  /** A place beside the harness, clear of it in all frames that are here. */
  private beside(): number[] {
    const box = new THREE.Box3();
    const place = new THREE.Vector3();
    for (const { nodes } of this.store.kept()) for (let i = 0; i < nodes.length; i += FLOATS) box.expandByPoint(place.set(nodes[i], nodes[i + 1], nodes[i + 2]));
    if (box.isEmpty()) return [0, 0, 0];
    const middle = box.getCenter(new THREE.Vector3());
    return [middle.x, box.min.y - 0.25, middle.z].map((x) => rounded(x, 3));
  }

  // Requirements

  private showRequirements(): void {
    const all = list(this.entries.requirements).filter((entry) => typeof entry.name === "string");
    const quantities = (this.document?.quantities ?? []).map((word): [string, string] => [word, ""]);
    const form = (entry: Entry) => {
      const name = String(entry.name);
      const found = { entry, path: `requirements.${quoted(name)}` };
      return element(
        "li",
        { class: "entry" },
        element("strong", {}, name),
        element("span", { class: "quiet" }, ` ${shownPart(entry.of)}`),
        this.name("requirement", name, `name of ${name}`),
        this.choice(`quantity of ${name}`, String(entry.quantity ?? ""), quantities, (value) => this.send({ is: "put", key: `${found.path}.quantity`, value })),
        this.value(`least value of ${name}`, found, "min"),
        this.value(`greatest value of ${name}`, found, "max"),
        this.choice(`severity of ${name}`, String(entry.severity ?? "must"), [["must", ""], ["should", ""]], (value) => this.send({ is: "put", key: `${found.path}.severity`, value })),
        element("div", { class: "buttons" }, this.remove("requirement", name), this.inText(name)),
      );
    };
    const wanted = { name: "", quantity: "bend_radius", bound: "min", limit: "" };
    const add = [
      this.field("name of the new requirement", "", (value) => (wanted.name = value)),
      this.choice("its quantity", wanted.quantity, quantities, (value) => (wanted.quantity = value)),
      this.choice("bound", wanted.bound, [["min", "least value"], ["max", "greatest value"]], (value) => (wanted.bound = value)),
      this.field("its limit", "", (value) => (wanted.limit = value)),
      this.button("Add requirement", "Of the chosen branch or constraint; of everything, if none is chosen", () => {
        const of = this.chosenPart();
        this.send({ is: "add", list: "requirements", entry: { name: wanted.name, quantity: wanted.quantity, [wanted.bound]: typed(wanted.limit), ...(of ? { of } : {}) } });
      }),
    ];
    this.fill(this.requirements, "requirements", `Requirements of the text (${all.length})`, all.map(form), add);
  }

  private chosenPart(): Entry | null {
    const { chosen } = this.hands;
    if (chosen?.is === "constraint") return { constraint: chosen.name };
    return chosen?.is === "point" ? { branch: chosen.branch } : null;
  }

  private fill(details: HTMLDetailsElement, id: string, title: string, items: HTMLElement[], add: HTMLElement[]): void {
    details.id = `build-${id}`;
    details.replaceChildren(element("summary", {}, title), element("ul", {}, ...items), element("div", { class: "adding" }, ...add));
  }
}

/** What a requirement is about, in words. */
function shownPart(of: unknown): string {
  if (!of || typeof of !== "object") return "of every part that has it";
  return Object.entries(of as Entry).map(([key, value]) => `${key} ${shownAs(value)}`).join(", ");
}

const DEGREES = 180 / Math.PI;

/** A quaternion `[w, x, y, z]` as rotations about the world's x, then y, then z. */
function angles(orientation: unknown): string {
  if (!Array.isArray(orientation) || !orientation.every((x) => typeof x === "number")) return "";
  const [w, x, y, z] = orientation as number[];
  const euler = new THREE.Euler().setFromQuaternion(new THREE.Quaternion(x, y, z, w).normalize(), "ZYX");
  return [euler.x, euler.y, euler.z].map((angle) => rounded(angle * DEGREES, 3)).join(", ");
}

function quaternion([x, y, z]: number[]): number[] {
  const q = new THREE.Quaternion().setFromEuler(new THREE.Euler(x / DEGREES, y / DEGREES, z / DEGREES, "ZYX"));
  return [q.w, q.x, q.y, q.z].map((value) => rounded(value, 7));
}
