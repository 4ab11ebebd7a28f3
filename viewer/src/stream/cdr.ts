// SPDX-License-Identifier: Apache-2.0
// Reads CDR (little-endian, as ROS 2 writes it): fields aligned to their size, counted after the 4 bytes of the head.

const kHead = 4;

export class CdrReader {
  private readonly view: DataView;
  private at = kHead;

  constructor(private readonly bytes: Uint8Array) {
    if (bytes.length < kHead || bytes[0] !== 0 || bytes[1] !== 1) throw new Error("not little-endian CDR");
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }

  private take(size: number, count = 1): number {
    // An empty array of 8-byte values takes no padding: nothing follows its count.
    const start = count === 0 ? this.at : this.at + ((size - ((this.at - kHead) % size)) % size);
    const end = start + size * count;
    if (end > this.bytes.length) throw new Error(`CDR ends at ${this.bytes.length}, ${end} needed`);
    this.at = end;
    return start;
  }

  u8(): number {
    return this.view.getUint8(this.take(1));
  }
  bool(): boolean {
    return this.u8() !== 0;
  }
  i32(): number {
    return this.view.getInt32(this.take(4), true);
  }
  u32(): number {
    return this.view.getUint32(this.take(4), true);
  }
  f32(): number {
    return this.view.getFloat32(this.take(4), true);
  }
  f64(): number {
    return this.view.getFloat64(this.take(8), true);
  }
  /// Seconds and nanoseconds -> nanoseconds since 1970.
  time(): bigint {
    const seconds = this.i32();
    return BigInt(seconds) * 1_000_000_000n + BigInt(this.u32());
  }
  string(): string {
    const count = this.u32();
    const start = this.take(1, count);
    return new TextDecoder().decode(this.bytes.subarray(start, start + Math.max(0, count - 1)));
  }

  u8s(): Uint8Array {
    const count = this.u32();
    const start = this.take(1, count);
    return this.bytes.subarray(start, start + count);
  }
  u32s(): Uint32Array {
    const count = this.u32();
    const start = this.take(4, count);
    return Uint32Array.from({ length: count }, (_, i) => this.view.getUint32(start + 4 * i, true));
  }
  i64s(): BigInt64Array {
    const count = this.u32();
    const start = this.take(8, count);
    const out = new BigInt64Array(count);
    for (let i = 0; i < count; ++i) out[i] = this.view.getBigInt64(start + 8 * i, true);
    return out;
  }
  f32s(count = this.u32()): Float32Array {
    const start = this.take(4, count);
    // A copy lands on an aligned start, which the platform's order (little-endian everywhere today) can read at once.
    return new Float32Array(this.bytes.slice(start, start + 4 * count).buffer);
  }
  f64s(count = this.u32()): Float64Array {
    const start = this.take(8, count);
    return new Float64Array(this.bytes.slice(start, start + 8 * count).buffer);
  }
}
