// Words over the picture: names of things, sizes of forces, the triad of axes, a bar of known length. Text only.
import * as THREE from "three";
import type { Bodies } from "./bodies";
import { byId, element, svg } from "./dom";
import { niceBelow } from "./units";
import type { View } from "./view";

export class Labels {
  shown = true;
  private holder = byId("labels");
  private pool: HTMLElement[] = [];
  private triad = byId<SVGSVGElement>("triad");
  private rem = 14;
  private bar = byId("bar");
  private barWords = byId("bar-words");

  constructor(
    private view: View,
    private bodies: Bodies,
  ) {
    view.before.push(() => this.update());
  }

  private update(): void {
    this.drawTriad();
    this.drawBar();
    this.rem = Number.parseFloat(getComputedStyle(document.documentElement).fontSize);
    const wanted: { place: THREE.Vector3; words: string; kind: string; first: number }[] = [];
    if (this.shown) {
      for (const body of this.bodies.bodies) {
        if (!body.acts) continue;
        const chosen = body.name === this.bodies.chosen;
        wanted.push({ place: body.object.position, words: body.words, kind: chosen ? "chosen" : body.kind, first: chosen ? 0 : body.kind === "constraint" ? 1 : 3 });
      }
      for (const arrow of this.bodies.arrowLabels) wanted.push({ ...arrow, first: arrow.kind === "better" ? 0 : 2 });
    }
    wanted.sort((a, b) => a.first - b.first);
    const taken: [number, number, number, number][] = [];
    let used = 0;
    for (const { place, words, kind } of wanted) {
      const at = this.view.toScreen(place);
      if (at.z > 1 || at.x < 0 || at.y < 0 || at.x > this.view.width || at.y > this.view.height) continue;
      const width = this.rem * (0.55 * words.length + 0.7);
      const [x, y] = [Math.min(at.x + 0.8 * this.rem, this.view.width - width), Math.max(at.y - 1.9 * this.rem, 2)];
      const box: [number, number, number, number] = [x, y, x + width, y + 1.35 * this.rem];
      if (taken.some((other) => box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3])) continue;
      taken.push(box);
      let label = this.pool[used];
      if (!label) this.holder.append((label = this.pool[used] = element("span")));
      used++;
      if (label.textContent !== words) label.textContent = words;
      if (label.className !== `label ${kind}`) label.className = `label ${kind}`;
      label.hidden = false;
      label.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    }
    for (; used < this.pool.length; used++) this.pool[used].hidden = true;
  }

  private drawTriad(): void {
    const axes: [string, THREE.Vector3, string][] = [
      ["X", new THREE.Vector3(1, 0, 0), "#d1470f"],
      ["Y", new THREE.Vector3(0, 1, 0), "#2a8f4e"],
      ["Z", new THREE.Vector3(0, 0, 1), "#2867c9"],
    ];
    const [right, up, towards] = this.view.axes();
    const parts = axes
      .map(([name, axis, colour]) => ({ name, colour, x: axis.dot(right), y: -axis.dot(up), z: axis.dot(towards) }))
      .sort((a, b) => a.z - b.z);
    this.triad.replaceChildren(
      ...parts.flatMap(({ name, colour, x, y }) => [
        svg("line", { x1: 40, y1: 40, x2: 40 + 26 * x, y2: 40 + 26 * y, stroke: colour, "stroke-width": 3, "stroke-linecap": "round" }),
        svg("text", { x: 40 + 34 * x, y: 44 + 34 * y, "text-anchor": "middle", class: "axis" }, name),
      ]),
    );
  }

  private drawBar(): void {
    const per = this.view.metresPerPixel(this.view.controls.target);
    const length = niceBelow(140 * per);
    this.bar.style.width = `${(length / per).toFixed(1)}px`;
    const words = (metres: number) => (metres >= 1 ? `${Number(metres.toPrecision(1))} m` : `${Number((metres * 1000).toPrecision(1))} mm`);
    this.barWords.textContent = `${words(length)} · grid ${words(this.view.spacing)}`;
  }
}
