// The page: puts the parts together. What they are is told by the files they come from.
import * as THREE from "three";
import { Bodies } from "./bodies";
import { Build } from "./build";
import { inWords, onScale, QUANTITIES, Ranges, type QuantityName, type Scale } from "./colours";
import { difference, type Ghost } from "./compare";
import { byId, download, element, later } from "./dom";
import { along, branchOf, decode, firstNodes, valueAt, type Frame } from "./frame";
import { Drawing } from "./drawing";
import { MOST, TextPane } from "./editor";
import { Envelope, type Choice } from "./envelope";
import { elsewhere, isImported, isSurface, textOf } from "./files";
import { Hands } from "./hands";
import { Harness } from "./harness";
import { ImportPane } from "./imported";
import { Inspect } from "./inspect";
import { help, listen, type Key } from "./keys";
import { Labels } from "./labels";
import { Legend } from "./legend";
import { link, type LinkState } from "./link";
import { Panels } from "./panels";
import { FLOATS, type Notice, type Place } from "./protocol";
import { destroyed, failing, isDestroyed, sentence, verdictWords, worstFirst } from "./requirements";
import { screenshot } from "./screenshot";
import { SensitivityTable } from "./sensitivities";
import { offers, StartPane } from "./start";
import { Several } from "./several";
import { Store } from "./store";
import { Surroundings } from "./surroundings";
import { TimelineBar } from "./timeline";
import { millimetres } from "./units";
import { View, type Side } from "./view";

const store = new Store();
const view = seen();
const harness = new Harness();
const phantom = new Harness(true);
const bodies = new Bodies(view);
const ranges = new Ranges();
const envelope = new Envelope();
/** What is shown of it; null: it has not been asked for yet. */
let chosenEnvelope: Choice | null = null;
const drawing = new Drawing();
view.scene.add(harness.group, phantom.group, bodies.group, envelope.group, drawing.lines);
view.before.push(() => bodies.atLeast());
const labels = new Labels(view, bodies);

let quantity = QUANTITIES[0];
let scale: Scale | null = null;
/** Whether the legend explains destroyed branches; null: it is to be drawn anew. */
let explained: boolean | null = null;
let ghost: Ghost | null = null;
/** The shape there was when a setting was sent: the ghost, if that is taken. */
let candidate: Ghost | null = null;
let fitted = false;
/** A place to look at once its frame is shown. */
let heading: { frame: number; place: Place } | null = null;
/** An obstacle of at most so many times the size of the harness is shown whole when it is chosen. */
const WIDE = 10;
/** Whether everything is to be in view with the next frame. */
let refit = false;
/** The branch of what is chosen, which plots are of. */
let lookedAt: string | null = null;
/** The branches that there are tubes for. */
let drawn = "";
/** How long frames are waited for that were asked for, ms; every one that comes begins it anew. */
const PATIENCE = 3000;
let fetching: { from: number; to: number; at: number } | null = null;

const connection = link({
  notice: take,
  frame: takeFrame,
  state: linkState,
  complete: () => store.scrub(store.newest()),
});
const hands = new Hands(store, view, bodies, connection);
const timeline = new TimelineBar(store);
const inspect = new Inspect(store, view, hands, () => paint());
bodies.isHidden = (kind, name) => inspect.isHidden(kind, name);
const several = new Several(store, view, hands, bodies, inspect, connection, (words) => {
  byId("said").textContent = words;
  markBranches();
  paint();
});
bodies.isMarked = (kind, name) => several.has(kind, name) || (kind === "obstacle" && name === hands.obstacleName());
harness.isHidden = hands.isHidden = (branch) => inspect.isHidden("branch", branch);
const build = new Build(
  store,
  hands,
  connection,
  (name) => {
    showText(true);
    textPane.lookFor(name);
  },
  (file) => surroundings.take(file),
);
const importPane = new ImportPane((place) => goTo(null, place));
const sensitivities = new SensitivityTable(store, hands, connection, {
  goTo: (place) => goTo(null, place),
  point: (better) => {
    bodies.better = better;
    paint();
  },
});
const panels = new Panels(byId("panels"), store, hands, connection, build.element, inspect, importPane.element, sensitivities.element, {
  visit: (position) => view.visit(new THREE.Vector3(...position)),
  scrub: (frame) => timeline.go(frame),
  goTo,
  keepGhost,
  beforeSetting: () => (candidate = snapshot()),
  forgetGhost,
  toggleGizmo,
  branchChosen: (branch) => {
    lookedAt = hands.chosen ? store.scene?.branches[branch]?.name ?? null : null;
    markBranches();
  },
});
const legend = new Legend(colourBy, () => {
  scale = null;
  paint();
});
const textPane = new TextPane(store, connection, (dirty) => (byId("text-on").textContent = dirty ? "Text •" : "Text"));

