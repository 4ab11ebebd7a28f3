// SPDX-License-Identifier: Apache-2.0
// Writes the stream: a small encoder, and a made-up run through a few rooms with records of every topic.
import { type Pose, compose, inverse } from "../src/stream/pose.js";

export class CdrWriter {
  private bytes: number[] = [0, 1, 0, 0];

  private put(size: number, write: (view: DataView) => void): this {
    while ((this.bytes.length - 4) % size !== 0) this.bytes.push(0);
    const view = new DataView(new ArrayBuffer(size));
    write(view);
    this.bytes.push(...new Uint8Array(view.buffer));
    return this;
  }
  u8 = (value: number): this => this.put(1, (view) => view.setUint8(0, value));
  i32 = (value: number): this => this.put(4, (view) => view.setInt32(0, value, true));
  u32 = (value: number): this => this.put(4, (view) => view.setUint32(0, value, true));
  f32 = (value: number): this => this.put(4, (view) => view.setFloat32(0, value, true));
  f64 = (value: number): this => this.put(8, (view) => view.setFloat64(0, value, true));
  i64 = (value: bigint): this => this.put(8, (view) => view.setBigInt64(0, value, true));
  time = (ns: bigint): this => this.i32(Number(ns / 1_000_000_000n)).u32(Number(ns % 1_000_000_000n));
  string(value: string): this {
    const text = new TextEncoder().encode(value);
    this.u32(text.length + 1);
    this.bytes.push(...text, 0);
    return this;
  }
  list<T>(values: Iterable<T>, put: (value: T) => unknown): this {
    const all = [...values];
    this.u32(all.length);
    for (const value of all) put(value);
    return this;
  }
  each = (values: Iterable<number>, put: (value: number) => unknown): this => {
    for (const value of values) put(value);
    return this;
  };
  done = (): Uint8Array => Uint8Array.from(this.bytes);
}

const concat = (parts: Uint8Array[]): Uint8Array => new Uint8Array(Buffer.concat(parts));

function record(opcode: number, content: Uint8Array): Uint8Array {
  const head = new DataView(new ArrayBuffer(9));
  head.setUint8(0, opcode);
  head.setBigUint64(1, BigInt(content.length), true);
  return concat([new Uint8Array(head.buffer), content]);
}

function text(value: string): Uint8Array {
  const bytes = new TextEncoder().encode(value);
  const size = new DataView(new ArrayBuffer(4));
  size.setUint32(0, bytes.length, true);
  return concat([new Uint8Array(size.buffer), bytes]);
}

const u16 = (value: number): Uint8Array => Uint8Array.of(value & 255, value >> 8);

export const kMagic = Uint8Array.of(0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a);

/// Records one after another; channels are told when first used.
export class StreamWriter {
  private readonly channels = new Map<string, number>();

  constructor(private readonly firstChannel = 1) {}

  begin = (): Uint8Array => concat([kMagic, record(0x01, concat([text(""), text("test")]))]);

  message(topic: string, data: Uint8Array, encoding: "cdr" | "json" = "cdr", sequence = 0, time = 0n): Uint8Array {
    const parts: Uint8Array[] = [];
    let id = this.channels.get(topic);
    if (id === undefined) {
      id = this.firstChannel + this.channels.size;
      this.channels.set(topic, id);
      parts.push(record(0x03, concat([u16(id), text(`test${topic}`), text("ros2msg"), text("")])));
      parts.push(record(0x04, concat([u16(id), u16(id), text(topic), text(encoding), Uint8Array.of(0, 0, 0, 0)])));
    }
    const head = new DataView(new ArrayBuffer(22));
    head.setUint16(0, id, true);
    head.setUint32(2, sequence, true);
    head.setBigUint64(6, time, true);
    head.setBigUint64(14, time, true);
    parts.push(record(0x05, concat([new Uint8Array(head.buffer), data])));
    return concat(parts);
  }

  json = (topic: string, value: unknown): Uint8Array => this.message(topic, new TextEncoder().encode(JSON.stringify(value)), "json");
}

export interface EstimateFields {
  stamp: bigint;
  scan: number;
  key: number;
  health?: number;
  isKey?: boolean;
  score?: number;
  milliseconds?: number;
  particles?: number;
  pose: Pose;
  covariance?: number[];
  odometry?: Pose;
  frontEnd?: Pose;
}

export function estimate(e: EstimateFields): Uint8Array {
  const w = new CdrWriter();
  w.time(e.stamp).u32(e.scan).u32(e.key).u8(e.health ?? 0).u8(e.isKey ? 1 : 0).f32(e.score ?? 0.9).f32(e.milliseconds ?? 1.5).u32(e.particles ?? 0);
  const none: Pose = [NaN, NaN, NaN];
  return w.each(e.pose, w.f64).each(e.covariance ?? [1e-4, 0, 0, 4e-4, 0, 1e-5], w.f32).each(e.odometry ?? none, w.f64).each(e.frontEnd ?? none, w.f64).done();
}

