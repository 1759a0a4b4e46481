// The text of the scenario beside the picture: what is typed is checked as it is typed, and carried out when it is applied. What hands and
// panels change comes into the text, also while it is being edited, as long as the two do not change the same place.
import { autocompletion, type CompletionContext, type CompletionResult } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap, indentWithTab } from "@codemirror/commands";
import { bracketMatching, HighlightStyle, StreamLanguage, syntaxHighlighting, syntaxTree } from "@codemirror/language";
import { toml } from "@codemirror/legacy-modes/mode/toml";
import { lintGutter, setDiagnostics, type Diagnostic } from "@codemirror/lint";
import { highlightSelectionMatches, search, searchKeymap } from "@codemirror/search";
import { Annotation, ChangeSet, EditorState, Text, Transaction } from "@codemirror/state";
import { drawSelection, EditorView, highlightActiveLine, highlightActiveLineGutter, keymap, lineNumbers } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import { element } from "./dom";
import type { Link } from "./link";
import type { Document, TextFault } from "./protocol";
import type { Store } from "./store";

/** Between the last key and the check, ms. */
const PAUSE = 250;
/** Largest text that is sent, in bytes as the server counts them: its own limit. */
export const MOST = 4 * 1024 * 1024;

const encoder = new TextEncoder();
/** Whether a text may be sent. */
const fits = (text: string) => text.length <= MOST && encoder.encode(text).length <= MOST;

/** Marks changes that come from the session. */
const remote = Annotation.define<boolean>();

const colours = HighlightStyle.define([
  { tag: tags.comment, color: "light-dark(#4d5966, #a9b4c0)", fontStyle: "italic" },
  { tag: tags.string, color: "light-dark(#176339, #6fd39a)" },
  { tag: tags.number, color: "light-dark(#1d5fbf, #7db4ff)" },
  { tag: [tags.atom, tags.bool], color: "light-dark(#7a5200, #f2c14e)" },
  { tag: [tags.propertyName, tags.keyword], color: "light-dark(#17202a, #e8edf2)" },
]);

const theme = EditorView.theme({
  "&": { height: "100%", color: "var(--ink)", backgroundColor: "var(--paper)", fontSize: "0.92em" },
  "&.cm-focused": { outline: "3px solid var(--strong)", outlineOffset: "-3px" },
  ".cm-scroller": { fontFamily: 'ui-monospace, "DejaVu Sans Mono", monospace', lineHeight: "1.45" },
  ".cm-content": { caretColor: "var(--ink)" },
  ".cm-cursor": { borderLeftColor: "var(--ink)" },
  ".cm-gutters": { backgroundColor: "var(--panel)", color: "var(--quiet)", borderRight: "1px solid var(--line)" },
  ".cm-activeLine, .cm-activeLineGutter": { backgroundColor: "color-mix(in srgb, var(--hover) 60%, transparent)" },
  ".cm-selectionBackground, &.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground": { backgroundColor: "light-dark(#b9d4f7, #2c4a70)" },
  ".cm-panels, .cm-tooltip": { backgroundColor: "var(--panel)", color: "var(--ink)", border: "1px solid var(--line)" },
  ".cm-tooltip-autocomplete ul li[aria-selected]": { backgroundColor: "var(--strong)", color: "var(--on-strong)" },
  ".cm-diagnostic": { whiteSpace: "pre-wrap" },
  ".cm-panels input, .cm-panels button": { font: "inherit", color: "inherit", background: "var(--paper)", border: "1px solid var(--line)", borderRadius: "0.3rem" },
});

/** The one replaced range between two texts. */
function difference(before: string, after: string): { from: number; to: number; insert: string } {
  const most = Math.min(before.length, after.length);
  let from = 0;
  while (from < most && before.charCodeAt(from) === after.charCodeAt(from)) from++;
  let end = 0;
  while (end < most - from && before.charCodeAt(before.length - 1 - end) === after.charCodeAt(after.length - 1 - end)) end++;
  return { from, to: before.length - end, insert: after.slice(from, after.length - end) };
}

