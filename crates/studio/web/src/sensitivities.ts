// What it does to the requirements to move the chosen constraint by 1 mm. The server is asked whenever the newest shape rests.
import * as THREE from "three";
import { element } from "./dom";
import type { Hands } from "./hands";
import type { Link } from "./link";
import type { Place, Sensitivities, SensitivityLine } from "./protocol";
import { inUnit, worstWords } from "./requirements";
import type { Store } from "./store";
import { noise, quantity } from "./units";

/** How far the constraint is moved in what is shown, m. */
const MOVE = 1e-3;
/** Changes that count, as a fraction of the value or its limit. */
const COUNTS = 1e-3;
/** How long the shape rests before the server is asked, ms. */
const REST = 300;
/** Lines that are shown at once; the others on demand. */
const FEW = 6;
const AXES = ["x", "y", "z"];

export class SensitivityTable {
  readonly element = element("div", { id: "sensitivities" });
  /** What was asked for last: constraint, run and frame. */
  private asked = "";
  private timer = 0;

  constructor(
    private store: Store,
    private hands: Hands,
    private link: Link,
    private wishes: {
      goTo(place: Place): void;
      /** Shows the direction in which to move the constraint for a requirement; null: none. */
      point(better: { constraint: string; direction: THREE.Vector3; words: string } | null): void;
    },
  ) {
    const look = () => this.look();
    store.on("session", look);
    store.on("shown", look);
    hands.on("chosen", look);
    store.on("sensitivities", (found) => this.show(found));
  }

  /** The server may not have got the last question. */
  forget(): void {
    this.asked = "";
  }

  /** Asks anew where another shape, or another constraint, is there. */
  private look(): void {
    const wanted = this.wanted();
    if (wanted === this.asked) return;
    this.asked = "";
    this.element.replaceChildren();
    this.wishes.point(null);
    clearTimeout(this.timer);
    if (wanted === "") return;
    this.timer = window.setTimeout(() => {
      const constraint = this.hands.constraintName();
      if (constraint === null || this.wanted() !== wanted) return;
      this.asked = wanted;
      this.link.send({ do: "sensitivities", constraint });
    }, REST);
  }

  /** What there is to ask for; empty: nothing, or not now. */
  private wanted(): string {
    const { scene, session, shown } = this.store;
    const constraint = this.hands.constraint();
    const rests = session !== null && session.busy === null && !this.hands.dragging;
    if (!scene?.live || !shown || !rests || !constraint?.moves || !this.hands.at(constraint.name)) return "";
    const frame = shown.header.frame;
    return frame === this.store.newest() ? JSON.stringify([constraint.name, scene.run, frame]) : "";
  }

  private show(found: Sensitivities): void {
    // The answer to a question of before.
    if (this.asked === "" || found.constraint !== this.hands.constraintName()) return;
    if (found.reason !== null) {
      this.element.replaceChildren(element("p", { class: "quiet" }, `What moving it does is not known: ${found.reason}.`));
      return;
    }
    const least = (line: SensitivityLine) => Math.max(noise(line.unit), COUNTS * Math.max(Math.abs(line.value), Math.abs(line.limit)));
    const counts = (line: SensitivityLine) => line.by.flat().some((by) => by === null || Math.abs(by * MOVE) >= least(line));
    const all = found.lines.filter(counts);
    if (all.length === 0) {
      this.element.replaceChildren(element("p", { class: "quiet" }, "Moving it by 1 mm changes no requirement by 0.1 %."));
      return;
    }
    this.point(all[0]);
    const head = element("tr", {}, element("th", { scope: "col" }, "Moved by 1 mm"), ...AXES.map((axis) => element("th", { scope: "col" }, `+${axis}`)));
    const table = (lines: SensitivityLine[]) => element("table", {}, element("tbody", {}, ...lines.map((line) => this.line(line))));
    const first = table(all.slice(0, FEW));
    first.prepend(element("thead", {}, head));
    const rest = all.slice(FEW);
    const history = element("p", { class: "quiet" }, "With what has slipped or yielded as it is.");
    this.element.replaceChildren(first, ...(found.keeps_history ? [history] : []), ...(rest.length ? [element("details", {}, element("summary", {}, `${rest.length} more`), table(rest))] : []));
  }

  private line(line: SensitivityLine): HTMLElement {
    const value = `${worstWords({ ...line, worst: line.value })} now`;
    const name = element("button", { class: "plain", title: value, onclick: () => this.wishes.goTo(line.place) }, `${worstWords({ ...line, worst: null })}, ${line.name}`);
    name.addEventListener("focus", () => this.point(line));
    const row = element("tr", {}, element("th", { scope: "row" }, name), ...AXES.map((_, axis) => this.change(line, axis)));
    row.addEventListener("pointerenter", () => this.point(line));
    return row;
  }

  /** Shows where to move the constraint for this requirement, where that has derivatives. */
  private point(line: SensitivityLine): void {
    const constraint = this.hands.constraintName();
    const known = line.reasons.every((reason) => reason === null);
    const gradient = new THREE.Vector3(...line.by.map(([, above]) => above ?? 0));
    if (constraint === null || !known || gradient.length() * MOVE < noise(line.unit)) return this.wishes.point(null);
    const direction = gradient.normalize().multiplyScalar(line.bound === "min" ? 1 : -1);
    this.wishes.point({ constraint, direction, words: `better for ${worstWords({ ...line, worst: null })}, ${line.name}` });
  }

  private change(line: SensitivityLine, axis: number): HTMLElement {
    const [below, above] = line.by[axis];
    const reason = line.reasons[axis];
    // Towards smaller coordinates it is another value where there is no derivative.
    const back = reason === null ? "" : ` −${AXES[axis]}: ${below === null ? "?" : this.words(line, -below * MOVE)}. ${sentenceOf(reason)}`;
    if (above === null) return element("td", { title: back.trim() }, "?");
    const words = this.words(line, above * MOVE) + (reason === null ? "" : "*");
    if (words.startsWith("0")) return element("td", { title: back.trim() }, words);
    const helps = line.bound === "min" === above > 0;
    return element("td", { class: helps ? "good" : "bad", title: `${helps ? "Better" : "Worse"}.${back}` }, words);
  }

  private words(line: SensitivityLine, change: number): string {
    if (Math.abs(change) < noise(line.unit)) return "0";
    const size = line.measure === "reach" ? quantity(Math.abs(change), "", 2) : inUnit(line.measure, line.unit, Math.abs(change), 2);
    return `${change > 0 ? "+" : "−"}${size}`;
  }
}

const sentenceOf = (words: string) => `${words.charAt(0).toUpperCase()}${words.slice(1)}.`;