const surroundings = new Surroundings(store, hands, connection, {
  tell,
  saveAs,
  fit: () => (refit = true),
});
const start = new StartPane(store, connection);

function seen(): View {
  try {
    return new View(byId("stage"));
  } catch (error) {
    byId("wait").textContent = "This browser cannot show 3D graphics: WebGL 2 is missing or switched off.";
    throw error;
  }
}

// What comes in

function take(notice: Notice): void {
  if (notice.is === "document" && store.document === null) textPane.remember(notice.name);
  if (notice.is === "scene" && (store.scene === null || store.scene.run !== notice.run || store.scene.name !== notice.name)) {
    ranges.clear();
    bodies.forget();
    if (candidate) setGhost(candidate);
    candidate = null;
    if (store.scene?.name !== notice.name) fitted = false;
  }
  store.take(notice);
  if (notice.is === "timeline") fetch();
}

function takeFrame(buffer: ArrayBuffer): void {
  const frame = decode(buffer);
  if (ranges.take(frame)) scale = null;
  bodies.take(frame);
  store.takeFrame(frame);
  if (fetching && frame.header.frame >= fetching.from && frame.header.frame < fetching.to) fetching.at = performance.now();
  fetch();
}

function linkState(state: LinkState): void {
  const chip = byId("link");
  document.body.classList.toggle("replay", state === "replay");
  const words = { connecting: "connecting…", open: store.scene === null ? "connected" : "live", lost: "connection lost, trying again…", ended: "session ended", replay: "finished run" }[state];
  chip.textContent = words;
  chip.className = state === "lost" || state === "ended" ? "chip bad" : "chip";
  start.setLink(state);
  if (state === "ended" && !start.isShown) {
    const bar = byId("draft");
    bar.hidden = false;
    bar.replaceChildren(
      element("span", {}, "This session has ended; the harness stays visible, but cannot be moved. Start “wireloom studio” again: it opens a new page and offers unsaved changes there."),
    );
  }
  if (state === "open") {
    store.forget();
    sensitivities.forget();
    fetching = null;
    hands.refused();
    candidate = null;
  }
}

/** Asks for frames that are missing, one bunch at a time, and not while hands are at work; `now` for one that is to be seen. */
function fetch(now?: number): void {
  if (hands?.dragging) return;
  if (fetching) {
    const { from, to, at } = fetching;
    const waits = performance.now() - at < PATIENCE && !(now !== undefined && (now < from || now >= to));
    let missing = 0;
    for (let number = from; number < to; number++) if (store.isMissing(number)) missing++;
    if (missing > 0 && waits) return;
    if (missing > 0 && now === undefined) store.giveUp(from, to);
    fetching = null;
  }
  const missing = store.missing();
  if (!missing) return;
  fetching = { ...missing, at: performance.now() };
  connection.send({ do: "frames", ...missing });
}
setInterval(() => fetch(), 500);
store.on("missed", (number) => fetch(number));

store.on("scene", (scene) => {
  if (scene.live) byId("link").textContent = "live";
  document.title = `${scene.name} – Wireloom studio`;
  byId("name").textContent = scene.name;
  byId("name").title = scene.program;
  document.body.classList.toggle("replay", !scene.live);
  const branches = JSON.stringify(scene.branches);
  if (branches !== drawn) harness.setScene(scene);
  drawn = branches;
  markBranches();
  bodies.setScene(scene);
  drawing.setScene(scene);
  byId("drawing-row").hidden = !drawing.exists;
  panels.showScene(scene);
  if (!scene.live) byId("link").textContent = "finished run";
  if (scene.envelope && chosenEnvelope === null) void loadEnvelope();
  if (store.shown) paint();
});

store.on("shown", () => {
  byId("wait").hidden = true;
  paint();
  if (!fitted) {
    fitted = true;
    bounds();
    view.look("oblique");
  }
  if (refit) {
    refit = false;
    bounds();
    view.fit();
  }
  warn();
  panels.showFrame();
  compare();
  arrive();
});

store.on("sheet", (sheet) => {
  const { verdict, words } = verdictWords(sheet);
  const chip = byId("verdict");
  chip.hidden = false;
  chip.className = `chip verdict ${sheet.verdict}`;
  chip.textContent = `${verdict}: ${words}`;
  panels.showSheet(sheet);
  warn();
});

store.on(
  "timeline",
  later(() => {
    panels.showEvents(store.timeline.events);
    if (!hands.dragging) bounds();
  }),
);

store.on("session", (session) => {
  const undo = byId<HTMLButtonElement>("undo");
  const redo = byId<HTMLButtonElement>("redo");
  undo.disabled = session.undo === null;
  redo.disabled = session.redo === null;
  undo.title = session.undo ? `Undo: ${session.undo} (Ctrl Z)` : "Nothing to undo";
  redo.title = session.redo ? `Redo: ${session.redo} (Ctrl Shift Z)` : "Nothing to redo";
  byId("stop").hidden = session.busy === null;
  byId("save").textContent = session.unsaved ? "Save •" : "Save";
  byId("save").title = `Writes the scenario, with interactive operations as steps, into its file (Ctrl S)${session.unsaved ? ": there are unsaved changes" : ""}`;
  panels.showSession(session);
});

