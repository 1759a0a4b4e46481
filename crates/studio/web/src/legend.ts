// The legend: what the cable is coloured by, and what the colours mean.
import { DESTROYED_WORDS, overWords, QUANTITIES, ticks, type QuantityName, type Scale } from "./colours";
import { byId, element } from "./dom";

export class Legend {
  private select = byId<HTMLSelectElement>("quantity");
  private holder = byId("scale");

  constructor(chosen: (name: QuantityName) => void) {
    for (const quantity of QUANTITIES) this.select.append(element("option", { value: quantity.name }, quantity.label));
    this.select.addEventListener("change", () => chosen(this.select.value as QuantityName));
  }

  show(scale: Scale, unknown: boolean, destroyed: boolean): void {
    this.select.value = scale.quantity.name;
    const colours = element("div", { class: "colours" });
    colours.style.background = `linear-gradient(90deg, ${scale.colours.join(", ")})`;
    const words = ticks(scale);
    // Three of five have room.
    const row = element("div", { class: "ticks" }, ...words.filter((_, i) => i % 2 === 0).map((tick) => element("span", {}, tick.words)));
    const key = element("div", { class: "row key" });
    if (destroyed) key.append(element("span", {}, element("span", { class: "patch destroyed" }), DESTROYED_WORDS));
    if (scale.limited) key.append(element("span", {}, element("span", { class: "patch over" }), overWords(scale)));
    if (unknown) key.append(element("span", {}, element("span", { class: "patch unknown" }), scale.quantity.name === "bend" ? "no limit given" : "not known"));
    this.holder.replaceChildren(colours, row, key);
  }
}
