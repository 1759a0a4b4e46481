// The start page: recent files, examples, a new harness, and files that are given to it. It is shown until a session is opened.
import { byId, element } from "./dom";
import { faultWords, MOST } from "./editor";
import { elsewhere, isImported, ofOtherKind, textOf } from "./files";
import type { Link, LinkState } from "./link";
import type { Arranged, Contents, ImportFile, NotOpened, OfferedDraft, Opening, StartPage } from "./protocol";
import type { Store } from "./store";
import { when } from "./units";

/** Proposed length of the longest segment, mm. */
const SPACING = "10";

const ARRANGEMENTS: [Arranged, string][] = [
  ["installed", "in the vehicle, as drawn"],
  ["board", "flat on a formboard"],
  ["assembly", "from the board into the vehicle, step by step"],
];

/** The last part of a path, and what stands before it. */
function nameAndFolder(path: string): { name: string; folder: string } {
  const at = Math.max(path.lastIndexOf("/"), path.lastIndexOf("\\"));
  return { name: path.slice(at + 1), folder: path.slice(0, Math.max(at, 0)) };
}

/** Drafts of earlier sessions, each to be restored or discarded. */
export function offers(drafts: OfferedDraft[], words: string, answer: (number: number, take: boolean) => void): HTMLElement[] {
  return drafts.map(({ number, written }) => {
    const of = `that of ${when(written)}`;
    return element(
      "div",
      { class: "row" },
      element("span", {}, `${words} (${when(written)}).`),
      element("button", { onclick: () => answer(number, true), title: `Restores ${of}` }, "Restore it"),
      element("button", { onclick: () => answer(number, false), title: `Discards ${of}` }, "Discard it"),
    );
  });
}

export class StartPane {
  private holder = byId("start");
  /** What can be done: inert while something is being opened or the server is away. */
  private body = element("div", { class: "start-body" });
  private status = element("p", { id: "start-status", role: "status" });
  private fault = element("div", { id: "not-opened", role: "alert", tabindex: "-1", hidden: true });
  private draft = element("div", { id: "start-draft", class: "notice", role: "status", hidden: true });
  private choices = element("div", { class: "start-choices" });
  private recent = element("ul", { "aria-labelledby": "recent-title" });
  private examples = element("ul", { "aria-labelledby": "examples-title" });
  private folder = element("span", { class: "quiet" });
  private path = element("input", { id: "start-path", type: "text", autocomplete: "off", spellcheck: "false" });
  private file = element("input", { id: "start-file", type: "file", accept: ".toml,.kbl,.xml" });
  private kbl = element("div", { id: "kbl", hidden: true });
  private waiting: string | null = null;
  /** Largest file to be imported that the program takes, bytes; none is taken before it has said that. */
  private largestImport = 0;
  private link: LinkState = "connecting";

  constructor(
    store: Store,
    private connection: Link,
  ) {
    const open = element("form", { id: "start-open" }, element("label", { for: "start-path" }, "Path of a scenario, a KBL file, or the folder of a run"), element("div", { class: "row" }, this.path, element("button", { type: "submit" }, "Open")), element("p", { class: "quiet" }, "Paths begin in ", this.folder, "; what has no file yet is saved there."));
    open.addEventListener("submit", (event) => {
      event.preventDefault();
      this.openPath(this.path.value.trim());
    });
    this.file.addEventListener("change", () => {
      const [chosen] = this.file.files ?? [];
      if (chosen) void this.take(chosen);
      this.file.value = "";
    });
    this.choices.append(
      element(
        "section",
        { "aria-labelledby": "open-title" },
        element("h2", { id: "open-title" }, "Open"),
        element("div", { class: "drop" }, element("label", { for: "start-file" }, "Drop a scenario (.toml) or a KBL file (.kbl, .xml) here, or choose it:"), this.file),
        open,
        element("h2", {}, "Begin"),
        element("p", {}, element("button", { id: "start-new", class: "strong", onclick: () => this.open({ is: "new" }, "a new harness") }, "New harness"), element("span", { class: "quiet" }, " one cable between two connectors")),
      ),
      element("section", {}, element("h2", { id: "recent-title" }, "Recent files"), this.recent),
      element("section", {}, element("h2", { id: "examples-title" }, "Examples"), this.examples),
    );
    this.body.append(this.draft, this.kbl, this.choices);
    this.holder.append(this.status, this.fault, this.body);
    store.on("start_page", (page) => this.show(page));
    store.on("contents", (contents) => this.showContents(contents));
    store.on("not_opened", (why) => this.refuse(why));
    store.on("scene", () => this.leave());
  }