store.on("refused", ({ message, help }) => {
  tell(help ? `${message}\n${help}` : message);
  hands.refused();
  panels.refused();
  candidate = null;
});

store.on("saved", ({ name, text }) => download(name, new Blob([text], { type: "application/toml" })));

store.on("imported", (imported) => {
  importPane.show(imported);
  panels.showImport();
});

store.on("document", ({ name, can_store }) => {
  byId("save-as").hidden = !can_store;
  byId("save").setAttribute("aria-label", `Save ${name}`);
});

/** What a bar above the picture says of the file, with what can be done; null: nothing. */
function sayOfFile(words: string | null, ...actions: [string, string, () => void][]): void {
  const bar = byId("file");
  bar.hidden = words === null;
  if (words === null) return;
  const button = ([id, label, act]: [string, string, () => void]) =>
    element("button", { id, onclick: () => (sayOfFile(null), act()) }, label);
  bar.replaceChildren(element("span", {}, words), ...actions.map(button), button(["file-later", "Later", () => {}]));
}

/** The name that was asked for with "Save as". */
let wantedName: string | null = null;
const reload = () => connection.send({ do: "reload" });
const writeFile = (name: string | null, replace: boolean) => connection.send({ do: "store", name, replace });

store.on("stored", (name) => {
  sayOfFile(null);
  tell(`Saved in ${name}.`);
});

store.on("conflict", ({ name, own }) => {
  const overwrite: [string, string, () => void] = ["file-overwrite", "Replace it", () => writeFile(own ? null : wantedName, true)];
  const other: [string, string, () => void] = ["file-other", "Save as…", saveAs];
  if (own) sayOfFile(`${name} was changed by another program: nothing has been saved.`, overwrite, ["file-reload", "Load it (Undo brings this back)", reload], other);
  else sayOfFile(`There is a file ${name} already: nothing has been saved.`, overwrite, other);
});

store.on("outside", (name) =>
  sayOfFile(`${name} was changed by another program.`, ["file-reload", "Load it (Undo brings this back)", reload]),
);

function save(): void {
  if (textPane.dirty) tell("The text has changes that are not applied: they are not saved.");
  if (store.document && !store.document.can_store) connection.send({ do: "save" });
  else if (store.document?.is_new) saveAs();
  else writeFile(null, false);
}

function saveAs(): void {
  const dialog = byId<HTMLDialogElement>("name-dialog");
  const input = element("input", { id: "file-name", type: "text", autocomplete: "off", spellcheck: "false", value: store.document?.name ?? "" });
  const form = element(
    "form",
    { method: "dialog" },
    element("h2", { id: "name-title" }, "Save as"),
    element("label", {}, store.document?.is_new ? "Name in the folder where the program was started, ending in .toml " : "Name in the same folder, ending in .toml ", input),
    element("p", { class: "row" }, element("button", { type: "submit", class: "strong" }, "Save"), element("button", { type: "button", onclick: () => dialog.close() }, "Cancel")),
  );
  form.addEventListener("submit", () => {
    wantedName = input.value.trim();
    writeFile(wantedName, false);
  });
  dialog.replaceChildren(form);
  dialog.showModal();
  input.select();
}

function showText(on: boolean): void {
  const main = document.querySelector("main")!;
  main.classList.toggle("with-text", on);
  if (on && !textPane.element.isConnected) main.prepend(textPane.element);
  if (!on) textPane.element.remove();
  const button = byId("text-on");
  button.setAttribute("aria-pressed", String(on));
  // What a button controls must be there.
  if (on) button.setAttribute("aria-controls", "text");
  else button.removeAttribute("aria-controls");
}

function toggleText(): void {
  const on = !textPane.element.isConnected;
  showText(on);
  if (on) textPane.focus();
}

store.on("drafts", (drafts) => {
  const bar = byId("draft");
  bar.hidden = drafts.length === 0;
  bar.replaceChildren(...offers(drafts, "Unsaved changes of an earlier session", (number, take) => connection.send({ do: "draft", number, take })));
});

/** Words that go by themselves after a while. */
function tell(words: string): void {
  const box = element("div", {}, element("span", {}, words), element("button", { "aria-label": "Close", onclick: () => box.remove() }, "✕"));
  const holder = byId("messages");
  while (holder.children.length > 2) holder.firstChild!.remove();
  holder.append(box);
  setTimeout(() => box.remove(), 12_000);
}

// The picture

