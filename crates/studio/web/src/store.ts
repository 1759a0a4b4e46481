// What the page knows: scene, timeline, session, and the frames it has got; which of them is shown.
import { Emitter } from "./emitter";
import { fits, type Frame } from "./frame";
import type { Notice, Scene, Session, Timeline } from "./protocol";

interface Events {
  scene: Scene;
  timeline: Timeline;
  session: Session;
  /** Another frame is to be seen. */
  shown: Frame;
  refused: { message: string; help: string };
  saved: { name: string; text: string };
  /** When what an earlier session left unsaved was kept; null: there is no such thing (any more). */
  draft: string | null;
}

/** Bytes of frames that are kept; beyond it those farthest from the one shown go, and are asked for anew when needed. */
const KEPT = 256 * 1024 * 1024;

export class Store extends Emitter<Events> {
  scene: Scene | null = null;
  timeline: Timeline = { frames: 0, steps: [], events: [] };
  session: Session | null = null;
  shown: Frame | null = null;
  /** Number of the frame that is to be seen, whether it is here yet or not. */
  wanted = 0;
  /** Whether the newest frame is shown as it comes. */
  following = true;
  private frames = new Map<number, Frame>();
  private bytes = 0;

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
        this.scene = notice;
        this.tell("scene", notice);
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
        if (this.wanted >= notice.frames) {
          this.following = true;
          this.wanted = Math.max(0, notice.frames - 1);
        }
        this.tell("timeline", notice);
        this.show(this.following ? Math.max(0, notice.frames - 1) : this.wanted);
        break;
      case "session":
        this.session = notice;
        this.tell("session", notice);
        break;
      case "refused":
        this.tell("refused", notice);
        break;
      case "saved":
        this.tell("saved", notice);
        break;
      case "draft":
        this.tell("draft", notice.written);
        break;
    }
  }

  takeFrame(frame: Frame): void {
    if (!this.scene || !fits(frame, this.scene)) return;
    const number = frame.header.frame;
    const old = this.frames.get(number);
    if (old) this.bytes -= old.bytes;
    this.frames.set(number, frame);
    this.bytes += frame.bytes;
    if (number >= this.timeline.frames) this.timeline = { ...this.timeline, frames: number + 1 };
    this.makeRoom();
    if (this.following && number >= this.wanted) this.show(number);
    else if (number === this.wanted) this.show(number);
  }

  /** Connects anew: everything will be sent again. */
  forget(): void {
    this.frames.clear();
    this.bytes = 0;
  }

  has(number: number): boolean {
    return this.frames.has(number);
  }

  frame(number: number): Frame | undefined {
    return this.frames.get(number);
  }

  newest(): number {
    return Math.max(0, this.timeline.frames - 1);
  }

  /** Shows a frame: now, if it is here, else when it comes. */
  show(number: number): void {
    this.wanted = Math.min(Math.max(0, number), this.newest());
    const frame = this.frames.get(this.wanted);
    if (frame && frame !== this.shown) {
      this.shown = frame;
      this.tell("shown", frame);
    }
  }

  /** Goes there and stays there, or goes on following if it is the newest. */
  scrub(number: number): void {
    this.following = number >= this.newest();
    this.show(number);
  }

  /** The first run of frames that are missing, near the one that is wanted first; none if all are here or there is no room. */
  missing(): { from: number; to: number } | null {
    const total = this.timeline.frames;
    if (total === 0) return null;
    const run = (from: number) => {
      let to = from;
      while (to < total && !this.frames.has(to) && to - from < 64) to++;
      return { from, to };
    };
    if (!this.frames.has(this.wanted)) return run(this.wanted);
    if (this.bytes > KEPT * 0.9) return null;
    for (let number = 0; number < total; number++) if (!this.frames.has(number)) return run(number);
    return null;
  }

  all(): Iterable<Frame> {
    return this.frames.values();
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
