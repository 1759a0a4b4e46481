// The sheet of requirements in words: what is worst, where, and whether the harness is acceptable.
import type { Place, Sheet, SheetLine, Stretch, Violation } from "./protocol";
import { millimetres, quantity } from "./units";

/** Measures of which a violation means that the cable is stretched, overloaded or in another one: the worst of all. */
const DESTROYED = new Set(["reach", "overlap", "tension", "compression", "strain"]);

export const isDestroyed = (measure: string): boolean => DESTROYED.has(measure);

const TITLES: Record<string, string> = { bend_radius: "bend radius", insertion_force: "insertion force", contact_force: "contact force", reach: "stretch", overlap: "overlap of cables" };
const title = (measure: string) => TITLES[measure] ?? measure;

/** What a requirement that fails means, in front of its numbers. */
const WORDS: Record<string, string> = {
  bend_radius: "too tight",
  reach: "over-stretched",
  overlap: "cables pass through each other",
  tension: "overloaded in tension",
  compression: "overloaded in compression",
  strain: "over-stretched, strain",
  clearance: "too near",
  slack: "too short",
};

/** Number of a measure with its unit. */
export function inUnit(measure: string, unit: string, value: number, significant = 3): string {
  if (measure === "reach") return `${quantity(value, "", significant)} × its length`;
  if (measure === "strain") return `${quantity(100 * value, "", significant)} %`;
  return quantity(value, unit, significant);
}

export const limitWords = (bound: string, measure: string, unit: string, limit: number): string => `${bound === "min" ? "at least" : "at most"} ${inUnit(measure, unit, limit)}`;

/** "trunk at s = 310 mm", "clip-1", "left at s = 20.0 mm and right at s = 40.0 mm". */
export function placeWords(place: Place): string {
  const on = (branch: string | null, s: number | null) => (branch === null ? [] : [s === null ? branch : `${branch} at s = ${millimetres(s, 3)}`]);
  const parts = [...(place.constraint === null ? [] : [place.constraint]), ...on(place.branch, place.s), ...on(place.other_branch, place.other_s), ...(place.obstacle === null ? [] : [place.obstacle])];
  return parts.join(" and ");
}

/** "too tight: 33.1 mm, at least 45.0 mm, on left at s = 20.0 mm". */
export function sentence(line: { measure: string; unit: string; bound: string; limit: number; place: Place }, value: number): string {
  const { measure, unit, bound, limit, place } = line;
  const where = placeWords(place);
  return `${WORDS[measure] ?? title(measure)}: ${inUnit(measure, unit, value)}, ${limitWords(bound, measure, unit, limit)}${where ? `; ${where}` : ""}`;
}

/** "bend radius 33.1 mm"; "bend radius" where nothing was checked. */
export const worstWords = (line: Pick<SheetLine, "measure" | "unit" | "worst">): string => (line.worst === null ? title(line.measure) : `${title(line.measure)} ${inUnit(line.measure, line.unit, line.worst)}`);

/** The order of the banner: what must be kept first, then what destroys cables, then the smallest margin. */
export function worstFirst(a: Violation | SheetLine, b: Violation | SheetLine): number {
  const rank = (line: Violation | SheetLine) => (line.severity === "must" ? 0 : 2) + (isDestroyed(line.measure) ? 0 : 1);
  return rank(a) - rank(b) || (a.margin ?? -1) - (b.margin ?? -1);
}

/** Whether a line keeps the verdict from being a pass. A limit of a part that never came into question does not. */
export const isOpen = (line: SheetLine): boolean => line.verdict === "fail" || line.verdict === "unresolved" || (line.verdict === "not checked" && line.origin === "scenario");

export const failing = (sheet: Sheet): SheetLine[] => sheet.lines.filter((line) => line.verdict === "fail");

/** The parts of branches that are stretched, overloaded or in another one in a frame. */
export const destroyed = (violations: Violation[]): Stretch[] => violations.filter((violation) => isDestroyed(violation.measure)).flatMap(({ stretches }) => stretches);

/** How far the run is, where it is not at its end. */
export const progress = (sheet: Sheet): string => (sheet.done < sheet.steps ? `${sheet.done} of ${sheet.steps} steps computed` : "");

/** The verdict in one line: "FAIL", "3 of 14 requirements fail". */
export function verdictWords(sheet: Sheet): { verdict: string; words: string } {
  const musts = sheet.lines.filter((line) => line.severity === "must");
  const count = (verdict: string) => musts.filter((line) => line.verdict === verdict).length;
  const open = progress(sheet);
  let how = "nothing fails so far";
  if (sheet.verdict === "fail") how = `${count("fail")} of ${musts.length} requirements fail`;
  else if (sheet.verdict === "pass") how = `${count("pass")} of ${musts.length} requirements pass${count("not checked") ? ", nothing to check for the others" : ""}`;
  else if (!open) how = `${musts.length - count("pass")} of ${musts.length} requirements undecided`;
  return { verdict: sheet.verdict.toUpperCase(), words: open ? `${how}; ${open}` : how };
}