/** The shape shown, its colours, what is about it. */
function paint(): void {
  const { scene, shown } = store;
  if (!scene || !shown) return;
  if (!scale) {
    scale = { ...ranges.scale(quantity, scene), ...legend.range(quantity) };
    harness.setColours(scale.colours);
    explained = null;
  }
  const broken = destroyed(shown.header.violations);
  if (explained !== broken.length > 0) {
    explained = broken.length > 0;
    legend.show(scale, hasUnknown(shown, scale), explained);
  }
  harness.update(shown, scale, broken);
  bodies.update(shown);
  showEnvelope();
  view.draw();
}

/** Fetches the tolerance envelope, once. */
async function loadEnvelope(): Promise<void> {
  chosenEnvelope = "none";
  try {
    const answer = await window.fetch(`envelope${location.search}`);
    if (!answer.ok) throw new Error(answer.statusText);
    envelope.read(await answer.arrayBuffer());
  } catch (error) {
    tell(`The tolerance envelope cannot be shown: ${error instanceof Error ? error.message : String(error)}`);
    return;
  }
  const choices = envelope.choices();
  const select = byId<HTMLSelectElement>("envelope");
  select.replaceChildren(...choices.map(([choice, words]) => element("option", { value: String(choice) }, words)));
  const choose = (value: string) => {
    chosenEnvelope = choices.find(([choice]) => String(choice) === value)?.[0] ?? "none";
    showEnvelope();
    bounds();
    view.draw();
  };
  select.addEventListener("change", () => choose(select.value));
  // All but the rarest points, where there are tubes.
  select.value = String((choices.find(([choice]) => choice === 95) ?? choices[choices.length - 1])[0]);
  byId("envelope-row").hidden = false;
  choose(select.value);
}

function showEnvelope(): void {
  const { shown } = store;
  if (!shown || chosenEnvelope === null) return;
  const step = envelope.step(shown.header.step, shown.header.increment === 0);
  byId("envelope-words").textContent = envelope.show(chosenEnvelope, step);
}

function hasUnknown(frame: Frame, by: Scale): boolean {
  const scene = store.scene!;
  const first = firstNodes(scene);
  return scene.branches.some((branch, b) => onScale(by, frame.nodes[first[b] * FLOATS + by.quantity.column], branch.bend_radius_limit) < 0);
}

function colourBy(name: QuantityName): void {
  quantity = QUANTITIES.find((each) => each.name === name)!;
  scale = null;
  paint();
}

function bounds(): void {
  const { scene, shown } = store;
  if (!scene || !shown) return;
  const box = new THREE.Box3();
  const place = new THREE.Vector3();
  const n = shown.nodes;
  for (let i = 0; i < n.length; i += FLOATS) box.expandByPoint(place.set(n[i], n[i + 1], n[i + 2]));
  const harnessSize = box.getSize(new THREE.Vector3()).length();
  const reach = box.clone().expandByScalar(0.35 * harnessSize);
  for (const body of bodies.bodies) {
    if (!body.acts) continue;
    if (body.kind !== "obstacle") box.expandByPoint(body.object.position);
    else {
      const own = new THREE.Box3().setFromObject(body.object);
      // Of an obstacle only what is near the harness: planes are endless. That which is chosen is looked for.
      const wanted = body.name === hands.obstacleName() && own.getSize(new THREE.Vector3()).length() < WIDE * harnessSize;
      if (!wanted) own.intersect(reach);
      if (!own.isEmpty()) box.union(own);
    }
  }
  const around = new THREE.Box3().setFromObject(envelope.group);
  if (!around.isEmpty()) box.union(around);
  view.setBounds(box);
}

/** Events that say the same as a requirement. */
const REQUIRED = new Set(["bend-radius", "clearance", "fixing-force", "fixing-moment", "insertion-force", "overstretched", "overlap"]);

