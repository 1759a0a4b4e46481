// Numbers in words: a few significant digits, never an exponent, and 0 for what is below anything that can be measured. All numbers with
// a unit on the page pass through `quantity` or `components`.

interface Shown {
  unit: string;
  /** How many of these are one of the SI unit. */
  factor: number;
}

/** By SI unit: what is round-off, in that unit; and how a size is shown. */
const UNITS: Record<string, { noise: number; shown: (size: number) => Shown }> = {
  m: { noise: 5e-7, shown: (size) => (size >= 10 ? { unit: "m", factor: 1 } : { unit: "mm", factor: 1000 }) },
  N: { noise: 5e-5, shown: () => ({ unit: "N", factor: 1 }) },
  "N m": { noise: 5e-8, shown: (size) => (size >= 1 ? { unit: "N m", factor: 1 } : { unit: "N mm", factor: 1000 }) },
  J: { noise: 5e-7, shown: (size) => (size >= 1 ? { unit: "J", factor: 1 } : { unit: "mJ", factor: 1000 }) },
  s: { noise: 0, shown: (size) => (size < 1e-3 ? { unit: "µs", factor: 1e6 } : size < 1 ? { unit: "ms", factor: 1000 } : { unit: "s", factor: 1 }) },
  "rad/m": { noise: 5e-5, shown: () => ({ unit: "rad/m", factor: 1 }) },
  strain: { noise: 5e-7, shown: () => ({ unit: "%", factor: 100 }) },
  turns: { noise: 5e-5, shown: () => ({ unit: "turns", factor: 1 }) },
};
const PURE = { noise: 5e-7, shown: () => ({ unit: "", factor: 1 }) };

const of = (unit: string) => UNITS[unit] ?? { ...PURE, shown: () => ({ unit, factor: 1 }) };

/** Decimals with which a number of this size has so many significant digits: 6 at most. */
const decimals = (size: number, significant: number) => Math.max(0, Math.min(6, significant - 1 - Math.floor(Math.log10(size))));

/** A real minus sign, and thin spaces between thousands from five digits on. */
function typeset(text: string): string {
  const [whole, rest] = text.replace("-", "−").split(".");
  const grouped = whole.replace(/\D/, "").length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, "\u2009") : whole;
  return rest === undefined ? grouped : `${grouped}.${rest}`;
}

/** So many significant digits, as far as six decimals have them. */
export function digits(value: number, significant = 3): string {
  if (!Number.isFinite(value)) return value > 0 ? "∞" : value < 0 ? "−∞" : "–";
  const size = Math.abs(value);
  if (size < 5e-7) return "0";
  const text = value.toFixed(decimals(size, significant));
  return Number(text) === 0 ? "0" : typeset(text);
}

/** What is round-off in an SI unit. */
export const noise = (unit: string): number => of(unit).noise;

/** A number of an SI unit (m, N, N m, J, s, rad/m, turns; strain; empty for a pure number) in words. */
export function quantity(value: number, unit: string, significant = 3): string {
  const { noise: least, shown } = of(unit);
  const size = Math.abs(value);
  const { unit: name, factor } = shown(size < least ? 0 : size);
  const text = digits(size < least ? 0 : value * factor, significant);
  return name ? `${text} ${name}` : text;
}

/** The components of a vector, with as many decimals as the largest one has: what the others have beyond them is noise beside it. */
export function components(values: number[], unit: string, significant = 3): string {
  const { noise: least, shown } = of(unit);
  const size = Math.max(...values.map(Math.abs));
  const { unit: name, factor } = shown(size < least ? 0 : size);
  const places = size < least ? 0 : decimals(size * factor, significant);
  const text = values.map((value) => {
    const fixed = (Math.abs(value) < least ? 0 : value * factor).toFixed(places);
    return Number(fixed) === 0 ? "0" : typeset(fixed);
  });
  return `(${text.join(", ")}) ${name}`;
}

export const millimetres = (metres: number, significant = 4): string => quantity(metres, "m", significant);
export const newtons = (value: number): string => quantity(value, "N");
export const moment = (value: number): string => quantity(value, "N m");
export const seconds = (value: number): string => quantity(value, "s", value < 1e-3 ? 2 : 3);

/** A relative residual: its order of magnitude is all that counts. */
export const residual = (value: number): string => (value === 0 ? "0" : Number.isFinite(value) ? `10${superscript(Math.ceil(Math.log10(value) - 1e-9))}` : "not a number");

function superscript(power: number): string {
  return String(power).replace(/[-\d]/g, (sign) => (sign === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(sign)]));
}

/** A ratio as percent, with its sign. */
export const percent = (ratio: number): string => {
  const text = digits(Math.abs(100 * ratio), Math.abs(ratio) < 0.1 ? 2 : 3);
  return `${text === "0" ? "" : ratio < 0 ? "−" : "+"}${text} %`;
};

/** 1, 2 or 5 times a power of ten: the greatest that is not above. */
export function niceBelow(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  const part = value / power;
  return power * (part >= 5 ? 5 : part >= 2 ? 2 : 1);
}

/** A time as people here write it. */
export function when(time: string): string {
  const date = new Date(time);
  return Number.isNaN(date.getTime()) ? time : date.toLocaleString();
}