  get isShown(): boolean {
    return !this.holder.hidden;
  }

  /** The connection comes and goes. */
  setLink(state: LinkState): void {
    this.link = state;
    this.waiting = null;
    this.showStatus();
  }

  private show(page: StartPage): void {
    document.title = "Wireloom studio";
    document.body.classList.add("starting");
    this.holder.hidden = false;
    this.folder.textContent = page.folder;
    this.largestImport = page.largest_import;
    this.draft.hidden = page.drafts.length === 0;
    const answer = (number: number, take: boolean) => {
      if (take) this.wait("Opening the unsaved harness…");
      this.connection.send({ do: "draft", number, take });
    };
    this.draft.replaceChildren(...offers(page.drafts, "A harness without a file was not saved", answer));
    const entries = page.recent.map(({ path, opened, gone }) => {
      const { name, folder } = nameAndFolder(path);
      const details = element("span", { class: "quiet" }, [gone ? "gone:" : "", folder, opened === null ? "" : `(${when(opened)})`].filter((words) => words !== "").join(" "));
      const title = gone ? element("s", { title: path }, name) : element("button", { class: "plain", title: path, onclick: () => this.open({ is: "path", path }, path) }, name);
      return element("li", {}, title, details);
    });
    this.recent.replaceChildren(...(entries.length > 0 ? entries : [element("li", { class: "quiet" }, "none yet")]));
    this.examples.replaceChildren(...page.examples.map(({ name, title }) => element("li", {}, element("button", { class: "plain", onclick: () => this.open({ is: "example", name }, name) }, title), element("span", { class: "quiet" }, name))));
    this.waiting = null;
    this.showStatus();
  }

  private leave(): void {
    document.body.classList.remove("starting");
    this.holder.hidden = true;
  }

  private openPath(path: string): void {
    if (path === "") return this.refuse({ message: "There is no path to open.", help: "give the path of a scenario, such as harness.toml", faults: [] });
    // The name of a folder may end in anything: the program says what else is no scenario and no run.
    const other = ofOtherKind(path);
    if (other !== null) return this.refuse({ message: `${path}: ${other}`, help: "", faults: [] });
    if (isImported(path)) this.askContents({ from: "path", path }, path);
    else this.open({ is: "path", path }, path);
  }

  /** A file that was dropped or chosen. */
  async take(file: File): Promise<void> {
    if (this.body.inert) return;
    const { name } = file;
    const refuse = (words: string, help = "") => this.refuse({ message: `${name}: ${words}`, help, faults: [] });
    const other = elsewhere(name);
    if (other !== null) return refuse(other);
    const read = await textOf(file, isImported(name) ? this.largestImport : MOST);
    if ("fault" in read) return refuse(read.fault, "a larger file is opened by its path");
    if (isImported(name)) this.askContents({ from: "text", name, text: read.text }, name);
    else this.open({ is: "text", name, text: read.text }, name);
  }

  private open(what: Opening, words: string): void {
    this.wait(`Opening ${words}…`);
    this.connection.send({ do: "open", what });
  }

  private askContents(file: ImportFile, words: string): void {
    this.asked = file;
    this.wait(`Reading ${words}…`);
    this.connection.send({ do: "contents", file });
  }

  /** The file whose modules were asked for. */
  private asked: ImportFile | null = null;

  private wait(words: string): void {
    this.fault.hidden = true;
    this.waiting = words;
    this.showStatus();
  }

  private showStatus(): void {
    const away = { connecting: "Connecting…", open: null, lost: "The connection to the program is lost: trying again…", ended: "The program has ended. Start “wireloom studio” again: it opens a new page.", replay: null }[this.link];
    this.body.inert = away !== null || this.waiting !== null;
    this.status.textContent = away ?? this.waiting ?? "";
    this.status.hidden = this.status.textContent === "";
  }

