// The column beside the picture: state, what is chosen, warnings, constraints, plots, settings, comparison, files, notes.
import * as THREE from "three";
import { inWords, QUANTITIES } from "./colours";
import type { Difference, Ghost } from "./compare";
import { element } from "./dom";
import { along, branchOf, valueAt, type Frame } from "./frame";
import type { Hands } from "./hands";
import type { Link } from "./link";
import { nodesOf, Plot, PLOTTED } from "./plots";
import type { Event, ConstraintFrame, MechanismJoint, Place, Placed, Scene, Session, Setting, Sheet, SheetLine } from "./protocol";
import { isOpen, limitWords, placeWords, verdictWords, worstWords } from "./requirements";
import type { Store } from "./store";
import { components, digits, millimetres, moment, newtons, percent, quantity, residual, seconds } from "./units";

export interface Wishes {
  /** Looks at a place. */
  visit(position: [number, number, number]): void;
  scrub(frame: number): void;
  /** Looks at a place of the harness as it is in a frame; null: the one that is shown. */
  goTo(frame: number | null, place: Place): void;
  keepGhost(): void;
  /** The shape shown is to become the ghost once a setting has been taken. */
  beforeSetting(): void;
  forgetGhost(): void;
  toggleGizmo(mode: "translate" | "rotate"): void;
  /** Another branch is looked at closer. */
  branchChosen(branch: number): void;
}

/** Numbers that stand in a column. */
const short = (value: number) => (Math.abs(value) < 0.005 ? "0" : value.toFixed(Math.abs(value) < 10 ? 2 : Math.abs(value) < 100 ? 1 : 0).replace("-", "−"));

/** Part number and the like, where there is one. */
const identity = (words: string | null): Node[] => (words === null ? [] : [element("p", { class: "quiet" }, words)]);

export class Panels {
  private sheet = element("section", { id: "sheet", "aria-label": "Requirements" });
  private passed = element("details", {});
  private state = element("section", { "aria-label": "Solver" });
  private chosen = element("div", {});
  private warnings = element("ul", { class: "long" });
  private constraints = element("div", {});
  private mechanisms = element("div", {});
  private plots = element("div", {});
  private settings = element("div", {});
  private comparison = element("div", {});
  private files = element("div", {});
  private notes = element("ul", {});
  private sections = new Map<string, HTMLDetailsElement>();
  private curves: Plot[];
  private branchList = element("select", { "aria-label": "Branch" });
  private branch = 0;
  private pointed: number | null = null;
  private fields: { position: HTMLInputElement[]; angles: HTMLInputElement[] } | null = null;
  private facts: HTMLElement | null = null;
  /** What can be done to the chosen constraint, as long as it acts. */
  private acts: HTMLElement | null = null;
  /** Shows the values of the joints of mechanisms in a frame. */
  private showValues: (values: number[]) => void = () => {};
  /** The joints of mechanisms that are listed. */
  private joints = "";
  /** The settings that are listed. */
  private listed = "";
  private rows = new Map<string, HTMLTableRowElement>();

