// SPDX-License-Identifier: Apache-2.0
// Columns of numbers which grow geometrically; rows are ordered by the number of their scan.
import { type Covariance, type Pose, compose, inverse } from "./pose.js";

export interface Estimate {
  time: number; ///< s since 1970
  scan: number;
  key: number; ///< scan number of the key scan that it hangs on
  health: number; ///< 0 ok, 1 degraded, 2 lost
  isKey: boolean;
  score: number;
  milliseconds: number; ///< NaN: unknown
  particles: number;
  pose: Pose;
  covariance: Covariance;
  odometry: Pose; ///< NaN: none
  frontEnd: Pose; ///< NaN: none
}

/// As many values as wanted, the old ones kept.
export function grown<T extends Float64Array | Float32Array | Uint32Array | Int32Array | Uint8Array>(old: T, size: number): T {
  if (old.length >= size) return old;
  const make = old.constructor as new (size: number) => T;
  const out = new make(Math.max(size, 2 * old.length, 64));
  out.set(old);
  return out;
}

const kLargestScanNumber = 50_000_000; // what a broken stream may ask for

export class Estimates {
  size = 0;
  time = new Float64Array(0); ///< never falls from row to row
  scan = new Uint32Array(0);
  key = new Uint32Array(0);
  health = new Uint8Array(0);
  isKey = new Uint8Array(0);
  score = new Float32Array(0);
  milliseconds = new Float32Array(0);
  particles = new Uint32Array(0);
  poses = new Float64Array(0); ///< 3 a row
  covariances = new Float32Array(0); ///< 6 a row
  odometry = new Float64Array(0); ///< 3 a row
  frontEnd = new Float64Array(0); ///< 3 a row
  private inKey = new Float64Array(0); ///< T_key_robot from when the estimate came, 3 a row
  private rows = new Int32Array(0); ///< row + 1 of a scan number

  /// Row of that scan, or -1.
  row(scan: number): number {
    return scan < this.rows.length ? (this.rows[scan] ?? 0) - 1 : -1;
  }

  set(e: Estimate): void {
    if (e.scan > kLargestScanNumber) throw new Error(`scan number ${e.scan}`);
    const row = this.rowFor(e.scan);
    const before = row > 0 ? (this.time[row - 1] ?? 0) : -Infinity;
    this.time[row] = Math.max(before, e.time);
    this.scan[row] = e.scan;
    this.key[row] = e.key;
    this.health[row] = e.health;
    this.isKey[row] = e.isKey ? 1 : 0;
    this.score[row] = e.score;
    this.milliseconds[row] = e.milliseconds;
    this.particles[row] = e.particles;
    this.poses.set(e.pose, 3 * row);
    this.covariances.set(e.covariance, 6 * row);
    this.odometry.set(e.odometry, 3 * row);
    this.frontEnd.set(e.frontEnd, 3 * row);
    const keyRow = this.row(e.key);
    this.inKey.set(keyRow >= 0 ? compose(inverse(this.pose(keyRow)), e.pose) : [NaN, NaN, NaN], 3 * row);
  }

  pose(row: number): Pose {
    return three(this.poses, row);
  }
  covariance(row: number): Covariance {
    const at = 6 * row;
    const c = this.covariances;
    return [c[at] ?? 0, c[at + 1] ?? 0, c[at + 2] ?? 0, c[at + 3] ?? 0, c[at + 4] ?? 0, c[at + 5] ?? 0];
  }

  /// Key scans stand elsewhere now; what hangs on them moves along.
  moveKeys(scans: Uint32Array, poses: Float64Array): void {
    for (let i = 0; i < scans.length; ++i) {
      const row = this.row(scans[i] ?? 0);
      if (row >= 0) this.poses.set(poses.subarray(3 * i, 3 * i + 3), 3 * row);
    }
    for (let row = 0; row < this.size; ++row) {
      const keyRow = this.row(this.key[row] ?? 0);
      if (keyRow < 0 || keyRow === row || Number.isNaN(this.inKey[3 * row])) continue;
      this.poses.set(compose(this.pose(keyRow), three(this.inKey, row)), 3 * row);
    }
  }

  /// The last row that is not after the time; -1: all are.
  rowAt(time: number): number {
    let low = 0;
    let high = this.size;
    while (low < high) {
      const middle = (low + high) >> 1;
      if ((this.time[middle] ?? 0) <= time) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }

  private rowFor(scan: number): number {
    const known = this.row(scan);
    if (known >= 0) return known;
    this.reserve(this.size + 1, scan + 1);
    let row = this.size;
    while (row > 0 && (this.scan[row - 1] ?? 0) > scan) --row;
    if (row < this.size) this.shift(row);
    ++this.size;
    this.rows[scan] = row + 1;
    return row;
  }

  /// A late row: those after it move on (rare: streams are ordered).
  private shift(row: number): void {
    const { size } = this;
    for (const column of [this.time, this.scan, this.key, this.health, this.isKey, this.score, this.milliseconds, this.particles]) column.copyWithin(row + 1, row, size);
    for (const column of [this.poses, this.odometry, this.frontEnd, this.inKey]) column.copyWithin(3 * row + 3, 3 * row, 3 * size);
    this.covariances.copyWithin(6 * row + 6, 6 * row, 6 * size);
    for (let i = row + 1; i <= size; ++i) this.rows[this.scan[i] ?? 0] = i + 1;
  }

  private reserve(size: number, scans: number): void {
    this.rows = grown(this.rows, scans);
    if (size <= this.time.length) return;
    this.time = grown(this.time, size);
    const room = this.time.length;
    this.scan = grown(this.scan, room);
    this.key = grown(this.key, room);
    this.health = grown(this.health, room);
    this.isKey = grown(this.isKey, room);
    this.score = grown(this.score, room);
    this.milliseconds = grown(this.milliseconds, room);
    this.particles = grown(this.particles, room);
    this.poses = grown(this.poses, 3 * room);
    this.covariances = grown(this.covariances, 6 * room);
    this.odometry = grown(this.odometry, 3 * room);
    this.frontEnd = grown(this.frontEnd, 3 * room);
    this.inKey = grown(this.inKey, 3 * room);
  }
}

export function three(values: Float64Array | Float32Array, row: number): Pose {
  return [values[3 * row] ?? 0, values[3 * row + 1] ?? 0, values[3 * row + 2] ?? 0];
}
