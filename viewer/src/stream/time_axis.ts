// SPDX-License-Identifier: Apache-2.0
// Time as the timeline shows it: pauses longer than 5 s take no room.

export const kLongestPause = 5; // s

export class TimeAxis {
  length = 0; ///< s without pauses
  gaps: { at: number; seconds: number }[] = []; ///< place on the axis, length of the pause
  private starts: number[] = []; ///< stretches without pause: first time, last time, place of the first
  private ends: number[] = [];
  private places: number[] = [];
  private rows = 0;
  private last = NaN;

  /// Times of all rows, never falling; only those after the last call's are looked at.
  extend(times: Float64Array, rows: number): void {
    if (rows < this.rows) this.clear();
    for (let row = this.rows; row < rows; ++row) this.add(times[row] ?? 0);
    this.rows = rows;
  }

  clear(): void {
    this.length = 0;
    this.gaps = [];
    this.starts = [];
    this.ends = [];
    this.places = [];
    this.rows = 0;
    this.last = NaN;
  }

  private add(time: number): void {
    const pause = time - this.last;
    if (!(pause <= kLongestPause)) {
      if (this.starts.length > 0) this.gaps.push({ at: this.length, seconds: pause });
      this.starts.push(time);
      this.ends.push(time);
      this.places.push(this.length);
    } else if (pause > 0) {
      this.length += pause;
      this.ends[this.ends.length - 1] = time;
    }
    this.last = Math.max(time, Number.isNaN(this.last) ? time : this.last);
  }

  /// Seconds since 1970 -> seconds on the axis; within a pause: where it lies.
  place(time: number): number {
    const i = lastNotAfter(this.starts, time);
    if (i < 0) return 0;
    return (this.places[i] ?? 0) + Math.min(time, this.ends[i] ?? 0) - (this.starts[i] ?? 0);
  }

  /// Seconds on the axis -> seconds since 1970.
  time(place: number): number {
    if (this.starts.length === 0) return 0;
    const i = Math.max(0, lastNotAfter(this.places, place));
    const start = this.starts[i] ?? 0;
    return Math.min(Math.max(start, start + place - (this.places[i] ?? 0)), this.ends[i] ?? start);
  }
}

function lastNotAfter(values: number[], value: number): number {
  let low = 0;
  let high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((values[middle] ?? 0) <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