/** What an engineer must not overlook, the worst first: requirements that fail, then no equilibrium, then events of this frame. */
function warn(): void {
  const { shown, sheet, timeline: now } = store;
  const banner = byId("warning");
  if (!shown) return;
  const rows: HTMLElement[] = [];
  const link = (words: string, act: () => void) => element("button", { class: "plain", onclick: act }, words);
  const row = (name: string, kind: string, ...content: (Node | string)[]) => rows.push(element("div", { class: kind }, element("strong", {}, name), element("span", {}, ...content)));
  const more = (count: number) => (count > 0 ? link(`and ${count} more`, () => panels.lookAtSheet()) : "");

  const failed = sheet ? failing(sheet).sort(worstFirst) : [];
  const here = [...shown.header.violations].sort(worstFirst);
  const [worst] = failed;
  if (worst) {
    const when = worst.step === null ? "" : worst.increment === 0 ? `, ${worst.step}` : `, step ${worst.step}`;
    row(worst.severity === "must" ? "FAIL" : "should", worst.severity, link(sentence(worst, worst.worst ?? Number.NaN) + when, () => goTo(worst.frame, worst.place)), " ", more(failed.length - 1));
  } else if (sheet?.verdict === "unresolved" && sheet.done >= sheet.steps) {
    row("UNRESOLVED", "unresolved", link(verdictWords(sheet).words, () => panels.lookAtSheet()));
  }
  const [own] = here;
  if (own && (!worst || worst.frame !== shown.header.frame)) {
    row("in this frame", own.severity, link(sentence(own, own.value), () => goTo(null, own.place)), here.length > 1 ? ` and ${here.length - 1} more` : "");
  }
  if (shown.header.status !== "converged") row("no equilibrium", "must", `the solver says: ${shown.header.status}`);
  const events = now.events.filter((event) => event.frame === shown.header.frame && !(sheet && REQUIRED.has(event.kind)));
  if (events.length > 0) {
    const [{ message, position }] = events;
    row("event", "event", position ? link(message, () => view.visit(new THREE.Vector3(...position))) : message, events.length > 1 ? ` and ${events.length - 1} more` : "");
  }
  banner.hidden = rows.length === 0;
  banner.classList.toggle("destroyed", [...failed, ...here].some((line) => line.severity === "must" && isDestroyed(line.measure)));
  banner.replaceChildren(...rows);
}

/** Looks at a place as it is in a frame (null: as it is shown), as soon as that frame is here. */
function goTo(frame: number | null, place: Place): void {
  const wanted = frame ?? store.wanted;
  heading = { frame: wanted, place };
  if (wanted !== store.wanted) timeline.go(wanted);
  arrive();
}

function arrive(): void {
  const { scene, shown } = store;
  if (!heading || !scene || !shown) return;
  if (store.wanted !== heading.frame) heading = null;
  else if (shown.header.frame === heading.frame || !store.isMissing(heading.frame)) {
    const { place } = heading;
    heading = null;
    const at = positionOf(place);
    if (at) view.visit(new THREE.Vector3(...at));
    const branch = scene.branches.find((each) => each.name === place.branch);
    if (place.constraint !== null && hands.at(place.constraint)) hands.choose({ is: "constraint", name: place.constraint });
    else if (branch) hands.choose({ is: "point", branch: branch.name, s: place.s ?? 0.5 * branch.length });
  }
}

/** Where a place is in the frame that is shown, m. */
function positionOf(place: Place): [number, number, number] | null {
  const { scene, shown } = store;
  if (!scene || !shown) return null;
  const branch = place.branch === null ? -1 : branchOf(scene, place.branch);
  if (branch >= 0) return along(shown, scene, branch, place.s ?? 0.5 * scene.branches[branch].length).position;
  const constraint = shown.header.constraints.find((each) => each.name === place.constraint);
  if (constraint) return constraint.at.position;
  const obstacle = scene.obstacles.findIndex((each) => each.name === place.obstacle);
  return obstacle >= 0 ? (shown.header.obstacles[obstacle]?.at.position ?? null) : null;
}

// The ghost

function snapshot(): Ghost | null {
  const { scene, shown } = store;
  if (!scene || !shown) return null;
  const models = [...new Set(scene.joints.map((joint) => joint.model))];
  return { scene, frame: shown, words: `frame ${shown.header.frame}, ${shown.header.step}${models.length ? `, joints ${models.join(", ")}` : ""}` };
}

function keepGhost(): void {
  const now = snapshot();
  if (now) setGhost(now);
}

function setGhost(now: Ghost): void {
  ghost = now;
  phantom.setScene(now.scene);
  phantom.update(now.frame, ranges.scale(QUANTITIES[0], now.scene));
  panels.open("compare");
  compare();
  view.draw();
}

function forgetGhost(): void {
  ghost = null;
  phantom.group.clear();
  compare();
  view.draw();
}

function compare(): void {
  const { scene, shown } = store;
  panels.showGhost(ghost, ghost && scene && shown ? difference(ghost, scene, shown) : null);
}

// Hands

/** Draws branches as chosen: that of what is chosen, and those that are chosen with others. */
function markBranches(): void {
  const { scene } = store;
  if (!scene) return;
  const index = (name: string) => branchOf(scene, name);
  harness.choose(lookedAt === null ? -1 : index(lookedAt), several.branches().map(index));
  view.draw();
}

hands.on("chosen", (chosen) => {
  lookedAt = null;
  markBranches();
  panels.showChosen();
  paint();
  byId("said").textContent = chosen === null ? "Nothing is chosen." : chosen.is !== "point" ? `${chosen.name} is chosen.` : `${chosen.branch} at ${millimetres(chosen.s)} is chosen.`;
});

hands.on("mode", () => {
  const press = (id: string, on: boolean) => byId(id).setAttribute("aria-pressed", String(on));
  press("gizmo-move", hands.mode === "translate");
  press("gizmo-turn", hands.mode === "rotate");
  for (const axis of ["x", "y", "z"] as const) press(`axis-${axis}`, hands.axis === axis);
});