export function scan(stamp: bigint, frame: string, angleMin: number, increment: number, ranges: number[]): Uint8Array {
  const w = new CdrWriter();
  w.time(stamp).string(frame).f32(angleMin).f32(angleMin + increment * (ranges.length - 1)).f32(increment).f32(0).f32(0.2).f32(0).f32(80);
  return w.list(ranges, w.f32).list([], w.f32).done();
}

export function grid(resolution: number, width: number, height: number, x: number, y: number, cells: number[]): Uint8Array {
  const w = new CdrWriter();
  w.time(0n).string("map").time(0n).f32(resolution).u32(width).u32(height).each([x, y, 0, 0, 0, 0, 1], w.f64);
  return w.list(cells, (cell) => w.u8(cell & 255)).done();
}

type Wall = [number, number, number, number];

/// Four rooms of 5 m by 4 m around a corridor, with doors.
const kWalls: Wall[] = [
  [0, 0, 12, 0], [12, 0, 12, 10], [12, 10, 0, 10], [0, 10, 0, 0],
  [0, 4, 2, 4], [3, 4, 8, 4], [9, 4, 12, 4], [0, 6, 2, 6], [3, 6, 8, 6], [9, 6, 12, 6],
  [6, 0, 6, 4], [6, 6, 6, 10], [8, 8, 10, 8],
];

function range(x: number, y: number, angle: number): number {
  let nearest = Infinity;
  const dx = Math.cos(angle);
  const dy = Math.sin(angle);
  for (const [x1, y1, x2, y2] of kWalls) {
    const ex = x2 - x1;
    const ey = y2 - y1;
    const det = dx * ey - dy * ex;
    if (Math.abs(det) < 1e-12) continue;
    const t = ((x1 - x) * ey - (y1 - y) * ex) / det;
    const s = ((x1 - x) * dy - (y1 - y) * dx) / det;
    if (t > 0 && s >= 0 && s <= 1) nearest = Math.min(nearest, t);
  }
  return nearest;
}

const kWay: [number, number][] = [[1, 5], [2.5, 5], [2.5, 2], [2.5, 5], [8.5, 5], [8.5, 2], [8.5, 5], [8.5, 7], [8.5, 5], [2.5, 5], [2.5, 8], [2.5, 5], [1, 5]];

/// Poses every 0.1 m of the way, turning on the spot in steps of 0.2 rad.
export function way(): Pose[] {
  const out: Pose[] = [];
  let theta = 0;
  for (let i = 0; i + 1 < kWay.length; ++i) {
    const [x1, y1] = kWay[i] as [number, number];
    const [x2, y2] = kWay[i + 1] as [number, number];
    const aim = Math.atan2(y2 - y1, x2 - x1);
    const turn = Math.atan2(Math.sin(aim - theta), Math.cos(aim - theta));
    for (let k = 1; k <= Math.abs(turn) / 0.2; ++k) out.push([x1, y1, theta + Math.sign(turn) * 0.2 * k]);
    theta = aim;
    const long = Math.hypot(x2 - x1, y2 - y1);
    for (let s = 0; s < long; s += 0.1) out.push([x1 + Math.cos(theta) * s, y1 + Math.sin(theta) * s, theta]);
  }
  return out;
}

export const kBegin = 1_700_000_000_000_000_000n;
export const kLaser: Pose = [0.1, 0, 0];
const kBeams = 181;
const kPauseAt = 100; // the robot stands still for a minute there

export const stampOf = (i: number): bigint => kBegin + BigInt(i) * 200_000_000n + (i >= kPauseAt ? 60_000_000_000n : 0n);

export function rangesAt(pose: Pose): number[] {
  const [x, y, theta] = compose(pose, kLaser);
  return Array.from({ length: kBeams }, (_, b) => range(x, y, theta - Math.PI / 2 + (b * Math.PI) / 180));
}

export function scanAt(i: number, pose: Pose, stamp = stampOf(i)): Uint8Array {
  return scan(stamp, "laser0", -Math.PI / 2, Math.PI / 180, rangesAt(pose));
}

const kAll = ["switch_closure", "edit", "undo", "redo", "write_files", "start_pose", "kidnap", "localize"];

export function runRecord(scans: number, state = "finished", generation = 1): Record<string, unknown> {
  return {
    name: "rooms.log", state, scans, begin: String(kBegin), end: String(stampOf(scans - 1)), lasers: [{ frame: "laser0", pose: kLaser, max_range: 80 }], version: "0.1.0", may: kAll,
    findings: ["Its turns come out 3.2 % too large; this is corrected.", "The laser sits 0.10 m ahead of the robot's centre."], report: [{ what: "scan stamps that run backwards; order of the file kept", count: 3, first_line: 17 }], generation,
  };
}

