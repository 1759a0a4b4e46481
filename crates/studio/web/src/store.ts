// What the page knows: scene, timeline, session, and the frames it has got; which of them is shown.
import { Emitter } from "./emitter";
import { fits, type Frame } from "./frame";
import type { Contents, Document, Imported, Notice, NotOpened, OfferedDraft, Scene, Sensitivities, Session, Sheet, StartPage, TextFault, Timeline } from "./protocol";

interface Events {
  scene: Scene;
  timeline: Timeline;
  sheet: Sheet;
  session: Session;
  sensitivities: Sensitivities;
  /** Another frame is to be seen. */
  shown: Frame;
  /** A frame is to be seen that is not here. */
  missed: number;
  refused: { message: string; help: string };
  saved: { name: string; text: string };
  document: Document;
  /** Faults of a text that was checked; the number is null for one that was to be applied. */
  checked: { number: number | null; faults: TextFault[] };
  /** The scenario has been written into a file of this name. */
  stored: string;
  /** It was not written, because that would replace what is there. */
  conflict: { name: string; own: boolean };
  /** Another program has changed the file. */
  outside: string;
  /** What earlier sessions left unsaved, the newest first; empty: there is no such thing (any more). */
  drafts: OfferedDraft[];
  /** There is no session yet: what can be opened. */
  start_page: StartPage;
  /** Modules and variants of a file that is to be imported. */
  contents: Contents;
  /** Why nothing was opened. */
  not_opened: NotOpened;
  /** What the import of the scenario has found. */
  imported: Imported;
}

/** Bytes of frames that are kept; beyond it those farthest from the one shown go, and are asked for anew when needed. */
const KEPT = 256 * 1024 * 1024;

export class Store extends Emitter<Events> {
  scene: Scene | null = null;
  timeline: Timeline = { frames: 0, steps: [], events: [] };
  sheet: Sheet | null = null;
  session: Session | null = null;
  document: Document | null = null;
  shown: Frame | null = null;
  /** Number of the frame that is to be seen, whether it is here yet or not. */
  wanted = 0;
  /** Whether the newest frame is shown as it comes. */
  following = true;
  private frames = new Map<number, Frame>();
  private bytes = 0;
  /** Frames that were asked for and did not come: the server keeps some of very long runs only. */
  private absent = new Set<number>();

  take(notice: Notice): void {
    switch (notice.is) {
      case "scene": {
        const another = this.scene === null || this.scene.run !== notice.run || this.scene.name !== notice.name;
        if (another) {
          this.forget();
          this.wanted = 0;
          this.following = true;
        }
        if (this.shown && (another || !fits(this.shown, notice))) this.shown = null;
        // A name that was let go may act again, as another constraint: the later one counts.
        const constraints = [...new Map(notice.constraints.map((constraint) => [constraint.name, constraint])).values()];
        this.scene = { ...notice, constraints };
        this.tell("scene", this.scene);
        break;
      }
      case "timeline":
        this.timeline = notice;
        for (const [number, frame] of this.frames) {
          if (number >= notice.frames) {
            this.frames.delete(number);
            this.bytes -= frame.bytes;
          }
        }
        for (const number of this.absent) if (number >= notice.frames) this.absent.delete(number);
        if (this.wanted >= notice.frames) {
          this.following = true;
          this.wanted = Math.max(0, notice.frames - 1);
        }
        this.tell("timeline", notice);
        this.show(this.following ? Math.max(0, notice.frames - 1) : this.wanted);
        break;
      case "sheet":
        this.sheet = notice;
        this.tell("sheet", notice);
        break;
      case "session":
        this.session = notice;
        this.tell("session", notice);
        break;
      case "sensitivities":
        this.tell("sensitivities", notice);
        break;
      case "refused":
        this.tell("refused", notice);
        break;
      case "saved":
        this.tell("saved", notice);
        break;
      case "drafts":
        this.tell("drafts", notice.drafts);
        break;
      case "document":
        this.document = notice;
        this.tell("document", notice);
        break;
      case "checked":
        this.tell("checked", notice);
        break;
      case "stored":
        this.tell("stored", notice.name);
        break;
      case "conflict":
        this.tell("conflict", notice);
        break;
      case "outside":
        this.tell("outside", notice.name);
        break;
      case "start_page":
        this.tell("start_page", notice);
        break;
      case "contents":
        this.tell("contents", notice);
        break;
      case "not_opened":
        this.tell("not_opened", notice);
        break;
      case "imported":
        this.tell("imported", notice);
        break;
      case "replay":
        // Its data are in the page of the same address.
        location.reload();
        break;
    }
  }