/** Place and words of a fault. */
export const faultWords = (fault: TextFault): string => `${fault.line}:${fault.column}: ${fault.message}`;

interface Kept {
  /** The session's text that it was made from. */
  base: string;
  text: string;
  written: string;
}

export class TextPane {
  readonly element = element("section", { id: "text", "aria-label": "Text of the scenario", "data-typing": true });
  private view: EditorView;
  private bar = element("div", { class: "row text-bar" });
  private words = element("span", { class: "quiet", role: "status" });
  private ask = element("div", { class: "text-ask", role: "status", hidden: true });
  private apply = element("button", { id: "text-apply", class: "strong", disabled: true, title: "Checks the text and carries it out (Ctrl Enter)", onclick: () => this.send() }, "Apply");
  private revert = element("button", { id: "text-revert", disabled: true, title: "Back to the text of the session", onclick: () => this.takeTheirs() }, "Revert");
  private faultList = element("ul", { id: "text-faults", "aria-label": "Faults of the text" });
  /** The document of the session that the text was made from. */
  private base: Document | null = null;
  /** Changes since. */
  private pending = ChangeSet.empty(0);
  /** A later document, which changes what is changed here too. */
  private theirs: Document | null = null;
  /** The text that was sent to be applied. */
  private sent: string | null = null;
  private number = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    store: Store,
    private link: Link,
    /** The text has changes that are not applied, or none any more. */
    private edited: (dirty: boolean) => void,
  ) {
    const holder = element("div", { class: "text-holder" });
    // In a tree of its own: the style sheets of the editor are adopted there, which the policy of the page allows.
    const root = holder.attachShadow({ mode: "open" });
    const place = element("div", {});
    place.style.height = "100%";
    root.append(place);
    this.view = new EditorView({ parent: place, root, state: this.state("") });
    this.bar.append(this.apply, this.revert, element("button", { id: "text-find", title: "Find and replace (Ctrl F)", onclick: () => this.find() }, "Find"), this.words);
    this.element.append(this.bar, this.ask, holder, this.faultList);
    store.on("document", (document) => this.take(document));
    store.on("checked", ({ number, faults }) => {
      if (number === null || number === this.number) this.showFaults(faults);
      if (number === null) this.sent = null;
    });
    store.on("refused", () => {
      this.sent = null;
      this.show();
    });
    window.addEventListener("beforeunload", (event) => {
      if (this.dirty) event.preventDefault();
    });
  }

  get dirty(): boolean {
    return this.base !== null && this.text !== this.base.text;
  }

  get text(): string {
    return this.view.state.doc.toString();
  }

  focus(): void {
    this.view.focus();
  }

  /** Another text in place of this one, not applied yet: it is checked, and can be undone like anything typed. */
  propose(text: string): void {
    const change = difference(this.text, text);
    if (change.from !== change.to || change.insert) this.view.dispatch({ changes: change });
  }

  /** Shows a place, in characters from the beginning. */
  goTo(from: number): void {
    const at = Math.min(from, this.view.state.doc.length);
    this.view.dispatch({ selection: { anchor: at }, effects: EditorView.scrollIntoView(at, { y: "center" }) });
    this.view.focus();
  }

  /** Shows the entry of a part: the line with its name. */
  lookFor(name: string): void {
    const text = this.text;
    const quoted = JSON.stringify(name);
    const at = text.search(new RegExp(`^\\s*(?:\\{\\s*)?name\\s*=\\s*${quoted.replace(/[.*+?^${}()|[\]\\]/g, "\\$&")}`, "m"));
    if (at >= 0) this.goTo(at + (text.slice(at).match(/^\s*/)?.[0].length ?? 0));
  }

  private state(doc: string): EditorState {
    return EditorState.create({
      doc,
      extensions: [
        lineNumbers(),
        highlightActiveLineGutter(),
        highlightActiveLine(),
        history(),
        drawSelection(),
        bracketMatching(),
        search({ top: true }),
        highlightSelectionMatches(),
        lintGutter(),
        autocompletion({ override: [(context) => this.complete(context)], activateOnTyping: true }),
        StreamLanguage.define(toml),
        syntaxHighlighting(colours),
        theme,
        EditorView.contentAttributes.of({ tabindex: "0", "aria-label": "Text of the scenario, TOML. Escape, then Tab leaves it." }),
        keymap.of([{ key: "Mod-Enter", run: () => (this.send(), true), preventDefault: true }, indentWithTab, ...searchKeymap, ...historyKeymap, ...defaultKeymap]),
        EditorView.updateListener.of((update) => {
          if (!update.docChanged) return;
          if (!update.transactions.some((transaction) => transaction.annotation(remote))) {
            this.pending = this.pending.compose(update.changes);
            this.checkLater();
            this.keep();
          }
          this.show();
        }),
      ],
    });
  }

  /** Words of the text: names that are used already, and keys. */
  private complete(context: CompletionContext): CompletionResult | null {
    if (syntaxTree(context.state).resolveInner(context.pos, -1).name === "comment") return null;
    const word = context.matchBefore(/[\w.-]+/);
    if (!word || (word.from === word.to && !context.explicit)) return null;
    const line = context.state.doc.lineAt(context.pos);
    const inside = (line.text.slice(0, word.from - line.from).match(/"/g)?.length ?? 0) % 2 === 1;
    const text = this.text;
    const found = new Set<string>(inside ? [...text.matchAll(/"([\w.-]+)"/g)].map((match) => match[1]) : [...text.matchAll(/([a-z_]+)\s*=/g)].map((match) => match[1]));
    if (inside) for (const [kind] of this.base?.constraint_kinds ?? []) found.add(kind);
    found.delete(word.text);
    return { from: word.from, options: [...found].sort().map((label) => ({ label, type: inside ? "text" : "property" })), validFor: /^[\w.-]*$/ };
  }

  // What comes from the session

  private take(document: Document): void {
    const first = this.base === null;
    if (first || !this.dirty || this.text === document.text || this.sent === this.text) this.replace(document, !first);
    else this.merge(document);
    if (first) this.offerKept(document);
    this.sent = null;
    this.show();
  }

  /** The text is that of the session. */
  private replace(document: Document, forget = true): void {
    const change = difference(this.text, document.text);
    if (change.from !== change.to || change.insert) this.view.dispatch({ changes: change, annotations: [remote.of(true), Transaction.addToHistory.of(false)] });
    this.base = document;
    this.theirs = null;
    this.pending = ChangeSet.empty(document.text.length);
    // A check that is under way is of a text that is gone.
    clearTimeout(this.timer);
    this.number++;
    this.showFaults([]);
    // What an earlier page has left stays until it is decided upon.
    if (forget && this.ask.dataset.kept === undefined) this.forget();
  }

  /** Takes over what has changed elsewhere; where that is what is being edited here, asks. */
  private merge(document: Document): void {
    const base = this.base!;
    const change = difference(base.text, document.text);
    const touched = this.pending.touchesRange(change.from, change.to);
    if (touched) {
      this.theirs = document;
      return this.askWhich();
    }
    const whole = ChangeSet.of(change, base.text.length);
    const here = whole.map(this.pending);
    this.pending = this.pending.map(whole, true);
    this.base = document;
    this.view.dispatch({ changes: here, annotations: [remote.of(true), Transaction.addToHistory.of(false)] });
    this.checkLater();
    this.keep();
  }

  private askWhich(): void {
    this.ask.hidden = false;
    this.ask.replaceChildren(
      element("span", {}, "The session has changed the text where you are editing it."),
      element("button", { id: "text-mine", onclick: () => this.keepMine() }, "Keep mine"),
      element("button", { id: "text-theirs", onclick: () => this.takeTheirs() }, "Take the session's"),
    );
  }

  /** What is here stays, as a change of the text of the session. */
  private keepMine(): void {
    const document = this.theirs ?? this.base;
    if (!document) return;
    this.base = document;
    this.theirs = null;
    this.pending = ChangeSet.of(difference(document.text, this.text), document.text.length);
    this.show();
  }

  private takeTheirs(): void {
    const document = this.theirs ?? this.base;
    if (document) this.replace(document);
    this.show();
  }

  // What goes to the session

  send(): void {
    if (!this.base || !this.dirty || this.theirs) return;
    const { text } = this;
    // A check that is still to come would find nothing in a text that it does not take.
    clearTimeout(this.timer);
    if (!fits(text)) return this.showFaults([{ from: 0, to: 0, line: 1, column: 1, message: `the text has ${encoder.encode(text).length} bytes`, help: `at most ${MOST} can be applied here` }]);
    this.sent = text;
    this.link.send({ do: "apply", text, base: this.base.version });
  }

  private checkLater(): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      if (this.dirty && fits(this.text)) this.link.send({ do: "check", text: this.text, number: ++this.number });
      else this.showFaults([]);
    }, PAUSE);
  }

  private find(): void {
    this.view.focus();
    searchKeymap.find((binding) => binding.key === "Mod-f")?.run?.(this.view);
  }

  // What is shown

  private show(): void {
    const { dirty } = this;
    this.apply.disabled = !dirty || this.theirs !== null;
    this.revert.disabled = !dirty;
    this.ask.hidden = this.theirs === null && this.ask.dataset.kept === undefined;
    this.words.textContent = dirty ? "not applied" : "as computed";
    this.edited(dirty);
  }

  private showFaults(faults: TextFault[]): void {
    const length = this.view.state.doc.length;
    const diagnostics = faults.map(
      ({ from, to, message, help }): Diagnostic => ({
        from: Math.min(from, length),
        to: Math.min(Math.max(to, from), length),
        severity: "error",
        message: help ? `${message}\n${help}` : message,
      }),
    );
    this.view.dispatch(setDiagnostics(this.view.state, diagnostics));
    this.faultList.replaceChildren(
      ...faults.map((fault) => element("li", {}, element("button", { class: "plain", onclick: () => this.goTo(fault.from) }, faultWords(fault)), element("span", { class: "quiet" }, ` ${fault.help}`))),
    );
  }

  // What is not applied outlives the page

  private get key(): string {
    return `wireloom text ${this.base?.name ?? ""}`;
  }

  private keep(): void {
    if (!this.base) return;
    try {
      const kept: Kept = { base: this.base.text, text: this.text, written: new Date().toISOString() };
      localStorage.setItem(this.key, JSON.stringify(kept));
    } catch {
      this.words.textContent = "not applied, and too large to be kept by the browser";
    }
  }

  private forget(): void {
    try {
      localStorage.removeItem(this.key);
    } catch {
      // Nothing was kept either.
    }
  }

  /** Offers what an earlier page has left unapplied. */
  private offerKept(document: Document): void {
    let kept: Kept | null = null;
    try {
      kept = JSON.parse(this.kept ?? "null") as Kept | null;
    } catch {
      return;
    }
    if (!kept || kept.text === document.text) return;
    const { text, base, written } = kept;
    const done = () => {
      delete this.ask.dataset.kept;
      if (!this.dirty) this.forget();
      this.show();
    };
    const restore = () => {
      this.view.dispatch({ changes: difference(this.text, base === document.text ? text : merged(base, document.text, text)) });
      done();
    };
    this.ask.dataset.kept = "";
    this.ask.replaceChildren(
      element("span", {}, `Text of ${new Date(written).toLocaleString()} was not applied.`),
      element("button", { id: "text-restore", onclick: restore }, "Restore it"),
      element("button", { id: "text-discard", onclick: done }, "Discard it"),
    );
  }

  /** What was kept before this page took its first document. */
  private kept: string | null = null;

  /** Reads what an earlier page has kept of a file; to be called before its first document is taken. */
  remember(name: string): void {
    try {
      this.kept = localStorage.getItem(`wireloom text ${name}`);
    } catch {
      this.kept = null;
    }
  }
}

/** Changes from `base` to `mine`, made in `theirs`. */
function merged(base: string, theirs: string, mine: string): string {
  const own = ChangeSet.of(difference(base, mine), base.length);
  const other = ChangeSet.of(difference(base, theirs), base.length);
  return own.map(other).apply(Text.of(theirs.split("\n"))).toString();
}