  constructor(
    holder: HTMLElement,
    private store: Store,
    private hands: Hands,
    private link: Link,
    build: HTMLElement,
    inspect: { parts: HTMLElement; measures: HTMLElement },
    imported: HTMLElement,
    private sensitivities: HTMLElement,
    private wishes: Wishes,
  ) {
    const section = (name: string, title: string, open: boolean, live: boolean, ...content: Node[]) => {
      const made = element("details", { open, class: live ? "live" : undefined }, element("summary", {}, element("h2", {}, title)), ...content);
      made.addEventListener("toggle", () => made.open && this.showFrame());
      this.sections.set(name, made);
      return made;
    };
    this.curves = PLOTTED.map(
      (quantity) =>
        new Plot(quantity, (s, chosen) => {
          this.pointed = s;
          if (chosen) this.hands.choose({ is: "point", branch: this.branchList.value, s });
          else this.showPlots();
        }),
    );
    this.branchList.addEventListener("change", () => this.lookAt(this.branchList.selectedIndex));
    this.plots.append(element("div", { class: "row" }, this.branchList), ...this.curves.map((curve) => curve.element));
    this.plots.addEventListener("pointerleave", () => {
      this.pointed = null;
      this.showPlots();
    });
    holder.append(
      this.sheet,
      this.state,
      section("imported", "Import", true, false, imported),
      section("chosen", "Chosen", true, false, this.chosen),
      section("build", "Build", false, true, build),
      section("measure", "Measure", false, false, inspect.measures),
      section("parts", "Parts and cut", false, false, inspect.parts),
      section("warnings", "Warnings and events", true, false, this.warnings),
      section("constraints", "Constraints", true, false, this.constraints),
      section("mechanisms", "Mechanisms", true, false, this.mechanisms),
      section("plots", "Along the branch", true, false, this.plots),
      section("settings", "Swap", false, true, this.settings),
      section("compare", "Compare", false, false, this.comparison),
      section("files", "Files", false, false, this.files),
      section("notes", "Notes", false, false, this.notes),
    );
    this.sections.get("imported")!.hidden = true;
    this.showChosen();
    this.showGhost(null, null);
  }

  /** There are findings of an import. */
  showImport(): void {
    this.sections.get("imported")!.hidden = false;
  }

  open(name: string): void {
    const section = this.sections.get(name);
    if (section) section.open = true;
  }

  // The scene

  showScene(scene: Scene): void {
    const plotted = this.branchList.value;
    this.branchList.replaceChildren(...scene.branches.map(({ name }) => element("option", { value: name }, name)));
    this.branch = Math.max(0, branchOf(scene, plotted));
    this.branchList.selectedIndex = this.branch;
    const settings = JSON.stringify(scene.settings);
    if (settings !== this.listed) this.showSettings(scene.settings);
    this.listed = settings;
    this.files.replaceChildren(
      element("p", { class: "quiet" }, "In the formats of `run`, for all steps so far:"),
      element("ul", {}, ...scene.exports.map((name) => element("li", {}, element("a", { href: `export/${encodeURIComponent(name)}${location.search}`, download: name }, name)))),
    );
    this.sections.get("files")!.hidden = scene.exports.length === 0;
    this.sections.get("settings")!.hidden = scene.settings.length === 0 || !scene.live;
    this.sections.get("notes")!.hidden = scene.notes.length === 0;
    this.notes.replaceChildren(...scene.notes.map((note) => element("li", {}, note)));
    const head = element("tr", {}, ...["Constraint", "Fx", "Fy", "Fz", "F, N", "M, N mm"].map((words) => element("th", { scope: "col" }, words)));
    this.rows.clear();
    const body = element("tbody", {});
    for (const constraint of scene.constraints) {
      const row = element("tr", {}, element("td", {}, element("button", { class: "plain", title: [constraint.kind, constraint.identity].filter((words) => words !== null).join(": "), onclick: () => this.hands.choose({ is: "constraint", name: constraint.name }) }, constraint.name)), ...Array.from({ length: 5 }, () => element("td", {})));
      this.rows.set(constraint.name, row);
      body.append(row);
    }
    this.constraints.replaceChildren(scene.constraints.length ? element("div", { class: "long" }, element("table", {}, element("thead", {}, head), body)) : element("p", { class: "quiet" }, "none"));
    const joints = JSON.stringify([scene.mechanism_joints, scene.live]);
    if (joints !== this.joints) this.showMechanisms(scene.mechanism_joints, scene.live);
    this.joints = joints;
    this.showChosen();
  }

  // Mechanisms

  private showMechanisms(joints: MechanismJoint[], live: boolean): void {
    this.sections.get("mechanisms")!.hidden = joints.length === 0;
    const rows = joints.map((joint) => this.joint(joint, live && joint.can_be_driven));
    this.mechanisms.replaceChildren(...rows.map((row) => row.element));
    this.showValues = (values) => rows.forEach((row, i) => row.show(values[i]));
  }

