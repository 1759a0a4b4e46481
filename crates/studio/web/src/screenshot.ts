// The picture as PNG: what is drawn, with the words over it, the scale of colours and what it is a picture of.
import { DESTROYED_WORDS, overWords, ticks, type Scale } from "./colours";
import type { View } from "./view";

/** Draws it; `title` stands in the upper left corner, and the verdict (a word and its class) below it. */
export function screenshot(view: View, scale: Scale | null, title: string, verdict: { words: string; is: string } | null, destroyed: boolean): Promise<Blob> {
  const source = view.picture();
  const canvas = document.createElement("canvas");
  canvas.width = source.width;
  canvas.height = source.height;
  const paper = canvas.getContext("2d")!;
  const style = getComputedStyle(document.body);
  const rem = Number.parseFloat(getComputedStyle(document.documentElement).fontSize);
  paper.drawImage(source, 0, 0);
  paper.scale(source.width / view.width, source.height / view.height);
  paper.textBaseline = "middle";
  const write = (words: string, x: number, y: number, colour: string, bold = false) => {
    paper.font = `${bold ? "600 " : ""}${0.9 * rem}px ${style.fontFamily}`;
    paper.fillStyle = colour;
    paper.fillText(words, x, y);
  };
  for (const label of document.querySelectorAll<HTMLElement>("#labels > :not([hidden])")) {
    const at = new DOMMatrix(label.style.transform);
    const own = getComputedStyle(label);
    paper.fillStyle = own.backgroundColor;
    paper.fillRect(at.e, at.f, label.offsetWidth, label.offsetHeight);
    write(label.textContent ?? "", at.e + 0.35 * rem, at.f + label.offsetHeight / 2, own.color, own.fontWeight === "600");
  }
  write(title, rem, 1.2 * rem, style.color, true);
  if (verdict) {
    const colour = getComputedStyle(document.querySelector(`.verdict.${verdict.is}`)!);
    paper.font = `600 ${0.9 * rem}px ${style.fontFamily}`;
    paper.fillStyle = colour.backgroundColor;
    paper.fillRect(0.6 * rem, 2 * rem, paper.measureText(verdict.words).width + 0.8 * rem, 1.4 * rem);
    write(verdict.words, rem, 2.7 * rem, colour.color, true);
  }
  if (scale) {
    const [x, y, width] = [rem, view.height - 2.4 * rem, 16 * rem];
    const colours = paper.createLinearGradient(x, 0, x + width, 0);
    scale.colours.forEach((colour, i) => colours.addColorStop(i / (scale.colours.length - 1), colour));
    if (destroyed) write(`orange and black: ${DESTROYED_WORDS}`, x, y - 2.2 * rem, style.color);
    write(scale.quantity.label + (scale.limited ? ` (hatched: ${overWords(scale)})` : ""), x, y - 0.9 * rem, style.color);
    paper.fillStyle = colours;
    paper.fillRect(x, y, width, 0.7 * rem);
    for (const { at, words } of ticks(scale).filter((_, i) => i % 2 === 0)) {
      paper.textAlign = at === 0 ? "left" : at === 1 ? "right" : "center";
      write(words, x + at * width, y + 1.5 * rem, style.color);
    }
  }
  return new Promise((resolve, reject) => canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("no picture"))), "image/png"));
}