hands.on("dragging", (dragging) => {
  byId("over").hidden = true;
  if (!dragging) setTimeout(() => (bounds(), fetch()), 300);
});

hands.on("over", (over) => {
  const box = byId("over");
  box.hidden = over === null;
  const { scene, shown } = store;
  if (!over || !scene || !shown) return;
  const lines: string[] = [];
  if (over.name) lines.push(over.name);
  const identity = scene.constraints.find((constraint) => constraint.name === over.name)?.identity;
  if (identity) lines.push(identity);
  if (over.point) {
    const { branch, s } = over.point;
    lines.push(`${scene.branches[branch].name}, s = ${millimetres(s)}`);
    const part = scene.branches[branch].identity;
    if (part) lines.push(part);
    for (const each of QUANTITIES) {
      const value = valueAt(shown, scene, branch, s, each.column);
      if (!Number.isNaN(value)) lines.push(`${each.name === "bend" ? "bend radius" : each.label.toLowerCase()} ${inWords(each, value)}`);
    }
  }
  box.textContent = lines.join("\n");
  const right = over.x > view.width - 260;
  box.style.transform = `translate(${right ? over.x - 16 : over.x + 16}px, ${Math.min(over.y + 12, view.height - 130)}px)${right ? " translateX(-100%)" : ""}`;
});

function toggleGizmo(mode: "translate" | "rotate"): void {
  hands.setMode(hands.mode === mode ? "none" : mode);
}

function toggleAxis(axis: "x" | "y" | "z"): void {
  hands.setAxis(hands.axis === axis ? null : axis);
}

/** The next obstacle, or the one before. */
function nextObstacle(by: number): void {
  const shown = bodies.bodies.filter((body) => body.kind === "obstacle" && body.acts);
  if (shown.length === 0) return tell("There are no obstacles to choose.");
  const now = shown.findIndex((body) => body.name === hands.obstacleName());
  hands.choose({ is: "obstacle", name: shown[(now + by + (now < 0 && by < 0 ? 1 : 0) + shown.length) % shown.length].name });
}

/** The next constraint that acts, or the one before. */
function nextConstraint(by: number): void {
  const acting = bodies.bodies.filter((body) => body.kind === "constraint" && body.acts);
  if (acting.length === 0) return;
  const now = acting.findIndex((body) => body.name === hands.constraintName());
  const next = acting[(now + by + (now < 0 && by < 0 ? 1 : 0) + acting.length) % acting.length];
  hands.choose({ is: "constraint", name: next.name });
}

function holdHere(how: "handle" | "pin" | "collar"): void {
  if (hands.chosen?.is === "point") hands.hold(hands.chosen.branch, hands.chosen.s, how);
  else if (how === "pin") hands.pin();
  else tell("Choose a point of a cable first: click it, or use Alt and the arrow keys.");
}

// Buttons and keys

function look(side: Side): void {
  view.look(side);
  projected();
}

function project(orthographic: boolean): void {
  view.project(orthographic);
  projected();
}

function projected(): void {
  hands.cameraChanged();
  byId("projection").setAttribute("aria-pressed", String(view.isOrthographic));
}

function picture(): void {
  const [name, step] = [store.scene?.name ?? "wireloom", store.shown?.header.step ?? ""];
  const { sheet } = store;
  const verdict = sheet && { words: `${verdictWords(sheet).verdict}: ${verdictWords(sheet).words}`, is: sheet.verdict };
  screenshot(view, scale, `${name}: ${step}, frame ${store.wanted}`, verdict, explained === true).then(
    (blob) => download(`${name}-${store.wanted}.png`, blob),
    () => tell("The picture could not be made."),
  );
}

function showDrawing(shown: boolean): void {
  byId<HTMLInputElement>("drawing").checked = shown;
  drawing.lines.visible = shown;
  view.draw();
}

function toggleLabels(): void {
  labels.shown = !labels.shown;
  byId("labels-on").setAttribute("aria-pressed", String(labels.shown));
  view.draw();
}

function arrows(): void {
  bodies.showArrows = byId<HTMLInputElement>("arrows-on").checked;
  bodies.arrowScale = 10 ** Number(byId<HTMLInputElement>("arrows").value);
  paint();
}