  /** A joint with its value, and a slider if it can be driven. */
  private joint(joint: MechanismJoint, driven: boolean): { element: HTMLElement; show: (value: number) => void } {
    const [unit, factor] = joint.is_length ? ["mm", 1000] : ["°", 180 / Math.PI];
    const words = element("output", {});
    const slider = element("input", { type: "range", step: "any", disabled: !driven, "aria-label": `${joint.name}, ${joint.is_length ? "mm" : "degrees"}` });
    const range = joint.limits?.map((limit) => limit * factor) ?? (joint.is_length ? [-100, 100] : [-180, 180]);
    [slider.min, slider.max] = range.map(String);
    const write = (value: number) => {
      words.textContent = `${digits(value, 4)} ${unit}`;
      slider.setAttribute("aria-valuetext", words.textContent);
    };
    slider.addEventListener("input", () => write(slider.valueAsNumber));
    slider.addEventListener("change", () => this.link.send({ do: "drive", joint: joint.name, value: slider.valueAsNumber / factor }));
    const show = (value: number) => {
      // Not under a hand that pulls it.
      if (slider.matches(":active")) return;
      slider.value = String(value * factor);
      write(value * factor);
    };
    return { element: element("label", { class: "setting" }, element("span", {}, joint.name), element("span", { class: "field" }, slider, words)), show };
  }

  // The state

  showSession(session: Session | null): void {
    this.showState(this.store.shown, session);
  }

