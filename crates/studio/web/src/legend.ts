// The legend: what the cable is coloured by, and what the colours mean.
import { DESTROYED_WORDS, overWords, QUANTITIES, ticks, type Quantity, type QuantityName, type Scale } from "./colours";
import { byId, element } from "./dom";

export class Legend {
  private select = byId<HTMLSelectElement>("quantity");
  private holder = byId("scale");

  private low = element("input", { type: "text", id: "range-low", inputmode: "decimal", "aria-label": "Least value of the colours" });
  private high = element("input", { type: "text", id: "range-high", inputmode: "decimal", "aria-label": "Greatest value of the colours" });
  private row = element("div", { class: "row range", id: "range" }, this.low, "to", this.high, element("span", { id: "range-unit" }), element("button", { id: "range-auto", title: "Back to the range of what was computed", onclick: () => this.setRange(null) }, "Auto"));
  /** Ranges that were typed, in SI units, by quantity. */
  private ranges = new Map<QuantityName, { low: number; high: number }>();
  private shown: Quantity | null = null;

  constructor(
    chosen: (name: QuantityName) => void,
    private ranged: () => void,
  ) {
    this.holder.after(this.row);
    for (const input of [this.low, this.high]) input.addEventListener("change", () => this.read());
    for (const quantity of QUANTITIES) this.select.append(element("option", { value: quantity.name }, quantity.label));
    this.select.addEventListener("change", () => chosen(this.select.value as QuantityName));
  }

  /** The range that was typed for a quantity, if any. */
  range(quantity: Quantity): { low: number; high: number } | null {
    return this.ranges.get(quantity.name) ?? null;
  }

  private setRange(range: { low: number; high: number } | null): void {
    if (!this.shown) return;
    if (range) this.ranges.set(this.shown.name, range);
    else this.ranges.delete(this.shown.name);
    this.ranged();
  }

  private read(): void {
    const factor = this.shown?.typed?.factor ?? 1;
    const [low, high] = [this.low, this.high].map((input) => Number(input.value.trim().replace("−", "-").replace(",", ".")) / factor);
    const valid = Number.isFinite(low) && Number.isFinite(high) && low < high;
    for (const input of [this.low, this.high]) input.setCustomValidity(valid ? "" : "two numbers are wanted, the smaller one first");
    if (valid) this.setRange({ low, high });
    else this.high.reportValidity();
  }

  show(scale: Scale, unknown: boolean, destroyed: boolean): void {
    this.select.value = scale.quantity.name;
    this.shown = scale.quantity;
    const { typed } = scale.quantity;
    this.row.hidden = typed === undefined;
    if (typed) {
      const words = (value: number) => String(Number((value * typed.factor).toPrecision(4)));
      [this.low.value, this.high.value] = [words(scale.low), words(scale.high)];
      byId("range-unit").textContent = typed.unit;
    }
    const colours = element("div", { class: "colours" });
    colours.style.background = `linear-gradient(90deg, ${scale.colours.join(", ")})`;
    const words = ticks(scale);
    // Three of five have room.
    const row = element("div", { class: "ticks" }, ...words.filter((_, i) => i % 2 === 0).map((tick) => element("span", {}, tick.words)));
    const key = element("div", { class: "row key" });
    if (destroyed) key.append(element("span", {}, element("span", { class: "patch destroyed" }), DESTROYED_WORDS));
    if (scale.limited) key.append(element("span", {}, element("span", { class: "patch over" }), overWords(scale)));
    if (unknown) key.append(element("span", {}, element("span", { class: "patch unknown" }), scale.quantity.name === "bend" ? "no limit given" : "not known"));
    const { about } = scale.quantity;
    this.holder.replaceChildren(colours, row, key, ...(about ? [element("p", { class: "quiet" }, about)] : []));
  }
}