const live = () => store.scene?.live === true;
const send = (what: "undo" | "redo" | "stop") => () => connection.send({ do: what });
const nudges: [string, [number, number, number], string][] = [
  ["ArrowLeft", [-1, 0, 0], "to the left"],
  ["ArrowRight", [1, 0, 0], "to the right"],
  ["ArrowUp", [0, 1, 0], "up"],
  ["ArrowDown", [0, -1, 0], "down"],
  ["PageUp", [0, 0, -1], "away from the eye"],
  ["PageDown", [0, 0, 1], "towards the eye"],
];
const keys: Key[] = [
  { keys: ["?"], words: "This page", act: () => help(keys, live()) },
  { keys: ["n", "]"], words: "Choose the next constraint", act: () => nextConstraint(1) },
  { keys: ["Shift+n", "["], words: "Choose the previous constraint", act: () => nextConstraint(-1) },
  { keys: ["o"], words: "Choose the next obstacle", act: () => nextObstacle(1) },
  { keys: ["Shift+o"], words: "Choose the previous obstacle", act: () => nextObstacle(-1) },
  { keys: ["Alt+ArrowLeft"], words: "Along the branch, towards its start", act: () => hands.walk(-1) },
  { keys: ["Alt+ArrowRight"], words: "Along the branch, towards its end", act: () => hands.walk(1) },
  { keys: ["Alt+ArrowDown"], words: "To the middle of the next branch", act: () => hands.nextBranch(1) },
  { keys: ["Alt+ArrowUp"], words: "To the middle of the previous branch", act: () => hands.nextBranch(-1) },
  { keys: ["Escape"], words: "Choose nothing", act: () => (hands.setMode("none"), several.draw(false), several.count > 0 && several.choose([]), hands.choose(null)) },
  ...nudges.map(([key, [x, y, z], words]): Key => ({ keys: [key], words: `Move the chosen constraint or obstacle ${words} by 1 mm, along the nearest axis`, live: true, act: () => hands.nudge(x * 1e-3, y * 1e-3, z * 1e-3) })),
  ...nudges.map(([key, [x, y, z], words]): Key => ({ keys: [`Shift+${key}`], words: `The same ${words} by 10 mm`, live: true, act: () => hands.nudge(x * 1e-2, y * 1e-2, z * 1e-2) })),
  { keys: ["h"], words: "Hold the chosen point with a handle", live: true, act: () => holdHere("handle") },
  { keys: ["p"], words: "Pin it: position, tangent and twist", live: true, act: () => holdHere("pin") },
  { keys: ["c"], words: "Clip it: position and tangent", live: true, act: () => holdHere("collar") },
  { keys: ["Delete", "Backspace"], words: "Release the chosen constraint; delete the chosen obstacle, or several chosen parts", live: true, act: () => (several.count > 0 ? several.delete() : hands.release()) },
  { keys: ["x"], words: "Drag along X only, or freely again", live: true, act: () => toggleAxis("x") },
  { keys: ["y"], words: "Drag along Y only, or freely again", live: true, act: () => toggleAxis("y") },
  { keys: ["z"], words: "Drag along Z only, or freely again", live: true, act: () => toggleAxis("z") },
  { keys: ["g"], words: "Arrows to move the chosen constraint or obstacle", live: true, act: () => toggleGizmo("translate") },
  { keys: ["r"], words: "Rings to rotate it", live: true, act: () => toggleGizmo("rotate") },
  { keys: ["Ctrl+z"], words: "Undo", live: true, act: send("undo") },
  { keys: ["Ctrl+Shift+z", "Ctrl+y"], words: "Redo", live: true, act: send("redo") },
  { keys: ["Ctrl+s"], words: "Save the scenario", live: true, act: save },
  { keys: ["t"], words: "The text of the scenario; Ctrl Enter applies it", live: true, act: toggleText },
  { keys: [" "], words: "Play or pause", act: () => timeline.toggle() },
  { keys: [","], words: "One frame back", act: () => timeline.go(store.wanted - 1) },
  { keys: ["."], words: "One frame forward", act: () => timeline.go(store.wanted + 1) },
  { keys: ["<", "Shift+,"], words: "To the end of the previous step", act: () => timeline.step(-1) },
  { keys: [">", "Shift+."], words: "To the end of the next step", act: () => timeline.step(1) },
  { keys: ["Home"], words: "To the start", act: () => timeline.go(0) },
  { keys: ["End"], words: "To the newest frame", act: () => timeline.go(Infinity) },
  { keys: ["1"], words: "From the front", act: () => look("front") },
  { keys: ["2"], words: "From above", act: () => look("top") },
  { keys: ["3"], words: "From the right", act: () => look("right") },
  { keys: ["4"], words: "Oblique", act: () => look("oblique") },
  { keys: ["5"], words: "Perspective or parallel projection", act: () => project(!view.isOrthographic) },
  { keys: ["f"], words: "Everything in view", act: () => (bounds(), view.fit()) },
  { keys: ["+", "="], words: "Nearer", act: () => view.controls.dollyIn(1.15) },
  { keys: ["-"], words: "Farther", act: () => view.controls.dollyOut(1.15) },
  { keys: ["Ctrl+ArrowLeft"], words: "Rotate the view to the left", act: () => view.turn(-0.1, 0) },
  { keys: ["Ctrl+ArrowRight"], words: "Rotate the view to the right", act: () => view.turn(0.1, 0) },
  { keys: ["Ctrl+ArrowUp"], words: "Rotate the view up", act: () => view.turn(0, -0.1) },
  { keys: ["Ctrl+ArrowDown"], words: "Rotate the view down", act: () => view.turn(0, 0.1) },
  { keys: ["b"], words: "Colour by the next quantity", act: () => colourBy(QUANTITIES[(QUANTITIES.indexOf(quantity) + 1) % QUANTITIES.length].name) },
  { keys: ["w"], words: "Choose several parts: draw a box around them, or click with Shift one after the other", act: () => several.draw(!several.drawing) },
  { keys: ["m"], words: "Measure between two places that are chosen next", act: () => (panels.open("measure"), inspect.toggleMeasure()) },
  { keys: ["k"], words: "Keep the shape as a ghost, or remove it", act: () => (ghost ? forgetGhost() : keepGhost()) },
  { keys: ["d"], words: "Drawn centre lines, beside the computed ones", act: () => showDrawing(!byId<HTMLInputElement>("drawing").checked) },
  { keys: ["l"], words: "Names and forces in the picture", act: toggleLabels },
  { keys: ["s"], words: "Download the picture", act: picture },
];
listen(keys, live);

