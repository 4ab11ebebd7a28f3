// SPDX-License-Identifier: Apache-2.0
// What the records of the stream say, topic by topic.
import { CdrReader } from "./cdr.js";
import type { Estimate } from "./columns.js";
import type { Covariance, Pose } from "./pose.js";
import type { Scan } from "./scans.js";

export interface Grid {
  resolution: number; ///< m a cell
  width: number;
  height: number;
  origin: Pose; ///< of the lower left corner
  data: Int8Array; ///< row 0 is the lowest y; -1 unknown, 0 free ... 100 occupied
}

export interface Graph {
  from: Uint32Array;
  to: Uint32Array;
  kind: Uint8Array; ///< 0 odometry, 1 match, 2 closure
  enabled: Uint8Array;
  chi2: Float32Array;
}

export interface Path {
  times: Float64Array; ///< s since 1970
  poses: Float64Array; ///< 3 each
}

export interface Particles {
  time: number;
  poses: Float32Array; ///< 3 each
  weights: Float32Array; ///< empty: all alike
}

export interface Hypothesis {
  pose: Pose;
  covariance: Covariance;
  weight: number;
}

export interface Landmark {
  name: string;
  x: number;
  y: number;
  covariance: readonly [number, number, number]; ///< xx xy yy
}

export interface Laser {
  frame: string;
  pose: Pose; ///< T_robot_laser
  max_range: number;
}

export type RunState = "mapping" | "finished" | "localizing" | "recording";

export interface Run {
  name: string;
  state: RunState;
  scans: number;
  begin: string;
  end: string;
  lasers: Laser[];
  version: string;
  may: string[];
  findings: string[];
  report: { what: string; count: number; first_line: number }[];
  generation: number;
}

export interface Closure {
  from: number;
  to: number;
  measured: Pose;
  score: number;
  overlap: number;
  chi2: number;
  enabled: boolean;
  by_hand: boolean;
  effect_m: number;
  effect_rad: number;
}

export type EditKind = "erase" | "wall" | "forbidden" | "crop" | "turn" | "closure_off";

export interface Edit {
  id: number;
  kind: EditKind;
  points?: [number, number][];
  radians?: number;
  from?: number;
  to?: number;
}

export interface Edits {
  edits: Edit[];
  can_undo: boolean;
  can_redo: boolean;
  saved: boolean;
}

export interface Status {
  activity?: string;
  scans?: number;
  skipped?: number;
  scans_per_second?: number;
  clients?: number;
  memory_mb?: number;
}

export const seconds = (ns: bigint): number => Number(ns / 1000n) / 1e6;

/// The scan and the frame of its laser; the caller knows the lasers.
export function readScan(data: Uint8Array): Scan & { frame: string; stamp: bigint } {
  const in_ = new CdrReader(data);
  const stamp = in_.time();
  const frame = in_.string();
  const angleMin = in_.f32();
  in_.f32(); // angle_max
  const increment = in_.f32();
  for (let i = 0; i < 4; ++i) in_.f32(); // time_increment, scan_time, range_min, range_max
  return { frame, stamp, angleMin, increment, ranges: in_.f32s(), laser: 0 };
}

export function readEstimate(data: Uint8Array): Estimate {
  const in_ = new CdrReader(data);
  const pose = (): Pose => [in_.f64(), in_.f64(), in_.f64()];
  // The fields of an object literal are read in the order in which they stand.
  return {
    time: seconds(in_.time()),
    scan: in_.u32(),
    key: in_.u32(),
    health: in_.u8(),
    isKey: in_.bool(),
    score: in_.f32(),
    milliseconds: in_.f32(),
    particles: in_.u32(),
    pose: pose(),
    covariance: [in_.f32(), in_.f32(), in_.f32(), in_.f32(), in_.f32(), in_.f32()],
    odometry: pose(),
    frontEnd: pose(),
  };
}

export function readKeyPoses(data: Uint8Array): { scans: Uint32Array; poses: Float64Array } {
  const in_ = new CdrReader(data);
  return { scans: in_.u32s(), poses: in_.f64s() };
}

export function readGrid(data: Uint8Array): Grid {
  const in_ = new CdrReader(data);
  in_.time();
  in_.string();
  in_.time();
  const resolution = in_.f32();
  const width = in_.u32();
  const height = in_.u32();
  const x = in_.f64();
  const y = in_.f64();
  in_.f64(); // z
  in_.f64(); // qx
  in_.f64(); // qy
  const qz = in_.f64();
  const qw = in_.f64();
  const cells = in_.u8s();
  if (cells.length !== width * height) throw new Error(`a map of ${width} x ${height} with ${cells.length} cells`);
  return { resolution, width, height, origin: [x, y, 2 * Math.atan2(qz, qw)], data: new Int8Array(cells.slice().buffer) };
}

export function readGraph(data: Uint8Array): Graph {
  const in_ = new CdrReader(data);
  return { from: in_.u32s(), to: in_.u32s(), kind: in_.u8s().slice(), enabled: in_.u8s().slice(), chi2: in_.f32s() };
}

export function readPath(data: Uint8Array): Path {
  const in_ = new CdrReader(data);
  const stamps = in_.i64s();
  return { times: Float64Array.from(stamps, seconds), poses: in_.f64s() };
}

export function readParticles(data: Uint8Array): Particles {
  const in_ = new CdrReader(data);
  return { time: seconds(in_.time()), poses: in_.f32s(), weights: in_.f32s() };
}

export function readSegments(data: Uint8Array): Float32Array {
  return new CdrReader(data).f32s();
}

/// The caller trusts the program at the other end for the shape; a missing list is an empty one.
export function readJson<T>(data: Uint8Array): T {
  return JSON.parse(new TextDecoder().decode(data)) as T;
}
