// The keyboard: one table, from which the help page is made.
import { byId, element } from "./dom";

export interface Key {
  /** As `KeyboardEvent.key` has it, "Ctrl+" and "Shift+" before it; several for the same. */
  keys: string[];
  words: string;
  act: (event: KeyboardEvent) => void;
  /** Needs a solver behind the page. */
  live?: boolean;
}

/** Listens to the page; keys typed into fields are left to them. */
export function listen(keys: Key[], live: () => boolean): void {
  const table = new Map(keys.flatMap((key) => key.keys.map((each) => [each, key] as const)));
  document.addEventListener("keydown", (event) => {
    if (event.defaultPrevented || document.querySelector("dialog[open], body.starting")) return;
    const target = event.target as HTMLElement;
    const control = event.ctrlKey || event.metaKey;
    const types = target.matches("select, textarea, input:not([type=range]):not([type=checkbox])") || target.matches(".text-holder");
    if (types && !(control && event.key.toLowerCase() === "s")) return;
    if (target.matches("input[type=range]") && event.key.startsWith("Arrow")) return;
    if (target.matches("button, summary, a") && (event.key === " " || event.key === "Enter")) return;
    const name = event.key.length === 1 && !control ? event.key.toLowerCase() : event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const shift = event.shiftKey && (event.key.length > 1 || control || /[a-z]/i.test(event.key));
    const key = table.get(`${control ? "Ctrl+" : ""}${event.altKey ? "Alt+" : ""}${shift ? "Shift+" : ""}${name}`);
    if (!key || (key.live && !live())) return;
    event.preventDefault();
    key.act(event);
  });
}

const SIGNS: Record<string, string> = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", " ": "Space", PageUp: "Page↑", PageDown: "Page↓" };
const shown = (key: string) => key.split(/\+(?=.)/).map((part) => SIGNS[part] ?? (part.length === 1 ? part.toUpperCase() : part)).join(" ");

/** The help page. */
export function help(keys: Key[], live: boolean): void {
  const dialog = byId<HTMLDialogElement>("keys");
  const rows = keys
    .filter((key) => live || !key.live)
    .map((key) => element("div", {}, element("span", {}, ...key.keys.flatMap((each, i) => [i ? " " : "", element("kbd", {}, shown(each))])), element("span", {}, key.words)));
  dialog.replaceChildren(
    element("h2", { id: "keys-title" }, "Keys and mouse"),
    element(
      "p",
      { class: "quiet" },
      live
        ? "Drag a plug, a clip, a handle or any point of a cable to move it. Drag the background to rotate the view, or with the right button to shift it; use the wheel to zoom."
        : "This is a finished run: click a cable or a constraint for details. Drag to rotate the view, or with the right button to shift it; use the wheel to zoom.",
    ),
    element("div", { class: "columns" }, ...rows),
    element("p", {}, element("button", { class: "strong", onclick: () => dialog.close() }, "Close")),
  );
  dialog.showModal();
}