for (const button of document.querySelectorAll<HTMLButtonElement>("[data-side]")) button.addEventListener("click", () => look(button.dataset.side as Side));
const click = (id: string, act: () => void) => byId(id).addEventListener("click", act);
click("undo", send("undo"));
click("redo", send("redo"));
click("stop", send("stop"));
click("save", save);
click("save-as", saveAs);
click("copy", () => connection.send({ do: "save" }));
click("text-on", toggleText);
click("screenshot", picture);
click("help", () => help(keys, live()));
click("verdict", () => panels.lookAtSheet());
click("projection", () => project(!view.isOrthographic));
click("fit", () => (bounds(), view.fit()));
click("gizmo-move", () => toggleGizmo("translate"));
click("gizmo-turn", () => toggleGizmo("rotate"));
for (const axis of ["x", "y", "z"] as const) click(`axis-${axis}`, () => toggleAxis(axis));
click("labels-on", toggleLabels);
byId("arrows").addEventListener("input", arrows);
byId("arrows-on").addEventListener("change", arrows);
byId("drawing").addEventListener("change", () => showDrawing(byId<HTMLInputElement>("drawing").checked));

// Files that are dropped on the page

/** A scenario becomes the text, not applied yet; a surface becomes an obstacle; of another file it is told how it comes into a scenario. */
async function takeFile(file: File): Promise<void> {
  const says = (words: string) => tell(`${file.name}: ${words}`);
  if (!live()) return says("this is a finished run; open the scenario with “wireloom studio” to change it.");
  if (isImported(file.name)) return says("a session has its harness: start “wireloom studio” alone and drop it there, or make a scenario of it with “wireloom import”.");
  if (isSurface(file.name)) return surroundings.take(file);
  const other = elsewhere(file.name, "a scenario (a file that ends in .toml) or a surface (STL, OBJ, PLY, glTF, GLB, STEP)");
  if (other !== null) return says(other);
  const read = await textOf(file, MOST);
  if ("fault" in read) return says(read.fault);
  showText(true);
  textPane.propose(read.text);
  says("it stands in the text, and is checked; Apply carries it out.");
}

document.addEventListener("dragover", (event) => {
  if (event.dataTransfer?.types.includes("Files")) event.preventDefault();
});
document.addEventListener("drop", (event) => {
  const files = event.dataTransfer?.files;
  if (!files?.length) return;
  event.preventDefault();
  if (start.isShown) void start.take(files[0]);
  else for (const file of files) void takeFile(file);
});

/** For tests: what the page knows and where things are on the screen. */
declare global {
  interface Window {
    wireloom: {
      store: Store;
      hands: Hands;
      text: TextPane;
      envelope: Envelope;
      toScreen(position: [number, number, number]): { x: number; y: number };
      /** Where the harness lies on the scale of colours: every place once. */
      colours(): number[];
      /** Numbers of a node in a frame. */
      floats: number;
      /** Geometries and textures on the graphics card. */
      memory(): { geometries: number; textures: number };
    };
  }
}
window.wireloom = {
  store,
  hands,
  text: textPane,
  envelope,
  colours: () => harness.values(),
  floats: FLOATS,
  memory: () => ({ geometries: view.renderer.info.memory.geometries, textures: view.renderer.info.memory.textures }),
  toScreen(position) {
    const box = view.renderer.domElement.getBoundingClientRect();
    const at = view.toScreen(new THREE.Vector3(...position));
    return { x: at.x + box.left, y: at.y + box.top };
  },
};

connection.start();
