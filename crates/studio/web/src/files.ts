// Files that are given to the page: what their names say of them, and their texts.

/** What is done with a file of another kind that is known; null for all others. */
export function ofOtherKind(name: string): string | null {
  if (/\.(stl|obj|gltf|glb)$/i.test(name)) return "a mesh is an obstacle of a scenario: put it into the folder of the scenario, and name it as mesh = \"…\" of an obstacle.";
  if (/\.(step|stp)$/i.test(name)) return "parts of a STEP file are obstacles of a scenario: make them with “wireloom import step FILE -o DIR”.";
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
