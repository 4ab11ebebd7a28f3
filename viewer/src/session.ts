// SPDX-License-Identifier: Apache-2.0
// What the person looks at: the time, what is selected, which tool is in the hand. The parts of the page read it and
// say `touch()` when they changed it.
import type { Commands } from "./stream/commands.js";
import { Model } from "./stream/model.js";
import type { Link } from "./stream/source.js";
import { TimeAxis } from "./stream/time_axis.js";

export type Tool = "look" | "measure" | "erase-box" | "erase" | "wall" | "forbidden" | "crop" | "turn" | "start_pose" | "kidnap";

export const kSpeeds = [0.5, 1, 2, 5, 10, 20, 50, 100] as const;

export class Session {
  readonly model = new Model();
  readonly axis = new TimeAxis();
  time = 0; ///< s since 1970
  playing = false;
  speed = 10;
  loop = false;
  live = false; ///< sticks to the newest
  follow = false;
  selected = -1; ///< row of the estimate that was asked for
  closure = -1; ///< index in the model's closures
  tool: Tool = "look";
  link: Link = "embedded";
  retryAt = 0;
  night = false;
  version = 0;

  constructor(readonly commands: Commands) {}

  /// As at the start, at the end of what there is.
  reset(): void {
    Object.assign(this, { playing: false, speed: 10, loop: false, live: false, follow: false, selected: -1, closure: -1, tool: "look", night: false });
    this.goToRow(this.model.estimates.size - 1);
    this.touch();
  }

  touch(): void {
    ++this.version;
  }

  /// Row of the estimate at the present time, -1: none yet.
  row(): number {
    return this.model.estimates.rowAt(this.time);
  }

  may(command: string): boolean {
    return this.link === "open" && this.model.run.may.includes(command);
  }

  /// Beginning of the run as the layers count their times.
  epoch(): number {
    return this.model.estimates.time[0] ?? 0;
  }

  goTo(time: number): void {
    this.time = time;
    this.live = false;
    this.touch();
  }

  goToRow(row: number): void {
    const { estimates } = this.model;
    if (row < 0 || row >= estimates.size) return;
    this.goTo(estimates.time[row] ?? 0);
  }

  step(rows: number): void {
    this.playing = false;
    const { size } = this.model.estimates;
    this.goToRow(Math.min(size - 1, Math.max(0, this.row() + rows)));
  }

  play(on: boolean): void {
    if (on && this.axis.place(this.time) >= this.axis.length - 1e-6) this.time = this.axis.time(0);
    this.playing = on;
    if (on) this.live = false;
    this.touch();
  }

  /// Time moves on by so many seconds of the clock on the wall.
  advance(seconds: number): void {
    const { estimates } = this.model;
    this.axis.extend(estimates.time, estimates.size);
    if (this.live && estimates.size > 0) {
      const newest = estimates.time[estimates.size - 1] ?? 0;
      if (newest !== this.time) this.touch();
      this.time = newest;
      return;
    }
    if (estimates.size > 0 && this.time < this.epoch()) this.time = this.epoch();
    if (!this.playing) return;
    let place = this.axis.place(this.time) + seconds * this.speed;
    if (place >= this.axis.length) {
      place = this.loop && this.axis.length > 0 ? place % this.axis.length : this.axis.length;
      this.playing = this.loop;
    }
    this.time = this.axis.time(place);
    this.touch();
  }
}
