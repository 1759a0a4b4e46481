// What the cable is coloured by, and the scales: all can be told apart by colour-blind eyes, and what is over a limit is hatched besides.
import { Column, type Frame } from "./frame";
import { FLOATS, type Scene } from "./protocol";
import { noise, quantity as inUnit } from "./units";

export type QuantityName = "bend" | "tension" | "torque" | "moment" | "stretch" | "surface" | "set" | "clearance";

export interface Quantity {
  name: QuantityName;
  label: string;
  column: number;
  /** Unit of its values, as `units.ts` has it; of a bend, that of its radius. */
  unit: string;
  /** Sign matters: the scale is symmetric, its middle is 0. */
  signed: boolean;
  /** What it is, where its name does not say that. */
  about?: string;
  /** Unit in which its range is typed; none: it has no range. */
  typed?: { unit: string; factor: number };
}

export const QUANTITIES: Quantity[] = [
  { name: "bend", label: "Bend radius against its limit", column: Column.curvature, unit: "m", signed: false },
  { name: "tension", label: "Tension", column: Column.tension, unit: "N", signed: false, typed: { unit: "N", factor: 1 } },
  { name: "torque", label: "Torque", column: Column.torque, unit: "N m", signed: true, typed: { unit: "N mm", factor: 1000 } },
  { name: "moment", label: "Bending moment", column: Column.moment, unit: "N m", signed: false, typed: { unit: "N mm", factor: 1000 } },
  { name: "stretch", label: "Stretch", column: Column.stretch, unit: "strain", signed: true, typed: { unit: "%", factor: 100 }, about: "Axial strain: positive where the cable is longer than unstressed." },
  { name: "surface", label: "Bending strain at the surface", column: Column.surface, unit: "strain", signed: false, typed: { unit: "%", factor: 100 }, about: "Half the diameter over the bend radius: strain of the sheath of a cable that is straight at rest. Wires that slip in it are strained less." },
  { name: "set", label: "Set", column: Column.set, unit: "rad/m", signed: false, typed: { unit: "rad/m", factor: 1 }, about: "Bend that would remain without a moment: wires have slipped on each other, the cable has yielded, or it has crept." },
  { name: "clearance", label: "Clearance", column: Column.clearance, unit: "m", signed: false, typed: { unit: "mm", factor: 1000 } },
];

/** viridis (van der Walt and Smith 2015, CC0), for what has a beginning. */
const VIRIDIS = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];
/** Blue to orange over grey, for what has two signs. */
const TWO_SIGNS = ["#0b4a8f", "#2f78b7", "#7fb0d6", "#d5dbe0", "#f0b57a", "#d9781f", "#9c4a04"];
export const OVER = "#e6007e";
export const UNKNOWN = "#8a9099";
/** Hatching of branches that are stretched, overloaded or in another one, whatever the scale. */
export const DESTROYED = ["#ff7a00", "#17100a"];
export const DESTROYED_WORDS = "over-stretched, overloaded or in another cable";

/** A scale of a quantity: what stands for 0 and for 1 of the colours. */
export interface Scale {
  quantity: Quantity;
  low: number;
  high: number;
  colours: string[];
  /** Whether "over" exists: bends beyond their limit, touching. */
  limited: boolean;
}

/** The least and greatest of every column, over all frames seen so far: a scale that stays while playing. */
export class Ranges {
  private low = new Float64Array(FLOATS).fill(Infinity);
  private high = new Float64Array(FLOATS).fill(-Infinity);

  clear(): void {
    this.low.fill(Infinity);
    this.high.fill(-Infinity);
  }

  /** Takes a frame in; whether a range grew. */
  take(frame: Frame): boolean {
    let grew = false;
    const n = frame.nodes;
    for (const { column } of QUANTITIES) {
      for (let i = column; i < n.length; i += FLOATS) {
        const value = n[i];
        if (value < this.low[column]) ((this.low[column] = value), (grew = true));
        if (value > this.high[column]) ((this.high[column] = value), (grew = true));
      }
    }
    return grew;
  }

