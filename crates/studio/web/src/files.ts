// Files that are given to the page: what their names say of them, and their texts.

/** Endings of files with surfaces, and what a unit of them mostly is, in m; null: the file says it itself. */
const SURFACES: Record<string, string | null> = { stl: "0.001", obj: "0.001", ply: "0.001", gltf: "1", glb: "1", step: null, stp: null };
const endingOf = (name: string) => name.slice(name.lastIndexOf(".") + 1).toLowerCase();

/** Endings of files with surfaces, as an input for files has them. */
export const SURFACE_ENDINGS = Object.keys(SURFACES).map((ending) => `.${ending}`).join(",");

/** Whether a file has a surface, which an obstacle can have. */
export const isSurface = (name: string): boolean => Object.hasOwn(SURFACES, endingOf(name));

/** What a unit of a file with a surface mostly is, in m; null: the file says it itself. */
export const unitOf = (name: string): string | null => SURFACES[endingOf(name)];

/** What is done with a file of another kind that is known; null for all others. */
export function ofOtherKind(name: string): string | null {
  const dropped = "a surface is an obstacle of a scenario: open one or begin a new harness, and drop the file there.";
  if (isSurface(name)) return unitOf(name) === null ? `${dropped} “wireloom import step FILE -o DIR” makes an obstacle of each part of a STEP file.` : dropped;
  if (/\.vec$/i.test(name)) return "the page imports KBL only: make a scenario of it with “wireloom import vec FILE -o NAME.toml”, and open that.";
  return null;
}

/** What is done with a file that is given to a page and that it cannot open; null for one that it can. `wanted`: what is opened. */
export function elsewhere(name: string, wanted = "a scenario (.toml) or a KBL file (.kbl, .xml)"): string | null {
  const other = ofOtherKind(name);
  if (other !== null) return other;
  if (isImported(name) || /\.toml$/i.test(name)) return null;
  return `${wanted} is wanted.`;
}

/** Whether it is a file that a scenario is made of. */
export const isImported = (name: string): boolean => /\.(kbl|xml)$/i.test(name);

/** The text of a file, or what is wrong with it. `most`: its largest size, bytes. */
export async function textOf(file: File, most: number): Promise<{ text: string } | { fault: string }> {
  if (file.size > most) return { fault: `it has ${file.size} bytes; a page can be given at most ${most}.` };
  try {
    return { text: new TextDecoder("utf-8", { fatal: true }).decode(await file.arrayBuffer()) };
  } catch {
    return { fault: "it is no UTF-8 text." };
  }
}