  private refuse({ message, help, faults }: NotOpened): void {
    this.waiting = null;
    this.showStatus();
    this.fault.hidden = false;
    const list = faults.map((fault) => element("li", {}, element("span", {}, faultWords(fault)), element("span", { class: "quiet" }, fault.help)));
    this.fault.replaceChildren(element("div", {}, element("p", {}, message), help !== "" && element("p", { class: "quiet" }, help), list.length > 0 && element("ul", {}, ...list)));
    this.fault.focus();
  }

  // A KBL file

  private showContents({ name, modules, variants }: Contents): void {
    const file = this.asked;
    if (!file) return;
    this.waiting = null;
    this.showStatus();
    const boxes = modules.map((module) => ({ name: module.name, box: element("input", { type: "checkbox", checked: true }) }));
    const count = element("span", { class: "quiet", role: "status" });
    const submit = element("button", { type: "submit", class: "strong" }, "Import");
    const counted = () => {
      const chosen = boxes.filter(({ box }) => box.checked).length;
      count.textContent = boxes.length === 0 ? "" : `${chosen} of ${boxes.length} modules`;
      submit.disabled = boxes.length > 0 && chosen === 0;
    };
    const choose = (chosen: (name: string) => boolean) => {
      for (const { name, box } of boxes) box.checked = chosen(name);
      counted();
    };
    const variant = element("select", { id: "kbl-variant" }, element("option", { value: "" }, "choose…"), ...variants.map(([name]) => element("option", { value: name }, name)));
    variant.addEventListener("change", () => {
      const of = variants.find(([name]) => name === variant.value)?.[1];
      if (of) choose((name) => of.includes(name));
    });
    const rows = modules.map((module, k) => {
      const words = [module.description, module.option_code, module.parts === 1 ? "1 part" : `${module.parts} parts`].filter((part) => part !== null);
      return element("label", {}, boxes[k].box, element("span", {}, module.name), element("span", { class: "quiet" }, words.join(", ")));
    });
    for (const { box } of boxes) box.addEventListener("change", counted);
    const spacing = element("input", { id: "kbl-spacing", type: "number", min: "0.1", max: "1000", step: "any", value: SPACING });
    const arrangement = element("select", { id: "kbl-arrangement" }, ...ARRANGEMENTS.map(([value, words]) => element("option", { value }, words)));
    const leave = () => {
      this.kbl.hidden = true;
      this.choices.hidden = false;
    };
    const form = element(
      "form",
      {},
      element("h2", { tabindex: "-1" }, `Import ${name}`),
      modules.length === 0
        ? element("p", { class: "quiet" }, "The harness has no modules: all of it is taken.")
        : element(
            "fieldset",
            {},
            element("legend", {}, "Modules"),
            element("div", { class: "row" }, element("button", { type: "button", onclick: () => choose(() => true) }, "All"), element("button", { type: "button", onclick: () => choose(() => false) }, "None"), variants.length > 0 && element("label", { class: "row" }, "as in variant ", variant), count),
            element("div", { class: "modules" }, ...rows),
          ),
      element("div", { class: "start-fields" }, element("label", { for: "kbl-spacing" }, "Longest segment, mm"), element("div", {}, spacing, element("span", { class: "quiet" }, " empty: as an accuracy of 2 % needs it")), element("label", { for: "kbl-arrangement" }, "The harness is"), arrangement),
      element("p", { class: "row" }, submit, element("button", { type: "button", onclick: leave }, "Cancel")),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const chosen = boxes.filter(({ box }) => box.checked).map(({ name }) => name);
      const what: Opening = { is: "kbl", file, modules: chosen.length === boxes.length ? null : chosen, spacing: spacing.value === "" ? null : Number(spacing.value) / 1000, arrangement: arrangement.value as Arranged };
      this.open(what, name);
    });
    counted();
    this.choices.hidden = true;
    this.kbl.hidden = false;
    this.kbl.replaceChildren(form);
    form.querySelector("h2")!.focus();
  }
}