function gridRecord(): Uint8Array {
  const resolution = 0.05;
  const [width, height] = [261, 221];
  const cells = new Array<number>(width * height).fill(-1);
  const at = (x: number, y: number): number => Math.round((y + 0.5) / resolution) * width + Math.round((x + 0.5) / resolution);
  for (let y = 0.05; y < 10; y += resolution) for (let x = 0.05; x < 12; x += resolution) cells[at(x, y)] = 0;
  for (const [x1, y1, x2, y2] of kWalls) {
    const steps = Math.ceil(Math.hypot(x2 - x1, y2 - y1) / 0.02);
    for (let i = 0; i <= steps; ++i) cells[at(x1 + ((x2 - x1) * i) / steps, y1 + ((y2 - y1) * i) / steps)] = 100;
  }
  return grid(resolution, width, height, -0.5, -0.5, cells);
}

const paths = (poses: Pose[]): Uint8Array => {
  const w = new CdrWriter();
  return w.list(poses, (_) => w.i64(stampOf(poses.indexOf(_)))).list(poses.flat(), w.f64).done();
};

function graphRecord(keys: number[], closures: [number, number][]): Uint8Array {
  const edges = [...keys.slice(1).map((to, i): [number, number, number] => [keys[i] ?? 0, to, 0]), ...closures.map(([from, to]): [number, number, number] => [from, to, 2])];
  const w = new CdrWriter();
  w.list(edges, (edge) => w.u32(edge[0])).list(edges, (edge) => w.u32(edge[1])).list(edges, (edge) => w.u8(edge[2])).list(edges, () => w.u8(1));
  return w.list(edges, () => w.f32(1.2)).done();
}

/// A record of every topic, in the order of a finished run.
export function roomsStream(): Uint8Array {
  const poses = way();
  const writer = new StreamWriter();
  const keyOf = (i: number): number => i - (i % 5);
  const keys = poses.map((_, i) => i).filter((i) => i % 5 === 0);
  const closures = [[5, keys[keys.length - 1] ?? 0], [20, 110], [keys[12] ?? 0, keys[keys.length - 8] ?? 0]] as [number, number][];
  const drift = (pose: Pose, i: number): Pose => [pose[0] + 0.0015 * i, pose[1] + 0.3 * Math.sin(i / 90), pose[2] + 0.0002 * i];
  const parts: Uint8Array[] = [writer.begin(), writer.json("/run", runRecord(poses.length)), writer.message("/map", gridRecord())];
  poses.forEach((pose, i) => {
    const s = 0.01 + 0.00006 * i;
    const fields: EstimateFields = { stamp: stampOf(i), scan: i, key: keyOf(i), isKey: i % 5 === 0, health: i > 150 && i < 160 ? 1 : i === 200 ? 2 : 0, score: 0.9 + 0.08 * Math.sin(i / 7), milliseconds: 1 + (i % 7) / 5, pose, covariance: [s * s, 0.3 * s * s, 0, 2 * s * s, 0, s * s * 0.1], odometry: drift(pose, 2 * i), frontEnd: drift(pose, i) };
    parts.push(writer.message("/estimate", estimate(fields), "cdr", i, stampOf(i)));
  });
  parts.push(writer.message("/graph", graphRecord(keys, closures)));
  parts.push(writer.json("/closures", closures.map(([from, to], i) => ({ from, to, measured: compose(inverse(poses[from] as Pose), poses[to] as Pose), score: 0.95 - 0.1 * i, overlap: 0.6, chi2: 0.8 + i, enabled: true, by_hand: false, effect_m: 0.4 - 0.1 * i, effect_rad: 0.03 }))));
  parts.push(writer.json("/edits", { edits: [], can_undo: false, can_redo: false, saved: true }));
  parts.push(writer.message("/truth", paths(poses.map((pose): Pose => [pose[0] + 0.01, pose[1] - 0.01, pose[2]]))));
  const segments = new CdrWriter();
  parts.push(writer.message("/segments", segments.list(kWalls.flat(), segments.f32).done()));
  parts.push(writer.json("/landmarks", [{ name: "12", x: 4, y: 5, covariance: [0.01, 0, 0.01] }, { name: "13", x: 10, y: 3, covariance: [0.02, 0.005, 0.01] }]));
  const last = poses[poses.length - 1] as Pose;
  const particles = new CdrWriter();
  const cloud = Array.from({ length: 200 }, (_, i) => [last[0] + 0.4 * Math.sin(7 * i), last[1] + 0.4 * Math.cos(11 * i), last[2] + 0.1 * Math.sin(i)]);
  parts.push(writer.message("/particles", particles.time(stampOf(poses.length - 1)).list(cloud.flat(), particles.f32).list([], particles.f32).done()));
  parts.push(writer.json("/hypotheses", [{ pose: last, covariance: [0.04, 0, 0, 0.02, 0, 0.01], weight: 0.7 }, { pose: [9, 5, 3], covariance: [0.09, 0, 0, 0.02, 0, 0.01], weight: 0.3 }]));
  for (const i of keys) parts.push(writer.message("/scan", scanAt(i, poses[i] as Pose), "cdr", i, stampOf(i)));
  poses.forEach((pose, i) => {
    if (i % 5 !== 0) parts.push(writer.message("/scan", scanAt(i, pose), "cdr", i, stampOf(i)));
  });
  return concat(parts);
}
