// SPDX-License-Identifier: Apache-2.0
// Takes an MCAP stream apart (records, no chunks), however its bytes are cut.

export interface Message {
  topic: string;
  encoding: string; ///< "cdr" or "json"
  sequence: number;
  logTime: bigint; ///< ns
  data: Uint8Array;
}

const kMagic = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a];
const kHead = 9; // opcode u8, length u64
const kChannel = 0x04;
const kMessage = 0x05;
const kLargestRecord = 1 << 30;

export class McapReader {
  private rest = new Uint8Array(0);
  private magicSeen = false;
  private readonly channels = new Map<number, { topic: string; encoding: string }>();

  constructor(private readonly onMessage: (message: Message) => void) {}

  /// Bytes that follow those of the last call; whole messages in them are handed over.
  feed(bytes: Uint8Array): void {
    const all = this.rest.length === 0 ? bytes : join(this.rest, bytes);
    let at = 0;
    if (!this.magicSeen) {
      if (all.length < kMagic.length) return this.keep(all, 0);
      if (!kMagic.every((byte, i) => all[i] === byte)) throw new Error("the stream does not begin as MCAP does");
      this.magicSeen = true;
      at = kMagic.length;
    }
    const view = new DataView(all.buffer, all.byteOffset, all.byteLength);
    while (at + kHead <= all.length) {
      const size = Number(view.getBigUint64(at + 1, true));
      if (size > kLargestRecord) throw new Error(`an MCAP record of ${size} bytes`);
      if (at + kHead + size > all.length) break;
      this.record(all[at] ?? 0, all.subarray(at + kHead, at + kHead + size));
      at += kHead + size;
    }
    this.keep(all, at);
  }

  private keep(all: Uint8Array, at: number): void {
    this.rest = all.slice(at);
  }

  private record(opcode: number, content: Uint8Array): void {
    const view = new DataView(content.buffer, content.byteOffset, content.byteLength);
    if (opcode === kChannel) this.channel(view, content);
    if (opcode !== kMessage) return;
    const channel = this.channels.get(view.getUint16(0, true));
    if (!channel) return;
    const message = { ...channel, sequence: view.getUint32(2, true), logTime: view.getBigUint64(6, true), data: content.subarray(22) };
    this.onMessage(message);
  }

  private channel(view: DataView, content: Uint8Array): void {
    const text = (at: number): [string, number] => {
      const size = view.getUint32(at, true);
      return [new TextDecoder().decode(content.subarray(at + 4, at + 4 + size)), at + 4 + size];
    };
    const [topic, after] = text(4);
    const [encoding] = text(after);
    this.channels.set(view.getUint16(0, true), { topic, encoding });
  }
}

function join(a: Uint8Array, b: Uint8Array): Uint8Array {
  const out = new Uint8Array(a.length + b.length);
  out.set(a);
  out.set(b, a.length);
  return out;
}
