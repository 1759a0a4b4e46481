// Where notices and frames come from: a server behind a WebSocket, or the data of a replay that is part of the page.
import type { Notice, Request, Scene, Sheet, Timeline } from "./protocol";

export type LinkState = "connecting" | "open" | "lost" | "ended" | "replay";

/** With this code a server that ends closes its connections (RFC 6455, 7.4.1). */
const GOING_AWAY = 1001;
/** With this status a server answers whose token is another one. */
const FORBIDDEN = 403;

export interface Link {
  send(request: Request): void;
  start(): void;
}

export interface Receiver {
  notice(notice: Notice): void;
  frame(buffer: ArrayBuffer): void;
  state(state: LinkState): void;
  /** All of a replay has been read. */
  complete(): void;
}

/** Makes the link that this page has. */
export function link(receiver: Receiver): Link {
  const embedded = document.getElementById("replay")?.textContent?.trim() ?? "null";
  return embedded === "null" ? new Socket(receiver) : new Replay(embedded, receiver);
}

class Socket implements Link {
  private socket: WebSocket | null = null;
  private wait = 250;

  constructor(private receiver: Receiver) {}

  start(): void {
    const address = new URL("socket" + location.search, location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    address.hash = "";
    this.receiver.state("connecting");
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.wait = 250;
      this.receiver.state("open");
    };
    socket.onmessage = (message) => {
      if (typeof message.data === "string") this.receiver.notice(JSON.parse(message.data) as Notice);
      else this.receiver.frame(message.data as ArrayBuffer);
    };
    socket.onclose = (event) => {
      this.socket = null;
      if (event.code === GOING_AWAY) return this.receiver.state("ended");
      this.receiver.state("lost");
      setTimeout(() => void this.again(), this.wait);
      this.wait = Math.min(4000, this.wait * 2);
    };
    this.socket = socket;
  }

  /** Connects again, unless another session is there now: each has a token of its own. */
  private async again(): Promise<void> {
    const answer = await fetch(location.href, { method: "HEAD", cache: "no-store" }).catch(() => null);
    if (answer?.status === FORBIDDEN) this.receiver.state("ended");
    else this.start();
  }

  send(request: Request): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(request));
  }
}

/**
 * A page that replays a run holds a JSON string: base64 of gzip of blocks, each of a length (u32, little-endian, a multiple of 4) and so
 * many bytes. The first is JSON, `{"scene", "timeline", "sheet"}`, padded with spaces; the others are frames.
 */
class Replay implements Link {
  constructor(
    private text: string,
    private receiver: Receiver,
  ) {}

  start(): void {
    this.receiver.state("replay");
    void this.play();
  }

  private async play(): Promise<void> {
    const packed = Uint8Array.from(atob(JSON.parse(this.text) as string), (character) => character.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    const blocks = unpack(await new Response(stream).arrayBuffer());
    const head = JSON.parse(new TextDecoder().decode(blocks[0])) as { scene: Scene; timeline: Timeline; sheet: Sheet };
    this.receiver.notice({ is: "scene", ...head.scene, live: false, exports: [] });
    this.receiver.notice({ is: "timeline", ...head.timeline });
    this.receiver.notice({ is: "sheet", ...head.sheet });
    for (const block of blocks.slice(1)) this.receiver.frame(block);
    this.receiver.complete();
  }

  send(): void {}
}

/** Blocks of a length and so many bytes. */
export function unpack(buffer: ArrayBuffer): ArrayBuffer[] {
  const view = new DataView(buffer);
  const blocks: ArrayBuffer[] = [];
  for (let at = 0; at < buffer.byteLength; ) {
    const length = view.getUint32(at, true);
    if (at + 4 + length > buffer.byteLength) throw new Error(`a block of ${length} bytes at ${at} reaches beyond the end`);
    blocks.push(buffer.slice(at + 4, at + 4 + length));
    at += 4 + length;
  }
  return blocks;
}
