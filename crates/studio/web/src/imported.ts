// What an import has found: a list whose places are flown to, and what became of the elements of the file.
import { element } from "./dom";
import type { Finding, Imported, Place } from "./protocol";
import { placeWords } from "./requirements";

/** Places of a finding that are shown without opening it. */
const SHOWN = 6;

export class ImportPane {
  readonly element = element("div", { id: "imported" });

  constructor(private goTo: (place: Place) => void) {}

  show({ name, findings, usage }: Imported): void {
    const unread = usage.filter((own) => own.not_read > 0).length;
    const head = ["element", "all", "used", "named", "other", "unread"];
    const rows = usage.map((own) => element("tr", {}, element("td", { title: own.kind }, own.kind), ...[own.total, own.used, own.kept, own.left_out, own.not_read].map((number) => element("td", {}, String(number)))));
    this.element.replaceChildren(
      element("p", { class: "quiet" }, findings.length === 0 ? `${name} has no irregularities.` : `Irregularities of ${name}, and their treatment:`),
      element("ul", { class: "long" }, ...findings.map((finding) => this.finding(finding))),
      element("details", {}, element("summary", {}, `Elements of the file${unread > 0 ? ` (${unread} kinds are not read, or not all)` : ""}`), element("p", { class: "quiet" }, "Used: the computation depends on them. Named: without effect. Other: of modules that are left out."), element("table", {}, element("thead", {}, element("tr", {}, ...head.map((words) => element("th", { scope: "col" }, words)))), element("tbody", {}, ...rows))),
    );
  }

  /** Words that lead to their place, where they have one. */
  private words(words: string, place: Place | null): HTMLElement {
    return element("li", {}, place ? element("button", { class: "plain", title: `Show ${placeWords(place)}`, onclick: () => this.goTo(place) }, words) : words);
  }

  private finding({ what, items, place }: Finding): HTMLElement {
    if (items.length === 0) return this.words(what, place);
    const places = element("ul", {}, ...items.map(({ words, place }) => this.words(words, place)));
    return element("li", {}, element("details", { open: items.length <= SHOWN }, element("summary", {}, items.length === 1 ? what : `${what} (${items.length})`), places));
  }
}
