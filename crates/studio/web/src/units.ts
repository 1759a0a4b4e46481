// Numbers in words: lengths in mm (m from 10 m on), forces in N, moments in N mm or N m.

/** So many significant digits, no exponent between 1e-3 and 1e5, and a real minus sign. */
export function digits(value: number, significant = 3): string {
  if (!Number.isFinite(value)) return value > 0 ? "∞" : value < 0 ? "−∞" : "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text =
    size < 1e-3 || size >= 1e6
      ? value.toExponential(Math.max(0, significant - 1))
      : value.toFixed(Math.max(0, Math.min(6, significant - 1 - Math.floor(Math.log10(size)))));
  return text.replaceAll("-", "−");
}

export const millimetres = (metres: number, significant = 4): string =>
  Math.abs(metres) >= 10 ? `${digits(metres, significant)} m` : `${digits(metres * 1000, significant)} mm`;
/** What is below a millionth of what anybody feels is round-off. */
export const newtons = (value: number): string => `${digits(Math.abs(value) < 1e-6 ? 0 : value)} N`;
export const moment = (value: number): string =>
  Math.abs(value) < 1e-9 ? "0 N mm" : Math.abs(value) < 1 && value !== 0 ? `${digits(value * 1000)} N mm` : `${digits(value)} N m`;
export const seconds = (value: number): string =>
  value < 1e-3 ? `${digits(value * 1e6, 2)} µs` : value < 1 ? `${digits(value * 1e3)} ms` : `${digits(value)} s`;

/** 1, 2 or 5 times a power of ten: the greatest that is not above. */
export function niceBelow(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  const part = value / power;
  return power * (part >= 5 ? 5 : part >= 2 ? 2 : 1);
}