  private showState(frame: Frame | null, session: Session | null): void {
    if (!frame) return;
    const h = frame.header;
    const good = h.status === "converged" && h.stable !== false;
    const facts: [string, string | Node][] = [
      // In no colour of its own where it has converged: whether the harness is acceptable is another question.
      ["solver", element("span", { class: good ? "" : "bad" }, h.status, h.stable === false ? ", not stable" : "")],
      ["iterations", `${h.iterations} in ${seconds(h.seconds)}, residual ${residual(h.residual)}`],
    ];
    if (h.tightest) {
      const { branch, s, radius, limit } = h.tightest;
      const tight = limit !== null && radius < limit;
      facts.push(["tightest bend", element("button", { class: "plain", onclick: () => this.visitPoint(branch, s) }, element("span", { class: tight ? "bad" : "" }, `${millimetres(radius, 3)} on ${branch}`), limit === null ? "" : ` (allowed ${millimetres(limit, 3)})`)]);
    }
    const energy = h.energy.find(([name]) => name === "total");
    if (energy) facts.push(["energy", quantity(energy[1], "J", 4)]);
    if (session && this.store.scene?.live) {
      facts.push(["now", session.busy ? `computing ${session.busy}` : "waiting for hands"]);
      if (session.rate > 0 && this.store.timeline.steps.at(-1)?.by_hand) facts.push(["rate", `${digits(session.rate, 2)} updates/s`]);
      if (session.tabs > 1) facts.push(["pages", `${session.tabs} look at this session`]);
    }
    this.state.replaceChildren(element("dl", { class: "facts" }, ...facts.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)])));
  }

  // The sheet of requirements

  showSheet(sheet: Sheet): void {
    const { verdict, words } = verdictWords(sheet);
    const bad = sheet.lines.filter(isOpen);
    const good = sheet.lines.filter((line) => !isOpen(line));
    const open = this.passed.open;
    this.passed = element("details", { open }, element("summary", {}, `${good.length} kept, or nothing to check`), element("ul", {}, ...good.map((line) => this.line(line))));
    this.sheet.replaceChildren(
      element("h2", {}, "Requirements ", element("span", { class: `verdict ${sheet.verdict}` }, verdict)),
      element("p", {}, words),
      ...(bad.length ? [element("ul", { class: "lines" }, ...bad.map((line) => this.line(line)))] : []),
      ...(good.length ? [this.passed] : []),
    );
  }

  private line(line: SheetLine): HTMLElement {
    const when = line.step === null ? "" : line.increment === 0 ? line.step : `step ${line.step}, increment ${line.increment}`;
    const margin = line.margin === null || line.worst === null ? "" : percent(line.margin);
    const words = [line.name, placeWords(line.place), when, line.severity === "should" ? "should" : "", line.because ?? "", line.reason ?? ""];
    const head = element("span", { class: "head" }, worstWords(line), element("span", { class: "quiet" }, `, ${limitWords(line.bound, line.measure, line.unit, line.limit)}`));
    return element(
      "li",
      { class: `line ${line.verdict.replace(" ", "-")} ${line.severity}` },
      element("div", { class: "row" }, element("span", { class: "mark", title: line.verdict }, line.verdict), line.worst === null ? head : element("button", { class: "plain", title: "Shows the place", onclick: () => this.wishes.goTo(line.frame, line.place) }, head), element("span", { class: "margin" }, margin)),
      element("div", { class: "quiet" }, words.filter((each) => each !== "").join(" · ")),
    );
  }

  /** Brings the sheet into view. */
  lookAtSheet(): void {
    this.sheet.scrollIntoView({ block: "start" });
  }

  private visitPoint(branchName: string, s: number): void {
    const { scene, shown } = this.store;
    const branch = scene ? branchOf(scene, branchName) : -1;
    if (!scene || !shown || branch < 0) return;
    this.wishes.visit(along(shown, scene, branch, s).position);
    this.hands.choose({ is: "point", branch: branchName, s });
  }

  // What changes with every frame

  showFrame(): void {
    const { scene, shown } = this.store;
    if (!scene || !shown) return;
    this.showState(shown, this.store.session);
    this.showFacts(scene, shown);
    this.showValues(shown.header.mechanism_values);
    if (this.sections.get("constraints")!.open) this.showForces(shown);
    if (this.sections.get("plots")!.open) this.showPlots();
  }

  private showForces(frame: Frame): void {
    const acting = new Map(frame.header.constraints.map((constraint) => [constraint.name, constraint]));
    for (const [name, row] of this.rows) {
      const at = acting.get(name);
      row.hidden = !at;
      if (!at) continue;
      row.className = this.hands.constraintName() === name ? "chosen" : "";
      const words = [...at.force, Math.hypot(...at.force)].map(short).concat(short(1000 * Math.hypot(...at.moment)));
      words.forEach((text, i) => (row.cells[i + 1].textContent = text));
    }
  }

  // Warnings

  showEvents(events: Event[]): void {
    const shown = this.store.wanted;
    const items = events.map((event) =>
      element(
        "li",
        {},
        element(
          "button",
          {
            class: "plain",
            onclick: () => {
              this.wishes.scrub(event.frame);
              if (event.position) this.wishes.visit(event.position);
            },
          },
          `${event.message}`,
        ),
        element("span", { class: "quiet" }, ` frame ${event.frame}${event.frame === shown ? ", shown" : ""}`),
      ),
    );
    this.warnings.replaceChildren(...(items.length ? items : [element("li", { class: "quiet" }, "none so far")]));
  }

  // What is chosen

  showChosen(): void {
    const scene = this.store.scene;
    const chosen = this.hands.chosen;
    this.fields = null;
    this.acts = null;
    this.facts = element("dl", { class: "facts" });
    const live = scene?.live === true;
    const button = (words: string, title: string, act: () => void) => element("button", { title, onclick: act }, words);
    if (!scene || !chosen) {
      this.chosen.replaceChildren(element("p", { class: "quiet" }, live ? "Nothing. Click or drag a plug, a clip, a handle or any point of a cable, or click an obstacle; N chooses the next constraint, O the next obstacle." : "Nothing. Click a constraint, an obstacle or a point of a cable; N chooses the next constraint."));
      return;
    }
    if (chosen.is === "point") {
      const { branch, s } = chosen;
      const index = branchOf(scene, branch);
      this.chosen.replaceChildren(
        element("p", {}, element("strong", {}, branch), ` at s = ${millimetres(s)}`),
        ...identity(scene.branches[index]?.identity ?? null),
        this.facts,
        ...(live ? [element("div", { class: "buttons" }, button("Hold", "Adds a handle here (H)", () => this.hands.hold(branch, s, "handle")), button("Pin", "Held as it is: position, tangent and twist (P)", () => this.hands.hold(branch, s, "pin")), button("Clip", "A clip closes here: position and tangent (C)", () => this.hands.hold(branch, s, "collar")))] : []),
      );
      if (index >= 0) this.lookAt(index);
    } else if (chosen.is === "obstacle") {
      const acts = [button("Move", "Arrows to move it (G)", () => this.wishes.toggleGizmo("translate")), button("Turn", "Rings to rotate it (R)", () => this.wishes.toggleGizmo("rotate")), button("Delete", "Deletes it from the text (Delete)", () => this.hands.release())];
      this.chosen.replaceChildren(element("p", {}, element("strong", {}, chosen.name), element("span", { class: "quiet" }, " obstacle")), this.facts, ...(live ? [element("div", { class: "buttons" }, ...acts)] : []));
    } else {
      const constraint = this.hands.constraint()!;
      const parts: (Node | string)[] = [element("p", {}, element("strong", {}, constraint.name), element("span", { class: "quiet" }, ` ${constraint.kind}${constraint.place ? ` on ${constraint.place[0]}` : ""}`)), ...identity(constraint.identity), this.facts];
      if (live) {
        this.acts = element(
          "div",
          {},
          this.poseForm(constraint.name, constraint.moves, constraint.turns),
          element(
            "div",
            { class: "buttons" },
            constraint.moves && button("Move", "Arrows to move it (G)", () => this.wishes.toggleGizmo("translate")),
            constraint.turns && button("Turn", "Rings to rotate it (R)", () => this.wishes.toggleGizmo("rotate")),
            button("Pin", "Holds position, tangent and twist where they are (P)", () => this.hands.pin()),
            button("Release", "Removes the constraint (Delete)", () => this.hands.release()),
          ),
        );
        parts.push(this.acts, this.sensitivities);
      }
      this.chosen.replaceChildren(...parts);
      const point = this.hands.chosenPoint();
      if (point) this.lookAt(point.branch);
    }
    this.showFrame();
  }

  private poseForm(name: string, moves: boolean, turns: boolean): HTMLElement {
    const field = (words: string, of: HTMLInputElement[], disabled: boolean) => {
      const input = element("input", { type: "text", inputmode: "decimal", autocomplete: "off", disabled });
      of.push(input);
      return element("label", {}, words, input);
    };
    const fields = { position: [] as HTMLInputElement[], angles: [] as HTMLInputElement[] };
    const form = element(
      "form",
      { "aria-label": `Pose of ${name}` },
      element("div", { class: "pose" }, ...["x, mm", "y, mm", "z, mm"].map((words) => field(words, fields.position, !moves))),
      turns && element("div", { class: "pose", title: "Rotated about the world's x, then y, then z" }, ...["about x, °", "about y, °", "about z, °"].map((words) => field(words, fields.angles, false))),
      element("button", { type: "submit", disabled: !moves && !turns }, "Move there"),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const read = (input: HTMLInputElement) => Number(input.value.trim().replace("−", "-").replace(",", "."));
      const wrong = [...fields.position, ...fields.angles].find((input) => input.value.trim() === "" || !Number.isFinite(read(input)));
      for (const input of [...fields.position, ...fields.angles]) input.setCustomValidity("");
      if (wrong) {
        wrong.setCustomValidity("a number is wanted");
        wrong.reportValidity();
        return;
      }
      const at = this.hands.at(name);
      if (!at) return;
      const position = fields.position.map((input) => read(input) / 1000) as [number, number, number];
      const angles = fields.angles.map((input) => (read(input) * Math.PI) / 180);
      const q = new THREE.Quaternion();
      if (turns) q.setFromEuler(new THREE.Euler(angles[0], angles[1], angles[2], "ZYX"));
      const pose: Placed = { position, orientation: turns ? [q.w, q.x, q.y, q.z] : at.at.orientation };
      this.hands.bring(name, pose, turns);
    });
    this.fields = fields;
    return form;
  }

  private showFacts(scene: Scene, frame: Frame): void {
    const chosen = this.hands.chosen;
    if (!this.facts || !chosen) return;
    const facts: [string, string][] = [];
    if (chosen.is === "point") {
      const point = this.hands.chosenPoint();
      if (!point) return;
      const { position } = along(frame, scene, point.branch, point.s);
      facts.push(["at", components(position, "m", 4)]);
      for (const quantity of QUANTITIES) {
        facts.push([quantity.name === "bend" ? "bend radius" : quantity.label.toLowerCase(), inWords(quantity, valueAt(frame, scene, point.branch, point.s, quantity.column))]);
      }
    } else if (chosen.is === "obstacle") {
      const at = frame.header.obstacles[scene.obstacles.findIndex(({ name }) => name === chosen.name)];
      if (at) facts.push(["at", components(at.at.position, "m", 4)], ["force on the harness", newtons(Math.hypot(...at.force))], ["contact points", String(at.contacts)]);
    } else {
      const at = this.hands.at(chosen.name);
      if (this.acts) this.acts.hidden = !at;
      if (!at) facts.push(["", "does not act in this frame"]);
      else {
        facts.push(["force", `${newtons(Math.hypot(...at.force))}, ${components(at.force, "N")}`]);
        facts.push(["moment", `${moment(Math.hypot(...at.moment))}, ${components(at.moment, "N m")}`]);
        const holder = this.store.session?.held.find(([name]) => name === chosen.name);
        if (holder) facts.push(["held by", holder[1] === this.store.session!.you ? "this page" : `another page (${holder[1]})`]);
        if (at.slid_to !== null) facts.push(["slides", `cable at s = ${millimetres(at.slid_to)}`]);
        this.showPose(at);
      }
    }
    this.facts.replaceChildren(...facts.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]));
  }

  private showPose(at: ConstraintFrame): void {
    const fields = this.fields;
    if (!fields || [...fields.position, ...fields.angles].includes(document.activeElement as HTMLInputElement)) return;
    at.at.position.forEach((x, i) => (fields.position[i].value = (x * 1000).toFixed(2)));
    if (!fields.angles.length) return;
    const [w, x, y, z] = at.at.orientation;
    const angles = new THREE.Euler().setFromQuaternion(new THREE.Quaternion(x, y, z, w), "ZYX");
    [angles.x, angles.y, angles.z].forEach((angle, i) => (fields.angles[i].value = ((angle * 180) / Math.PI).toFixed(2)));
  }

  // Plots

  lookAt(branch: number): void {
    this.branch = branch;
    this.branchList.selectedIndex = branch;
    this.wishes.branchChosen(branch);
    this.showPlots();
  }

  ghost: Ghost | null = null;

  private showPlots(): void {
    const { scene, shown } = this.store;
    if (!scene || !shown || !scene.branches[this.branch] || !this.sections.get("plots")!.open) return;
    const branch = scene.branches[this.branch];
    const point = this.hands.chosenPoint();
    const at = this.pointed ?? (point && point.branch === this.branch ? point.s : null);
    const other = this.ghost ? this.ghost.scene.branches.findIndex((each) => each.name === branch.name) : -1;
    const before = this.ghost && other >= 0 ? nodesOf(this.ghost.scene, this.ghost.frame, other) : null;
    this.curves.forEach((curve, i) => {
      const value = at === null ? null : { s: at, value: valueAt(shown, scene, this.branch, at, PLOTTED[i].column) };
      curve.show(branch, nodesOf(scene, shown, this.branch), before, value);
    });
  }

  // Settings

  private showSettings(settings: Setting[]): void {
    const groups = new Map<string, Setting[]>();
    for (const setting of settings) groups.set(setting.group, [...(groups.get(setting.group) ?? []), setting]);
    const few = groups.size <= 8;
    const folded = [...groups].map(([group, members]) =>
      element("details", { open: few }, element("summary", {}, element("strong", {}, group)), ...members.map((setting) => this.setting(setting))),
    );
    const search = element("input", { type: "search", placeholder: "Search: a joint, a section, a value", "aria-label": "Search settings" });
    search.addEventListener("input", () => {
      const words = search.value.trim().toLowerCase();
      for (const group of folded) {
        group.hidden = words !== "" && !(group.textContent ?? "").toLowerCase().includes(words);
        group.open = words === "" ? few : group.querySelector("summary")!.textContent!.toLowerCase().includes(words);
      }
    });
    this.settings.replaceChildren(element("p", { class: "quiet" }, "A change restarts the computation; the previous shape stays as a ghost."), ...(few ? [] : [search]), ...folded);
  }

  /** The server did not take a value: the fields show again what holds. */
  refused(): void {
    if (this.store.shown) this.showValues(this.store.shown.header.mechanism_values);
    if (this.store.scene) this.showSettings(this.store.scene.settings);
  }

  private setting(setting: Setting): HTMLElement {
    const form = setting.form;
    const set = (value: unknown) => {
      this.wishes.beforeSetting();
      this.link.send({ do: "set", key: setting.key, value });
    };
    let field: HTMLElement;
    let unit = "";
    if (form.is === "choice") {
      const given = form.words.some(([word]) => word === setting.value);
      const list = element("select", {}, !given && element("option", { value: "" }, setting.value === null ? "not given" : String(setting.value)), ...form.words.map(([word, doc]) => element("option", { value: word, title: doc }, word)));
      list.value = given ? String(setting.value) : "";
      list.addEventListener("change", () => list.value !== "" && set(list.value));
      field = list;
    } else if (form.is === "flag") {
      const box = element("input", { type: "checkbox" });
      box.checked = setting.value === true;
      box.addEventListener("change", () => set(box.checked));
      field = box;
    } else {
      const least = form.minimum;
      const input = element("input", { type: "number", step: form.is === "count" ? 1 : "any", min: least ?? undefined, max: (form.is === "number" ? form.maximum : null) ?? undefined, placeholder: "not given" });
      if (typeof setting.value === "number") input.value = String(setting.value);
      else if (setting.value !== null) input.placeholder = String(setting.value);
      input.addEventListener("change", () => {
        if (input.value.trim() === "" || !input.reportValidity()) return;
        set(Number(input.value));
      });
      if (form.is === "number") unit = form.unit;
      field = input;
    }
    return element("label", { class: "setting", title: setting.doc }, element("span", {}, setting.label.replaceAll("_", " ")), element("span", { class: "field" }, field, unit && element("span", { class: "quiet" }, unit)));
  }

  // The ghost

  showGhost(ghost: Ghost | null, found: Difference | null): void {
    this.ghost = ghost;
    const parts: (Node | false)[] = [
      element("div", { class: "buttons" }, element("button", { title: "The shape shown now stays as a ghost (K)", onclick: () => this.wishes.keepGhost() }, "Keep this shape"), ghost !== null && element("button", { onclick: () => this.wishes.forgetGhost() }, "Forget it")),
    ];
    if (ghost) parts.push(element("p", { class: "quiet" }, `Ghost: ${ghost.words}`));
    if (ghost && found) {
      const bend = (t: Difference["tightest"]["is"]) => (t ? `${millimetres(t.radius, 3)} on ${t.branch}` : "–");
      const facts: [string, string | Node][] = [
        ["largest distance", element("button", { class: "plain", onclick: () => this.wishes.visit(found.position) }, `${millimetres(found.greatest, 3)} on ${found.branch} at s = ${millimetres(found.s, 3)}`)],
        ["mean distance", millimetres(found.mean, 3)],
        ["tightest bend", `${bend(found.tightest.was)} → ${bend(found.tightest.is)}`],
      ];
      parts.push(element("dl", { class: "facts", id: "difference" }, ...facts.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)])));
    }
    this.comparison.replaceChildren(...parts.filter((part): part is Node => part !== false));
  }
}
