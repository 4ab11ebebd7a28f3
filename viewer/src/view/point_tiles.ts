// SPDX-License-Identifier: Apache-2.0
// Millions of returns: sorted into squares of the map once; a square is painted into a picture in the fineness that
// the zoom asks for when it first comes into view. So a frame costs some pictures, however many returns there are.
import type { Camera } from "./camera.js";
import { type Colour, Picture, type Stage } from "./gpu.js";
import { kFinest, levelFor, visible } from "./squares.js";

const kTile = 512; // cells a side
const kMostPictures = 72;
const kPicturesAFrame = 3;

export class PointTiles {
  private xy: Float32Array = new Float32Array(0);
  private readonly pictures = new Map<string, Picture | undefined>();
  private sorted = new Map<number, { order: Uint32Array; starts: Map<number, [number, number]> }>();

  constructor(private readonly stage: Stage) {}

  get count(): number {
    return this.xy.length / 2;
  }

  /// x, y in m; the array is kept.
  set(xy: Float32Array): void {
    this.xy = xy;
    this.sorted.clear();
    for (const picture of this.pictures.values()) picture?.destroy();
    this.pictures.clear();
  }

  /// True: some squares are still to be painted; draw again.
  draw(camera: Camera, low: Colour, high: Colour): boolean {
    if (this.count === 0) return false;
    const level = levelFor(camera.scale * this.stage.renderer.resolution);
    const side = kTile * kFinest * 2 ** level;
    let left = kPicturesAFrame;
    let more = false;
    for (const [i, j] of visible(camera, side)) {
      const name = `${level}/${i}/${j}`;
      if (!this.pictures.has(name)) {
        if (left === 0) {
          more = true;
          continue;
        }
        --left;
        this.pictures.set(name, this.paint(level, side, i, j));
      }
      const picture = this.pictures.get(name);
      // Taken out and put in again: the map of pictures is ordered by their last use.
      this.pictures.delete(name);
      this.pictures.set(name, picture);
      picture?.draw(low, high);
    }
    this.forgetOld();
    return more;
  }

  private forgetOld(): void {
    for (const [name, picture] of this.pictures) {
      if (this.pictures.size <= kMostPictures) return;
      picture?.destroy();
      this.pictures.delete(name);
    }
  }

  private paint(level: number, side: number, i: number, j: number): Picture | undefined {
    const { order, starts } = this.sort(level, side);
    const range = starts.get(key(i, j));
    if (!range) return undefined;
    const cells = new Uint8Array(2 * kTile * kTile);
    const perMetre = kTile / side;
    for (let k = range[0]; k < range[1]; ++k) {
      const point = order[k] ?? 0;
      const column = Math.min(kTile - 1, Math.floor(((this.xy[2 * point] ?? 0) - i * side) * perMetre));
      const row = Math.min(kTile - 1, Math.floor(((this.xy[2 * point + 1] ?? 0) - j * side) * perMetre));
      const at = 2 * (row * kTile + column);
      // The first return is plainly seen, many are darker.
      const seen = cells[at + 1] ?? 0;
      const now = seen === 0 ? 110 : Math.min(255, seen + 12);
      cells[at] = now > 110 ? now - 110 : 0;
      cells[at + 1] = now;
    }
    const [x0, y0, x1, y1] = [i * side, j * side, (i + 1) * side, (j + 1) * side];
    return new Picture(this.stage, cells, kTile, kTile, [x0, y0, x1, y0, x0, y1, x1, y1], false);
  }

  /// Points by square, by counting.
  private sort(level: number, side: number): { order: Uint32Array; starts: Map<number, [number, number]> } {
    const known = this.sorted.get(level);
    if (known) return known;
    const { xy, count } = this;
    const slots = new Map<number, number>();
    const counts: number[] = [];
    const slotOf = new Uint32Array(count);
    for (let k = 0; k < count; ++k) {
      const name = key(Math.floor((xy[2 * k] ?? 0) / side), Math.floor((xy[2 * k + 1] ?? 0) / side));
      let slot = slots.get(name);
      if (slot === undefined) {
        slot = counts.length;
        slots.set(name, slot);
        counts.push(0);
      }
      slotOf[k] = slot;
      counts[slot] = (counts[slot] ?? 0) + 1;
    }
    const next: number[] = [];
    let sum = 0;
    for (const n of counts) {
      next.push(sum);
      sum += n;
    }
    const starts = new Map<number, [number, number]>();
    for (const [name, slot] of slots) starts.set(name, [next[slot] ?? 0, (next[slot] ?? 0) + (counts[slot] ?? 0)]);
    const order = new Uint32Array(count);
    for (let k = 0; k < count; ++k) {
      const slot = slotOf[k] ?? 0;
      order[next[slot] ?? 0] = k;
      next[slot] = (next[slot] ?? 0) + 1;
    }
    const out = { order, starts };
    if (this.sorted.size >= 3) this.sorted.clear();
    this.sorted.set(level, out);
    return out;
  }
}

const key = (i: number, j: number): number => (i + 1_000_000) * 4_000_000 + (j + 1_000_000);
