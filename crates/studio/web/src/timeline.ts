// The timeline: steps with their increments, marks of events, play and scrub.
import { byId, element, later } from "./dom";
import type { Store } from "./store";

/** Frames a second at speed 1. */
const PACE = 12;

export class TimelineBar {
  private play = element("button", { title: "Play or pause (Space)", onclick: () => this.toggle() }, "▶ Play");
  private speed = element("select", { "aria-label": "Speed", title: "Speed" }, ...["0.25", "0.5", "1", "2", "4"].map((speed) => element("option", { value: speed }, `${speed}×`)));
  /** Marks of events, over the track: a slider holds no buttons. */
  private marks = element("div", { class: "marks" });
  private track = element("div", { id: "track", role: "slider", tabindex: 0, "aria-label": "Frame" });
  private thumb = element("div", { class: "thumb" });
  private words = element("span", { id: "place" });
  private playing = false;
  private clock = 0;
  /** Where each frame lies, 0 to 1; steps that are still to come have their room. */
  private total = 1;
  private starts: number[] = [];

  constructor(private store: Store) {
    const button = (words: string, title: string, act: () => void) => element("button", { title, "aria-label": title, onclick: act }, words);
    this.speed.value = "1";
    byId("timeline").append(
      element("div", { class: "buttons" }, button("|◀", "To the start (Home)", () => this.go(0)), button("−1", "One frame back (,)", () => this.go(this.store.wanted - 1)), this.play, button("+1", "One frame on (.)", () => this.go(this.store.wanted + 1)), button("▶|", "To the newest (End)", () => this.go(Infinity)), this.speed),
      element("div", { id: "line" }, this.track, this.marks),
      this.words,
    );
    const scrub = (event: PointerEvent) => {
      const box = this.track.getBoundingClientRect();
      this.go(this.frameAt((event.clientX - box.left) / box.width));
    };
    this.track.addEventListener("pointerdown", (event) => {
      this.track.setPointerCapture(event.pointerId);
      scrub(event);
    });
    this.track.addEventListener("pointermove", (event) => {
      if (this.track.hasPointerCapture(event.pointerId)) scrub(event);
    });
    this.track.addEventListener("keydown", (event) => {
      const to = { ArrowLeft: store.wanted - 1, ArrowRight: store.wanted + 1, ArrowDown: store.wanted - 1, ArrowUp: store.wanted + 1, PageDown: store.wanted - 10, PageUp: store.wanted + 10, Home: 0, End: Infinity }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      event.stopPropagation();
      this.go(to);
    });
    store.on("timeline", later(() => this.lay()));
    store.on("shown", () => this.mark());
  }

  go(frame: number): void {
    this.pause();
    this.store.scrub(Math.min(this.store.newest(), Math.max(0, frame)));
    this.mark();
  }

  /** The end of the step before or after. */
  step(by: number): void {
    const ends = this.store.timeline.steps.filter((step) => step.frames > 0).map((step) => step.first + step.frames - 1);
    const now = this.store.wanted;
    this.go(by > 0 ? (ends.find((end) => end > now) ?? Infinity) : (ends.filter((end) => end < now).pop() ?? 0));
  }

  toggle(): void {
    if (this.playing) return this.pause();
    if (this.store.wanted >= this.store.newest()) this.store.scrub(0);
    this.playing = true;
    this.store.following = false;
    this.play.textContent = "❚❚ Pause";
    let begun = performance.now();
    const tick = (now: number) => {
      if (!this.playing) return;
      const due = Math.floor(((now - begun) / 1000) * PACE * Number(this.speed.value));
      if (due > 0) {
        begun = now;
        const next = Math.min(this.store.newest(), this.store.wanted + Math.min(due, 8));
        this.store.scrub(next);
        this.mark();
        if (next >= this.store.newest()) return this.pause();
      }
      this.clock = requestAnimationFrame(tick);
    };
    this.clock = requestAnimationFrame(tick);
  }

  pause(): void {
    cancelAnimationFrame(this.clock);
    this.playing = false;
    this.play.textContent = "▶ Play";
  }

  private lay(): void {
    const { steps, events } = this.store.timeline;
    this.starts = [];
    this.total = 0;
    for (const step of steps) {
      this.starts.push(this.total);
      this.total += Math.max(step.frames, step.planned, 1);
    }
    this.total = Math.max(1, this.total);
    const percent = (part: number) => `${((100 * part) / this.total).toFixed(3)}%`;
    const boxes = steps.map((step, i) => {
      const room = Math.max(step.frames, step.planned, 1);
      const done = element("div", { class: "done" });
      done.style.width = `${((100 * step.frames) / room).toFixed(2)}%`;
      const classes = ["step", ...(step.by_hand ? ["hand"] : []), ...(room / this.total < 0.02 ? ["narrow"] : [])];
      const box = element("div", { class: classes.join(" "), title: step.name }, step.name, done);
      box.style.left = percent(this.starts[i]);
      box.style.width = percent(room);
      return box;
    });
    const marks = events.map((event) => {
      const mark = element("button", { class: "mark", title: event.message, "aria-label": `${event.message}, frame ${event.frame}`, onclick: () => this.go(event.frame) }, "▼");
      mark.style.left = percent(this.placeOf(event.frame));
      return mark;
    });
    this.track.replaceChildren(...boxes, this.thumb);
    this.marks.replaceChildren(...marks);
    this.mark();
  }

  private stepOf(frame: number): number {
    const { steps } = this.store.timeline;
    let found = 0;
    for (let i = 0; i < steps.length; i++) if (steps[i].frames > 0 && steps[i].first <= frame) found = i;
    return found;
  }

  private placeOf(frame: number): number {
    const step = this.stepOf(frame);
    return (this.starts[step] ?? 0) + frame - (this.store.timeline.steps[step]?.first ?? 0) + 0.5;
  }

  private frameAt(part: number): number {
    const place = Math.min(Math.max(0, part), 1) * this.total;
    const { steps } = this.store.timeline;
    let frame = 0;
    for (let i = 0; i < steps.length; i++) {
      if (steps[i].frames > 0 && this.starts[i] <= place) frame = steps[i].first + Math.min(steps[i].frames - 1, Math.floor(place - this.starts[i]));
    }
    return frame;
  }

  private mark(): void {
    const { steps } = this.store.timeline;
    const frame = this.store.wanted;
    const at = this.stepOf(frame);
    this.thumb.style.left = `${((100 * this.placeOf(frame)) / this.total).toFixed(3)}%`;
    this.track.querySelectorAll(".step").forEach((box, i) => box.classList.toggle("now", i === at));
    const step = steps[at];
    const within = this.store.shown?.header.increment === 0 ? "the start" : step ? `${frame - step.first + 1} of ${Math.max(step.frames, step.planned)} of the step` : "";
    this.words.textContent = `frame ${frame} of ${this.store.newest()}\n${within}`;
    this.track.setAttribute("aria-valuemin", "0");
    this.track.setAttribute("aria-valuemax", String(this.store.newest()));
    this.track.setAttribute("aria-valuenow", String(frame));
    this.track.setAttribute("aria-valuetext", step ? `frame ${frame}, ${step.name}` : `frame ${frame}`);
  }
}