  takeFrame(frame: Frame): void {
    if (!this.scene || !fits(frame, this.scene)) return;
    const number = frame.header.frame;
    const old = this.frames.get(number);
    if (old) this.bytes -= old.bytes;
    this.frames.set(number, frame);
    this.absent.delete(number);
    this.bytes += frame.bytes;
    if (number >= this.timeline.frames) this.timeline = { ...this.timeline, frames: number + 1 };
    this.makeRoom();
    if (this.following && number >= this.wanted) this.show(number);
    else if (number === this.wanted) this.show(number);
  }

  /** Connects anew: everything will be sent again. */
  forget(): void {
    this.frames.clear();
    this.absent.clear();
    this.bytes = 0;
  }

  /** These were asked for, and what has not come will not come. */
  giveUp(from: number, to: number): void {
    for (let number = from; number < Math.min(to, this.timeline.frames); number++) if (!this.frames.has(number)) this.absent.add(number);
    this.show(this.wanted);
  }

  /** All frames that are here. */
  kept(): Iterable<Frame> {
    return this.frames.values();
  }

  has(number: number): boolean {
    return this.frames.has(number);
  }

  newest(): number {
    return Math.max(0, this.timeline.frames - 1);
  }

  /** Shows a frame: now, if it is here, else when it comes; the one before in the place of one that will not come. */
  show(number: number): void {
    this.wanted = Math.min(Math.max(0, number), this.newest());
    let nearest = this.wanted;
    while (nearest > 0 && this.absent.has(nearest)) nearest--;
    const frame = this.frames.get(nearest);
    if (frame && frame !== this.shown) {
      this.shown = frame;
      this.tell("shown", frame);
    }
  }

  /** Goes there and stays there, or goes on following if it is the newest. */
  scrub(number: number): void {
    this.following = number >= this.newest();
    this.show(number);
    if (this.isMissing(this.wanted)) this.tell("missed", this.wanted);
  }

  /** The first run of frames that are missing, near the one that is wanted first; none if all are here or there is no room. */
  missing(): { from: number; to: number } | null {
    const total = this.timeline.frames;
    if (total === 0) return null;
    const run = (from: number) => {
      let to = from;
      while (to < total && this.isMissing(to) && to - from < 64) to++;
      return { from, to };
    };
    if (this.isMissing(this.wanted)) return run(this.wanted);
    if (this.bytes > KEPT * 0.9) return null;
    for (let number = 0; number < total; number++) if (this.isMissing(number)) return run(number);
    return null;
  }

  /** Whether a frame is to be asked for. */
  isMissing(number: number): boolean {
    return number < this.timeline.frames && !this.frames.has(number) && !this.absent.has(number);
  }

  private makeRoom(): void {
    while (this.bytes > KEPT && this.frames.size > 2) {
      let farthest = -1;
      let distance = -1;
      for (const number of this.frames.keys()) {
        if (Math.abs(number - this.wanted) > distance) {
          distance = Math.abs(number - this.wanted);
          farthest = number;
        }
      }
      this.bytes -= this.frames.get(farthest)!.bytes;
      this.frames.delete(farthest);
    }
  }
}
