// Plots along the arc length of a branch: bend radius (logarithmic, with its limit), forces, moments, strains.
import { inWords, QUANTITIES, type Quantity } from "./colours";
import { svg } from "./dom";
import { Column, firstNodes, sectionAt, type Frame } from "./frame";
import { FLOATS, type Branch, type Scene } from "./protocol";
import { digits, millimetres, noise } from "./units";

const [WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM] = [340, 92, 46, 18, 8, 14];

export class Plot {
  readonly element: SVGSVGElement;
  private curve = svg("path", { class: "curve" });
  private before = svg("path", { class: "before" });
  private limit = svg("path", { class: "limit" });
  private cursor = svg("line", { class: "cursor", y1: TOP, y2: HEIGHT - BOTTOM });
  private title = svg("text", { class: "title", x: LEFT, y: 12 });
  private reading = svg("text", { x: WIDTH - RIGHT, y: 12, "text-anchor": "end" });
  private low = svg("text", { x: LEFT - 4, y: HEIGHT - BOTTOM, "text-anchor": "end" });
  private high = svg("text", { x: LEFT - 4, y: TOP + 9, "text-anchor": "end" });
  private end = svg("text", { x: WIDTH - RIGHT, y: HEIGHT - 2, "text-anchor": "end" });
  private length = 1;

  constructor(
    private quantity: Quantity,
    point: (s: number, chosen: boolean) => void,
  ) {
    this.element = svg(
      "svg",
      { class: "plot", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img" },
      svg("rect", { class: "frame", x: LEFT, y: TOP, width: WIDTH - LEFT - RIGHT, height: HEIGHT - TOP - BOTTOM }),
      this.before,
      this.limit,
      this.curve,
      this.cursor,
      this.title,
      this.reading,
      this.low,
      this.high,
      svg("text", { x: LEFT, y: HEIGHT - 2 }, "s = 0"),
      this.end,
    );
    const at = (event: PointerEvent) => {
      const box = this.element.getBoundingClientRect();
      const x = ((event.clientX - box.left) / box.width) * WIDTH;
      return Math.min(1, Math.max(0, (x - LEFT) / (WIDTH - LEFT - RIGHT))) * this.length;
    };
    this.element.addEventListener("pointermove", (event) => point(at(event), false));
    this.element.addEventListener("click", (event) => point(at(event as PointerEvent), true));
  }

  /** A branch's values (`before`: of the ghost), and the place that is pointed at. */
  show(branch: Branch, nodes: Float32Array, before: Float32Array | null, pointed: { s: number; value: number } | null): void {
    this.length = branch.length;
    const radius = this.quantity.name === "bend";
    const column = this.quantity.column;
    const round = noise(this.quantity.unit);
    let [least, most] = [Infinity, -Infinity];
    for (const part of [nodes, before]) {
      for (let i = column; part && i < part.length; i += FLOATS) {
        const value = radius ? 1 / Math.max(part[i], 1e-9) : part[i];
        if (value < least) least = value;
        if (value > most) most = value;
      }
    }
    const parts = branch.sections.length > 0 ? branch.sections : [{ to: branch.length, bend_radius_limit: branch.bend_radius_limit }];
    const limits = radius ? parts.flatMap((part, k) => (part.bend_radius_limit === null ? [] : [{ from: k > 0 ? parts[k - 1].to : 0, to: part.to, limit: part.bend_radius_limit }])) : [];
    const lowest = Math.min(...limits.map(({ limit }) => limit));
    let [low, high] = [least, most];
    if (radius) {
      low = Math.min(least, lowest) / 1.3;
      high = Math.min(most, 30 * low);
    } else {
      low = Math.min(0, least);
      high = Math.max(0, most);
      if (high - low < round) high = low + round;
    }
    const y = (value: number) => {
      const part = radius ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
      return HEIGHT - BOTTOM - Math.min(1, Math.max(0, part)) * (HEIGHT - TOP - BOTTOM);
    };
    const path = (part: Float32Array) => {
      const n = part.length / FLOATS;
      const total = part[(n - 1) * FLOATS + Column.s] || 1;
      const step = Math.max(1, Math.floor(n / 500));
      let text = "";
      for (let i = 0; i < n; i = i + step < n || i === n - 1 ? i + step : n - 1) {
        const value = part[i * FLOATS + column];
        const x = LEFT + (part[i * FLOATS + Column.s] / total) * (WIDTH - LEFT - RIGHT);
        text += `${text ? "L" : "M"}${x.toFixed(1)} ${y(radius ? 1 / Math.max(value, 1e-9) : value).toFixed(1)}`;
      }
      return text;
    };
    this.curve.setAttribute("d", path(nodes));
    this.before.setAttribute("d", before ? path(before) : "");
    const across = (s: number) => (LEFT + (s / branch.length) * (WIDTH - LEFT - RIGHT)).toFixed(1);
    this.limit.setAttribute("d", limits.map(({ from, to, limit }) => `M${across(from)} ${y(limit).toFixed(1)}H${across(to)}`).join(""));
    const { unit, factor } = this.quantity.typed ?? { unit: "mm", factor: 1000 };
    const number = (value: number, significant = 3) => (radius && value > 1e3 ? "straight" : digits(Math.abs(value) < Math.max(round, 1e-6 * Math.max(high, -low)) ? 0 : value * factor, significant));
    const short = (value: number) => number(value, 2);
    this.low.textContent = short(low);
    this.high.textContent = (radius && most > high ? "> " : "") + short(high);
    this.end.textContent = millimetres(branch.length);
    this.title.textContent = radius ? `Bend radius, ${unit}` : `${this.quantity.label}, ${unit}`;
    this.cursor.setAttribute("visibility", pointed === null ? "hidden" : "visible");
    const allowed = [...new Set(limits.map(({ limit }) => number(limit)))].join(" or ");
    let words = radius ? `≥ ${number(least)}${allowed && `, allowed ${allowed}`}` : `${number(least)} … ${number(most)}`;
    const tooTight = (curvature: number, s: number) => radius && curvature * (sectionAt(branch, s).bend_radius_limit ?? 0) > 1;
    let over = false;
    for (let i = 0; i < nodes.length; i += FLOATS) over ||= tooTight(nodes[i + column], nodes[i + Column.s]);
    if (pointed !== null) {
      const x = LEFT + (pointed.s / branch.length) * (WIDTH - LEFT - RIGHT);
      for (const side of ["x1", "x2"]) this.cursor.setAttribute(side, x.toFixed(1));
      words = `${inWords(this.quantity, pointed.value)} at ${millimetres(pointed.s)}`;
      over = tooTight(pointed.value, pointed.s);
    }
    this.reading.textContent = words;
    this.reading.setAttribute("class", over ? "bad" : "");
    this.element.setAttribute("aria-label", `${this.title.textContent} along ${branch.name}: ${words}`);
  }
}

/** The numbers of one branch of a frame. */
export function nodesOf(scene: Scene, frame: Frame, branch: number): Float32Array {
  const first = firstNodes(scene);
  return frame.nodes.subarray(first[branch] * FLOATS, first[branch + 1] * FLOATS);
}

export const PLOTTED = QUANTITIES.filter((quantity) => quantity.name !== "clearance");
