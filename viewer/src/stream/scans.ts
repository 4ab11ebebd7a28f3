// SPDX-License-Identifier: Apache-2.0
// Ranges of all scans in 16 bits each: every scan has the finest step of length that its longest range allows.
import { grown } from "./columns.js";

export interface Scan {
  laser: number; ///< index in the run's lasers
  angleMin: number; ///< rad
  increment: number; ///< rad
  ranges: ArrayLike<number>; ///< m; infinite: no return, NaN: invalid
}

const kPage = 1 << 20;
const kNoReturn = 65535;
const kInvalid = 65534;
const kLargest = 65533;
const kFinest = 0.0005; // m

/// Step in m: 0.5 mm, 1 mm, 2 mm ... so that the longest range fits.
export function stepFor(longest: number): number {
  let step = kFinest;
  while (longest / step > kLargest) step *= 2;
  return step;
}

export class Scans {
  count = 0;
  beams = 0; ///< of all scans together
  private pages: Uint16Array[] = [];
  private used = 0;
  private starts = new Float64Array(0); ///< of a scan number: 1 + place of its first beam in all pages
  private counts = new Uint32Array(0);
  private steps = new Float32Array(0);
  private angles = new Float32Array(0); ///< first angle, increment
  private lasers = new Uint8Array(0);

  has(scan: number): boolean {
    return scan < this.starts.length && (this.starts[scan] ?? 0) > 0;
  }
  laser(scan: number): number {
    return this.lasers[scan] ?? 0;
  }
  bytes(): number {
    return this.pages.length * kPage * 2 + this.starts.byteLength + this.counts.byteLength + this.steps.byteLength + this.angles.byteLength + this.lasers.byteLength;
  }

  set(number: number, scan: Scan): void {
    const beams = scan.ranges.length;
    if (beams > kPage) throw new Error(`a scan of ${beams} beams`);
    this.reserve(number + 1);
    if (!this.has(number)) ++this.count;
    if (!this.has(number) || this.counts[number] !== beams) this.place(number, beams);
    this.lasers[number] = scan.laser;
    this.angles[2 * number] = scan.angleMin;
    this.angles[2 * number + 1] = scan.increment;
    this.write(number, scan.ranges);
  }

  /// Returns of one scan as x, y in the laser's frame (m), written from `at` on; the number of values written.
  points(number: number, out: Float32Array, at = 0): number {
    if (!this.has(number)) return 0;
    const start = (this.starts[number] ?? 1) - 1;
    const page = this.pages[Math.floor(start / kPage)];
    if (!page) return 0;
    const first = start % kPage;
    const count = this.counts[number] ?? 0;
    const step = this.steps[number] ?? 0;
    const angleMin = this.angles[2 * number] ?? 0;
    const increment = this.angles[2 * number + 1] ?? 0;
    let n = at;
    for (let i = 0; i < count; ++i) {
      const code = page[first + i] ?? kInvalid;
      if (code >= kInvalid) continue;
      const angle = angleMin + i * increment;
      out[n++] = code * step * Math.cos(angle);
      out[n++] = code * step * Math.sin(angle);
    }
    return n - at;
  }

  beamsOf(number: number): number {
    return this.has(number) ? (this.counts[number] ?? 0) : 0;
  }

  private write(number: number, ranges: ArrayLike<number>): void {
    const start = (this.starts[number] ?? 1) - 1;
    const page = this.pages[Math.floor(start / kPage)];
    if (!page) return;
    let longest = 0;
    for (let i = 0; i < ranges.length; ++i) {
      const range = ranges[i] ?? NaN;
      if (Number.isFinite(range) && range > longest) longest = range;
    }
    const step = stepFor(longest);
    this.steps[number] = step;
    for (let i = 0; i < ranges.length; ++i) {
      const range = ranges[i] ?? NaN;
      page[(start % kPage) + i] = Number.isFinite(range) && range >= 0 ? Math.round(range / step) : Number.isNaN(range) ? kInvalid : kNoReturn;
    }
  }

  /// A scan lies within one page.
  private place(number: number, beams: number): void {
    const left = kPage - (this.used % kPage);
    if (this.pages.length === 0 || beams > left) {
      this.used = this.pages.length * kPage;
      this.pages.push(new Uint16Array(kPage));
    }
    this.starts[number] = this.used + 1;
    this.counts[number] = beams;
    this.used += beams;
    if (this.used % kPage === 0) this.pages.push(new Uint16Array(kPage));
    this.beams += beams;
  }

  private reserve(scans: number): void {
    if (scans <= this.starts.length) return;
    this.starts = grown(this.starts, scans);
    const room = this.starts.length;
    this.counts = grown(this.counts, room);
    this.steps = grown(this.steps, room);
    this.angles = grown(this.angles, 2 * room);
    this.lasers = grown(this.lasers, room);
  }
}
