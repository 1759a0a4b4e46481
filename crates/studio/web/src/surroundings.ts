// Files with surfaces that are given to the page of a session: each is stored beside the scenario's file and becomes an obstacle.
import { typed } from "./build";
import { byId, element } from "./dom";
import { unitOf } from "./files";
import type { Hands } from "./hands";
import type { Link } from "./link";
import type { StoredMesh } from "./protocol";
import type { Store } from "./store";

/** Largest file that the program takes, bytes (crates/studio/src/server/surroundings.rs). */
const MOST = 256 * 1024 * 1024;
const UNITS: [string, string][] = [
  ["0.001", "a millimetre"],
  ["0.01", "a centimetre"],
  ["1", "a metre"],
  ["0.0254", "an inch"],
];

interface Wishes {
  /** Tells words that go by themselves. */
  tell: (words: string) => void;
  /** Asks for the name of the scenario's file. */
  saveAs: () => void;
  /** Shows everything, with what is chosen, as soon as it has its place. */
  fit: () => void;
}

export class Surroundings {
  private dialog = byId<HTMLDialogElement>("surroundings");
  private fault = element("p", { class: "bad", role: "alert" });
  private status = element("p", { class: "quiet", role: "status" });
  /** Files that wait until the scenario has a file, or until the one before is done. */
  private waiting: File[] = [];
  /** The obstacle that was asked for. */
  private asked: string | null = null;

  constructor(
    private store: Store,
    private hands: Hands,
    private link: Link,
    private wishes: Wishes,
  ) {
    store.on("scene", ({ obstacles }) => {
      const name = this.asked;
      if (name === null || !obstacles.some((own) => own.name === name)) return;
      this.dialog.close();
      this.hands.choose({ is: "obstacle", name });
      this.wishes.fit();
    });
    store.on("refused", ({ message, help }) => {
      if (this.asked === null) return;
      this.asked = null;
      this.refuse(help ? `${message}: ${help}` : message);
    });
    store.on("document", () => this.next());
    this.dialog.addEventListener("close", () => {
      this.asked = null;
      this.next();
    });
  }

  /** A file that was dropped or chosen. */
  take(file: File): void {
    if (file.size > MOST) return this.wishes.tell(`${file.name}: it has ${file.size} bytes; a page can be given at most ${MOST}. Put it into the folder of the scenario, and name it as mesh = "…" of an obstacle.`);
    this.waiting.push(file);
    if (this.store.document?.is_new) {
      this.wishes.tell(`${file.name} is stored beside the scenario, which has no file yet: save that first.`);
      this.wishes.saveAs();
    } else this.next();
  }

  private next(): void {
    const file = this.store.document?.is_new || this.dialog.open ? undefined : this.waiting.shift();
    if (file) this.ask(file);
  }

  private refuse(words: string): void {
    this.status.textContent = "";
    this.fault.textContent = words;
    for (const control of this.dialog.querySelectorAll("button")) control.disabled = false;
  }

  private ask(file: File): void {
    const unit = unitOf(file.name);
    const taken = new Set(this.store.scene?.obstacles.map(({ name }) => name));
    const stem = file.name.slice(0, file.name.lastIndexOf(".")) || "obstacle";
    let free = stem;
    for (let k = 2; taken.has(free); k++) free = `${stem} ${k}`;
    const name = element("input", { type: "text", id: "surroundings-name", autocomplete: "off", spellcheck: "false", value: free });
    const scale = element("select", { id: "surroundings-unit" }, ...UNITS.map(([value, words]) => element("option", { value, selected: value === unit }, words)));
    const position = element("input", { type: "text", id: "surroundings-position", autocomplete: "off", spellcheck: "false", value: "0, 0, 0" });
    const form = element(
      "form",
      {},
      element("h2", { id: "surroundings-title" }, `Surroundings: ${file.name}`),
      element("label", {}, "Name of the obstacle ", name),
      unit === null ? element("p", { class: "quiet" }, "A STEP file says its unit itself. It becomes one obstacle; “wireloom import step FILE -o DIR” makes one of each of its parts.") : element("label", {}, "A unit of the file is ", scale),
      element("label", {}, "Place of its origin ", position),
      element("p", { class: "quiet" }, "The file is stored beside the scenario's."),
      this.status,
      this.fault,
      element("p", { class: "row" }, element("button", { type: "submit", class: "strong" }, "Add"), element("button", { type: "button", onclick: () => this.dialog.close() }, "Cancel")),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const entry = { name: name.value.trim(), ...(unit === null || scale.value === "1" ? {} : { scale: Number(scale.value) }), position: typed(position.value) };
      void this.add(file, entry);
    });
    this.status.textContent = this.fault.textContent = "";
    this.dialog.replaceChildren(form);
    this.dialog.showModal();
    name.select();
  }

  private async add(file: File, entry: Record<string, unknown>): Promise<void> {
    for (const control of this.dialog.querySelectorAll("button")) control.disabled = control.type === "submit";
    this.fault.textContent = "";
    this.status.textContent = `Reading ${file.name}…`;
    let stored: StoredMesh;
    try {
      const answer = await fetch(`surroundings/${encodeURIComponent(file.name)}${location.search}`, { method: "POST", body: file });
      if (!answer.ok) return this.refuse((await answer.text()).trim().replaceAll("\n", ": "));
      stored = (await answer.json()) as StoredMesh;
    } catch (error) {
      return this.refuse(`${file.name} could not be sent: ${error instanceof Error ? error.message : String(error)}`);
    }
    if (!this.dialog.open) return this.wishes.tell(`${stored.file} stays beside the scenario.`);
    this.status.textContent = "Adding the obstacle…";
    this.asked = String(entry.name);
    const { name, ...rest } = entry;
    this.link.send({ do: "edit", edit: { is: "add", list: "obstacles", entry: { name, mesh: stored.file, ...rest, ...(stored.open ? { open: true } : {}) } } });
  }
}