  scale(quantity: Quantity, scene: Scene): Scale {
    const limits = scene.branches.some((branch) => branch.bend_radius_limit !== null);
    const greatest = this.high[quantity.column];
    const least = this.low[quantity.column];
    const known = Number.isFinite(greatest);
    // What is round-off has no range of its own.
    const round = noise(quantity.unit);
    const above = (value: number) => roundAbove(Math.max(value, 2 * round));
    const of = (low: number, high: number, colours: string[], limited: boolean): Scale => ({ quantity, low, high, colours, limited });
    switch (quantity.name) {
      case "bend":
        return limits ? of(0, 1, VIRIDIS, true) : of(0, known ? roundAbove(greatest) : 1, VIRIDIS, false);
      case "clearance":
        return of(0, known ? roundAbove(Math.min(0.1, Math.max(greatest, 1e-3))) : 0.1, VIRIDIS.slice().reverse(), true);
      default: {
        const unknown = quantity.typed ? 1 / quantity.typed.factor : 1;
        if (!quantity.signed) return of(known && least < -round ? -above(-least) : 0, known ? above(greatest) : unknown, VIRIDIS, false);
        const size = known ? above(Math.max(Math.abs(least), Math.abs(greatest))) : unknown;
        return of(-size, size, TWO_SIGNS, false);
      }
    }
  }
}

function roundAbove(value: number): number {
  if (!(value > 1e-9)) return 1e-9;
  const power = 10 ** Math.floor(Math.log10(value));
  for (const step of [1, 1.5, 2, 3, 4, 5, 6, 8, 10]) if (value <= step * power * (1 + 1e-9)) return step * power;
  return 10 * power;
}

/** Value of the nodes of branches that are stretched, overloaded or in another one. */
export const DESTROYED_VALUE = 3;

/** Where a node's value lies on the scale: 0 to 1; 2: over the limit; -1: not known. */
export function onScale(scale: Scale, value: number, limit: number | null): number {
  if (Number.isNaN(value)) return -1;
  if (scale.quantity.name === "bend" && scale.limited) {
    if (limit === null) return -1;
    const used = value * limit;
    return used > 1 ? 2 : used;
  }
  if (scale.quantity.name === "clearance" && value <= 0) return 2;
  const shown = Math.abs(value) < noise(scale.quantity.unit) ? 0 : value;
  return Math.min(1, Math.max(0, (shown - scale.low) / (scale.high - scale.low)));
}

/** What stands beside the scale: place from 0 to 1, and words. */
export function ticks(scale: Scale): { at: number; words: string }[] {
  if (scale.quantity.name === "bend" && scale.limited) {
    return [
      { at: 0, words: "straight" },
      { at: 0.25, words: "4 × limit" },
      { at: 0.5, words: "2 × limit" },
      { at: 0.75, words: "1.33 ×" },
      { at: 1, words: "limit" },
    ];
  }
  const places = [0, 0.25, 0.5, 0.75, 1];
  return places.map((at) => {
    const value = scale.low + at * (scale.high - scale.low);
    if (scale.quantity.name === "bend") return { at, words: value === 0 ? "straight" : inWords(scale.quantity, value) };
    return { at, words: Math.abs(value) < 1e-12 ? "0" : inWords(scale.quantity, value) };
  });
}

/** What the words beside the hatched patch are. */
export function overWords(scale: Scale): string {
  return scale.quantity.name === "clearance" ? "touching" : "tighter than allowed";
}

/** 256 colours of a scale as RGBA bytes, sRGB. */
export function table(colours: string[]): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(256 * 4);
  const parts = colours.map((colour) => [1, 3, 5].map((i) => Number.parseInt(colour.slice(i, i + 2), 16)));
  for (let i = 0; i < 256; i++) {
    const place = (i / 255) * (parts.length - 1);
    const low = Math.min(parts.length - 2, Math.floor(place));
    for (let c = 0; c < 3; c++) bytes[4 * i + c] = Math.round(parts[low][c] + (place - low) * (parts[low + 1][c] - parts[low][c]));
    bytes[4 * i + 3] = 255;
  }
  return bytes;
}

/** A value of a node in words, bend radii as such. */
export function inWords(quantity: Quantity, value: number): string {
  if (Number.isNaN(value)) return "not known";
  if (quantity.name === "bend") return value < 1e-3 ? "straight" : inUnit(1 / value, quantity.unit);
  return inUnit(value, quantity.unit);
}

