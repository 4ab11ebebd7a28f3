// SPDX-License-Identifier: Apache-2.0
// Where the stream comes from: a WebSocket, which is opened again when it breaks, or the page itself.

export type Link = "embedded" | "connecting" | "open" | "lost";

export interface SourceEvents {
  bytes(bytes: Uint8Array): void;
  text(text: string): void;
  link(link: Link, retryAt: number): void; ///< retryAt: ms since 1970, when lost
  restart(): void; ///< a new stream begins: from the magic on
}

export interface Source {
  send(text: string): boolean;
  retry(): void;
  close(): void;
}

const kFirstWait = 500; // ms
const kLongestWait = 15_000; // ms

export function connect(url: string, events: SourceEvents): Source {
  let socket: WebSocket | undefined;
  let wait = kFirstWait;
  let timer = 0;
  let closed = false;

  const open = (): void => {
    clearTimeout(timer);
    events.link("connecting", 0);
    const mine = new WebSocket(url);
    socket = mine;
    mine.binaryType = "arraybuffer";
    mine.onopen = () => {
      wait = kFirstWait;
      events.restart();
      events.link("open", 0);
    };
    mine.onmessage = (event: MessageEvent<ArrayBuffer | string>) => {
      if (typeof event.data === "string") events.text(event.data);
      else events.bytes(new Uint8Array(event.data));
    };
    mine.onclose = () => {
      if (closed || socket !== mine) return;
      events.link("lost", Date.now() + wait);
      timer = window.setTimeout(open, wait);
      wait = Math.min(2 * wait, kLongestWait);
    };
  };
  open();
  return {
    send: (text) => {
      if (socket?.readyState !== WebSocket.OPEN) return false;
      socket.send(text);
      return true;
    },
    retry: open,
    close: () => {
      closed = true;
      clearTimeout(timer);
      socket?.close();
    },
  };
}

/// base64 of gzip of the stream, in a script element of the page.
export async function decodeEmbedded(base64: string): Promise<Uint8Array> {
  const packed = Uint8Array.from(atob(base64.replace(/\s+/g, "")), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
