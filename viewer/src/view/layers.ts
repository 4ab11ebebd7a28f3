// SPDX-License-Identifier: Apache-2.0
// The layers of the map: what each is made of, and when it must be made anew.
import type { Session } from "../session.js";
import { three } from "../stream/columns.js";
import { type Pose, compose, ellipse } from "../stream/pose.js";
import type { Edit } from "../stream/records.js";
import { type Camera, roundLength } from "./camera.js";
import { Dots, Lines, Picture, type Stage, Triangles, colour, packed } from "./gpu.js";
import { type Palette, kDay, kNight } from "./palette.js";
import { PointTiles } from "./point_tiles.js";
import { fewerPoses } from "./simplify.js";
import { triangulate } from "./triangulate.js";

export type LayerId = "raster" | "grid" | "points" | "segments" | "truth" | "odometry" | "frontEnd" | "trail" | "graph" | "closures" | "landmarks" | "covariance" | "particles" | "hypotheses" | "edits" | "scan";

export interface LayerInfo {
  id: LayerId;
  label: string;
  swatch: keyof Palette;
  on: boolean;
  /// Whether the stream has anything for it.
  has(session: Session): boolean;
}

const always = (): boolean => true;
const anyFinite = (values: Float64Array, size: number): boolean => {
  for (let i = 0; i < 3 * size; i += 3) if (Number.isFinite(values[i])) return true;
  return false;
};

export const kLayers: readonly LayerInfo[] = [
  { id: "scan", label: "Scan now", swatch: "scan", on: true, has: ({ model }) => model.scans.count > 0 },
  { id: "trail", label: "Trail", swatch: "trail", on: true, has: ({ model }) => model.estimates.size > 0 },
  { id: "covariance", label: "Uncertainty", swatch: "covariance", on: true, has: ({ model }) => model.estimates.size > 0 },
  { id: "particles", label: "Particles", swatch: "particle", on: true, has: ({ model }) => (model.particles?.poses.length ?? 0) > 0 },
  { id: "hypotheses", label: "Hypotheses", swatch: "particle", on: true, has: ({ model }) => model.hypotheses.length > 0 },
  { id: "truth", label: "Truth", swatch: "truth", on: true, has: ({ model }) => (model.truth?.poses.length ?? 0) > 0 },
  { id: "odometry", label: "Odometry", swatch: "odometry", on: false, has: ({ model }) => anyFinite(model.estimates.odometry, model.estimates.size) },
  { id: "frontEnd", label: "Front end", swatch: "frontEnd", on: false, has: ({ model }) => anyFinite(model.estimates.frontEnd, model.estimates.size) },
  { id: "closures", label: "Closures", swatch: "closure", on: false, has: ({ model }) => model.closures.length > 0 },
  { id: "graph", label: "Graph", swatch: "graph", on: false, has: ({ model }) => (model.graph?.from.length ?? 0) > 0 },
  { id: "landmarks", label: "Landmarks", swatch: "landmark", on: true, has: ({ model }) => model.landmarks.length > 0 },
  { id: "segments", label: "Wall lines", swatch: "segment", on: false, has: ({ model }) => model.segments.length > 0 },
  { id: "points", label: "All returns", swatch: "points", on: false, has: ({ model }) => model.scans.count > 0 },
  { id: "edits", label: "Edits", swatch: "erase", on: true, has: ({ model }) => model.edits.edits.length > 0 },
  { id: "grid", label: "Grid map", swatch: "occupied", on: true, has: ({ model }) => model.map !== undefined },
  { id: "raster", label: "Metre lines", swatch: "raster", on: true, has: always },
];

const kSigmas = 3; ///< ellipses are drawn so many sigmas wide
const kPointsEvery = 1500; // ms
const kLongestPicture = 2048; // cells
const kBend = 0.4; // px that a drawn path may be beside the true one
const kLongestStep = 24; // px of a path drawn in one piece

const two = (values: Float64Array, row: number): [number, number] => [values[3 * row] ?? 0, values[3 * row + 1] ?? 0];

/// Calls `make` when its key is another one than last time.
function memo(make: () => void): (key: string) => void {
  let last = "";
  return (key) => {
    if (key === last) return;
    last = key;
    make();
  };
}

export class Layers {
  readonly on = new Map<LayerId, boolean>(kLayers.map((layer) => [layer.id, layer.on]));
  readonly points: PointTiles;
  palette: Palette = kDay;
  scanDrawn = -1; ///< number of the scan in the last frame
  private pictures: Picture[] = [];
  private readonly lines: Record<"raster" | "trail" | "trailEnd" | "odometry" | "frontEnd" | "truth" | "graph" | "closures" | "segments" | "ellipses" | "closure" | "hypotheses" | "landmarks" | "edits" | "draft", Lines>;
  private readonly dots: Record<"scan" | "match" | "particles" | "landmarks", Dots>;
  private readonly robot: Triangles;
  private readonly areas: Triangles;
  private readonly make: Record<string, (key: string) => void>;
  private buffer = new Float32Array(4096);
  private pixel = 0.01; ///< m that a pixel of the screen is long, to a power of two: paths are as fine as that
  private sorted = { version: -1, at: -Infinity };
  private trailEnds: { time: number; x: number; y: number }[] = []; ///< where the pieces of the trail end

  constructor(private readonly stage: Stage, private readonly session: Session) {
    const lines = (): Lines => new Lines(stage);
    const dots = (): Dots => new Dots(stage);
    this.points = new PointTiles(stage);
    this.lines = { raster: lines(), trail: lines(), trailEnd: lines(), odometry: lines(), frontEnd: lines(), truth: lines(), graph: lines(), closures: lines(), segments: lines(), ellipses: lines(), closure: lines(), hypotheses: lines(), landmarks: lines(), edits: lines(), draft: lines() };
    this.dots = { scan: dots(), match: dots(), particles: dots(), landmarks: dots() };
    this.robot = new Triangles(stage);
    this.areas = new Triangles(stage);
    this.make = {
      grid: memo(() => this.makeGrid()),
      points: memo(() => this.makePoints()),
      trail: memo(() => this.makeTrail()),
      odometry: memo(() => this.makePath(this.lines.odometry, session.model.estimates.odometry, this.palette.odometry)),
      frontEnd: memo(() => this.makePath(this.lines.frontEnd, session.model.estimates.frontEnd, this.palette.frontEnd)),
      truth: memo(() => this.makeTruth()),
      graph: memo(() => this.makeGraph()),
      closures: memo(() => this.makeClosures()),
      segments: memo(() => this.makeSegments()),
      landmarks: memo(() => this.makeLandmarks()),
      particles: memo(() => this.makeParticles()),
      hypotheses: memo(() => this.makeHypotheses()),
      edits: memo(() => this.makeEdits()),
    };
  }

  /// Eyes as at the start.
  reset(): void {
    for (const { id, on } of kLayers) this.on.set(id, on);
  }

  /// Lines of the tool in the hand, filled by who holds it.
  get draft(): Lines {
    return this.lines.draft;
  }

  /// True: not all is painted yet.
  draw(camera: Camera): boolean {
    const { session } = this;
    const { versions } = session.model;
    this.palette = session.night ? kNight : kDay;
    const p = this.palette;
    const theme = session.night ? "n" : "d";
    const now = session.time - session.epoch() + 1e-3;
    const shown = (id: LayerId, ...parts: number[]): boolean => {
      if (!this.on.get(id)) return false;
      this.make[id]?.(`${theme}${parts.join("/")}`);
      return true;
    };
    this.pixel = 2 ** Math.floor(Math.log2(1 / camera.scale));
    let more = false;
    if (shown("grid", versions.map)) for (const picture of this.pictures) picture.draw(colour(p.free), colour(p.occupied));
    if (shown("raster")) this.drawRaster(camera);
    const newest = versions.poses + versions.scans + versions.run;
    if (shown("points", this.pointsVersion(newest))) more = this.points.draw(camera, colour(p.points), colour(p.pointsMany)) || this.sorted.version !== newest;
    if (shown("segments", versions.segments)) this.lines.segments.draw({ width: 2.5 });
    if (shown("graph", versions.graph, versions.poses)) this.lines.graph.draw({ width: 1.2 }, 1e30, 0.55);
    if (shown("odometry", versions.estimates, this.pixel)) this.lines.odometry.draw({ width: 1.6 }, now);
    if (shown("frontEnd", versions.estimates, this.pixel)) this.lines.frontEnd.draw({ width: 1.6 }, now);
    if (shown("truth", versions.truth, this.pixel)) this.lines.truth.draw({ width: 1.8 }, now);
    if (shown("trail", versions.poses, this.pixel)) this.lines.trail.draw({ width: 1.7 }, now, 0.9);
    if (this.on.get("trail")) this.drawTrailEnd(now);
    if (shown("closures", versions.closures, versions.poses, session.closure)) this.lines.closures.draw({ width: 1.4 });
    if (session.closure >= 0) this.drawClosure();
    if (shown("landmarks", versions.landmarks)) {
      this.lines.landmarks.draw({ width: 1.5 });
      this.dots.landmarks.draw(7);
    }
    if (shown("edits", versions.edits)) {
      this.areas.draw();
      this.lines.edits.draw({ width: 2 });
    }
    if (shown("particles", versions.particles)) this.dots.particles.draw(3, 0.75);
    if (shown("hypotheses", versions.hypotheses)) this.lines.hypotheses.draw({ width: 2 });
    this.drawNow(camera);
    this.lines.draft.draw({ width: 2 });
    return more;
  }

  /// While a run grows, its returns are sorted anew only now and then.
  private pointsVersion(newest: number): number {
    const now = performance.now();
    if (newest !== this.sorted.version && now - this.sorted.at > kPointsEvery) this.sorted = { version: newest, at: now };
    return this.sorted.version;
  }

  private drawNow(camera: Camera): void {
    const { session, palette: p } = this;
    const { estimates } = session.model;
    const row = session.row();
    this.scanDrawn = -1;
    if (row < 0) return this.drawWithoutEstimate(camera);
    const pose = estimates.pose(row);
    if (this.on.get("scan")) {
      this.scanDots(this.dots.scan, estimates.scan[row] ?? 0, pose, packed(colour(p.scan)));
      this.dots.scan.draw(camera.scale > 60 ? 4 : 3);
    }
    if (session.selected >= 0 && session.selected < estimates.size) {
      const key = estimates.row(estimates.key[session.selected] ?? 0);
      if (key >= 0 && key !== session.selected) {
        this.scanDots(this.dots.match, estimates.scan[key] ?? 0, estimates.pose(key), packed(colour(p.match)));
        this.dots.match.draw(3, 0.8);
      }
    }
    if (this.on.get("covariance")) {
      const c = estimates.covariance(row);
      this.lines.ellipses.clear();
      this.ellipse(this.lines.ellipses, pose[0], pose[1], c[0], c[1], c[3], packed(colour(p.covariance)));
      this.heading(this.lines.ellipses, pose, Math.sqrt(Math.max(0, c[5])), 28 / camera.scale, packed(colour(p.covariance)));
      this.lines.ellipses.draw({ width: 1.6 });
    }
    this.drawRobot(pose, camera, estimates.health[row] ?? 0);
  }

  /// A mere recording: the newest scan around the robot.
  private drawWithoutEstimate(camera: Camera): void {
    const { model } = this.session;
    if (model.estimates.size > 0 || model.newestScan < 0) return;
    if (this.on.get("scan")) {
      this.scanDots(this.dots.scan, model.newestScan, [0, 0, 0], packed(colour(this.palette.scan)));
      this.dots.scan.draw(camera.scale > 60 ? 4 : 3);
    }
    this.drawRobot([0, 0, 0], camera, 0);
  }

  private scanDots(dots: Dots, scan: number, pose: Pose, rgba: number): void {
    const { scans } = this.session.model;
    dots.clear();
    if (!scans.has(scan)) return;
    this.room(2 * scans.beamsOf(scan));
    const [x, y, theta] = compose(pose, this.session.model.laserPose(scans.laser(scan)));
    const c = Math.cos(theta);
    const s = Math.sin(theta);
    const n = scans.points(scan, this.buffer);
    for (let i = 0; i < n; i += 2) {
      const px = this.buffer[i] ?? 0;
      const py = this.buffer[i + 1] ?? 0;
      dots.add(x + c * px - s * py, y + s * px + c * py, rgba);
    }
    if (dots === this.dots.scan) this.scanDrawn = scan;
  }

  private room(values: number): void {
    if (this.buffer.length < values) this.buffer = new Float32Array(2 * values);
  }

  /// An arrow head of some 18 px, or 0.4 m if that is larger.
  private drawRobot([x, y, theta]: Pose, camera: Camera, health: number): void {
    const size = Math.max(0.2, 9 / camera.scale);
    const c = Math.cos(theta) * size;
    const s = Math.sin(theta) * size;
    const at = (ahead: number, left: number): [number, number] => [x + c * ahead - s * left, y + s * ahead + c * left];
    const shape = (grow: number, rgba: number): void => {
      const tip = at(1.35 * grow, 0);
      const left = at(-0.9 * grow, 0.85 * grow);
      const right = at(-0.9 * grow, -0.85 * grow);
      const back = at(-0.45 * grow, 0);
      for (const [px, py] of [tip, left, back, tip, back, right]) this.robot.corner(px, py, rgba);
    };
    const p = this.palette;
    this.robot.clear();
    shape(1.35, packed(colour(p.free)));
    shape(1, packed(colour(health === 2 ? p.lost : health === 1 ? p.degraded : p.robot)));
    this.robot.draw();
  }

  private ellipse(lines: Lines, x: number, y: number, xx: number, xy: number, yy: number, rgba: number): void {
    const { major, minor, angle } = ellipse(xx, xy, yy);
    const c = Math.cos(angle);
    const s = Math.sin(angle);
    const steps = 40;
    const at = (i: number): [number, number] => {
      const a = kSigmas * major * Math.cos((2 * Math.PI * i) / steps);
      const b = kSigmas * minor * Math.sin((2 * Math.PI * i) / steps);
      return [x + c * a - s * b, y + s * a + c * b];
    };
    for (let i = 0; i < steps; ++i) lines.add(...at(i), ...at(i + 1), rgba);
  }

  /// Two rays that open by three sigmas of the heading to each side.
  private heading(lines: Lines, [x, y, theta]: Pose, sigma: number, size: number, rgba: number): void {
    const open = Math.min(kSigmas * sigma, Math.PI);
    for (const side of [-open, open]) lines.add(x, y, x + size * Math.cos(theta + side), y + size * Math.sin(theta + side), rgba);
  }

  private drawRaster(camera: Camera): void {
    const lines = this.lines.raster;
    lines.clear();
    const step = roundLength(camera.scale, 56);
    const reach = Math.hypot(camera.width, camera.height) / camera.scale / 2;
    for (let i = Math.ceil((camera.x - reach) / step); i * step <= camera.x + reach; ++i) lines.add(i * step, camera.y - reach, i * step, camera.y + reach, this.rasterColour(i));
    for (let j = Math.ceil((camera.y - reach) / step); j * step <= camera.y + reach; ++j) lines.add(camera.x - reach, j * step, camera.x + reach, j * step, this.rasterColour(j));
    lines.draw({ width: 1 });
  }

  private rasterColour(i: number): number {
    return packed(colour(this.palette.raster, i === 0 ? 0.5 : i % 5 === 0 ? 0.2 : 0.1));
  }

  private makeGrid(): void {
    for (const picture of this.pictures) picture.destroy();
    this.pictures = [];
    const { map } = this.session.model;
    if (!map) return;
    for (let y = 0; y < map.height; y += kLongestPicture)
      for (let x = 0; x < map.width; x += kLongestPicture) this.pictures.push(this.gridPicture(x, y));
  }

  private gridPicture(x: number, y: number): Picture {
    const map = this.session.model.map;
    if (!map) throw new Error("no map");
    const width = Math.min(kLongestPicture, map.width - x);
    const height = Math.min(kLongestPicture, map.height - y);
    const even = width + (width % 2); // rows of a texture begin at multiples of four bytes
    const cells = new Uint8Array(2 * even * height);
    for (let row = 0; row < height; ++row)
      for (let column = 0; column < width; ++column) {
        const value = map.data[(y + row) * map.width + x + column] ?? -1;
        if (value < 0) continue;
        cells[2 * (row * even + column)] = Math.round(2.55 * Math.min(100, value));
        cells[2 * (row * even + column) + 1] = 255;
      }
    const corner = (i: number, j: number): number[] => compose(map.origin, [i * map.resolution, j * map.resolution, 0]).slice(0, 2);
    return new Picture(this.stage, cells, even, height, [...corner(x, y), ...corner(x + even, y), ...corner(x, y + height), ...corner(x + even, y + height)], true);
  }

  private makePoints(): void {
    const { model } = this.session;
    const { estimates, scans } = model;
    let beams = 0;
    const keys: number[] = [];
    for (let row = 0; row < estimates.size; ++row) {
      const scan = estimates.scan[row] ?? 0;
      if (!estimates.isKey[row] || !scans.has(scan)) continue;
      keys.push(row);
      beams += scans.beamsOf(scan);
    }
    const xy = new Float32Array(2 * beams);
    let used = 0;
    for (const row of keys) {
      const scan = estimates.scan[row] ?? 0;
      const [x, y, theta] = compose(estimates.pose(row), model.laserPose(scans.laser(scan)));
      const n = scans.points(scan, xy, used);
      const c = Math.cos(theta);
      const s = Math.sin(theta);
      for (let i = used; i < used + n; i += 2) {
        const px = xy[i] ?? 0;
        const py = xy[i + 1] ?? 0;
        xy[i] = x + c * px - s * py;
        xy[i + 1] = y + s * px + c * py;
      }
      used += n;
    }
    this.points.set(xy.subarray(0, used));
  }

  private makeTrail(): void {
    const { estimates } = this.session.model;
    const p = this.palette;
    const rgba = [p.trail, p.degraded, p.lost].map((hex) => packed(colour(hex)));
    this.trailEnds = [];
    this.path(this.lines.trail, estimates.poses, estimates.time, estimates.size, (row) => rgba[estimates.health[row] ?? 0] ?? 0, this.trailEnds);
  }

  private makePath(lines: Lines, poses: Float64Array, hex: string): void {
    const { estimates } = this.session.model;
    const rgba = packed(colour(hex));
    this.path(lines, poses, estimates.time, estimates.size, () => rgba);
  }

  private makeTruth(): void {
    const { truth } = this.session.model;
    const rgba = packed(colour(this.palette.truth));
    if (truth) this.path(this.lines.truth, truth.poses, truth.times, truth.times.length, () => rgba);
    else this.lines.truth.clear();
  }

  private path(lines: Lines, poses: Float64Array, times: Float64Array, size: number, rgba: (row: number) => number, ends: { time: number; x: number; y: number }[] = []): void {
    const epoch = this.session.epoch();
    lines.clear();
    let last = -1;
    for (const row of fewerPoses(poses, size, kBend * this.pixel, kLongestStep * this.pixel, rgba)) {
      const [x, y] = three(poses, row);
      const time = (times[row] ?? 0) - epoch;
      if (last >= 0) lines.add(...two(poses, last), x, y, rgba(row), time);
      ends.push({ time, x, y });
      last = row;
    }
  }

  /// From the last whole piece of the trail to the robot.
  private drawTrailEnd(now: number): void {
    const { session, trailEnds } = this;
    const row = session.row();
    let low = 0;
    let high = trailEnds.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if ((trailEnds[middle]?.time ?? 0) <= now) low = middle + 1;
      else high = middle;
    }
    const end = trailEnds[low - 1];
    if (!end || row < 0) return;
    const lines = this.lines.trailEnd;
    lines.clear();
    lines.add(end.x, end.y, ...two(session.model.estimates.poses, row), packed(colour(this.palette.trail)));
    lines.draw({ width: 1.7 }, 1e30, 0.9);
  }

  private between(lines: Lines, from: number, to: number, rgba: number): void {
    const { estimates } = this.session.model;
    const a = estimates.row(from);
    const b = estimates.row(to);
    if (a < 0 || b < 0) return;
    const [x1, y1] = estimates.pose(a);
    const [x2, y2] = estimates.pose(b);
    lines.add(x1, y1, x2, y2, rgba);
  }

  private makeGraph(): void {
    const { graph } = this.session.model;
    this.lines.graph.clear();
    if (!graph) return;
    const p = this.palette;
    const rgba = [p.odometry, p.graph, p.closure].map((hex) => packed(colour(hex)));
    const off = packed(colour(p.closureOff));
    for (let i = 0; i < graph.from.length; ++i) this.between(this.lines.graph, graph.from[i] ?? 0, graph.to[i] ?? 0, graph.enabled[i] ? (rgba[graph.kind[i] ?? 0] ?? 0) : off);
  }

  private makeClosures(): void {
    const { closures } = this.session.model;
    this.lines.closures.clear();
    const on = packed(colour(this.palette.closure));
    const off = packed(colour(this.palette.closureOff, 0.6));
    for (const closure of closures) this.between(this.lines.closures, closure.from, closure.to, closure.enabled ? on : off);
  }

  /// The two scans of the closure in the hand, where they lie now.
  private drawClosure(): void {
    const { session, palette: p } = this;
    const { estimates, closures } = session.model;
    const closure = closures[session.closure];
    if (!closure) return;
    const ends = [closure.from, closure.to].map((scan) => estimates.row(scan));
    ends.forEach((row, i) => {
      if (row < 0) return;
      this.scanDots(this.dots.match, estimates.scan[row] ?? 0, estimates.pose(row), packed(colour(i === 0 ? p.trail : p.closure)));
      this.dots.match.draw(3.5);
    });
    this.lines.closure.clear();
    this.between(this.lines.closure, closure.from, closure.to, packed(colour(closure.enabled ? p.closure : p.closureOff)));
    this.lines.closure.draw({ width: 4 });
  }

  private makeSegments(): void {
    const { segments } = this.session.model;
    const rgba = packed(colour(this.palette.segment));
    this.lines.segments.clear();
    for (let i = 0; i + 3 < segments.length; i += 4) this.lines.segments.add(segments[i] ?? 0, segments[i + 1] ?? 0, segments[i + 2] ?? 0, segments[i + 3] ?? 0, rgba);
  }

  private makeLandmarks(): void {
    const rgba = packed(colour(this.palette.landmark));
    this.lines.landmarks.clear();
    this.dots.landmarks.clear();
    for (const { x, y, covariance } of this.session.model.landmarks) {
      this.dots.landmarks.add(x, y, rgba);
      this.ellipse(this.lines.landmarks, x, y, covariance[0], covariance[1], covariance[2], rgba);
    }
  }

  private makeParticles(): void {
    const { particles } = this.session.model;
    this.dots.particles.clear();
    if (!particles) return;
    const rgba = packed(colour(this.palette.particle));
    for (let i = 0; i + 2 < particles.poses.length; i += 3) this.dots.particles.add(particles.poses[i] ?? 0, particles.poses[i + 1] ?? 0, rgba);
  }

  private makeHypotheses(): void {
    const lines = this.lines.hypotheses;
    lines.clear();
    for (const { pose, covariance, weight } of this.session.model.hypotheses) {
      const rgba = packed(colour(this.palette.particle, 0.35 + 0.65 * Math.min(1, Math.max(0, weight))));
      this.ellipse(lines, pose[0], pose[1], covariance[0], covariance[1], covariance[3], rgba);
      lines.add(pose[0], pose[1], pose[0] + 0.6 * Math.cos(pose[2]), pose[1] + 0.6 * Math.sin(pose[2]), rgba);
    }
  }

  private makeEdits(): void {
    this.lines.edits.clear();
    this.areas.clear();
    for (const edit of this.session.model.edits.edits) this.edit(edit);
  }

  private edit({ kind, points }: Edit): void {
    if (!points || points.length < 2) return;
    const hex = this.editColour(kind);
    const rgba = packed(colour(hex));
    const closed = kind !== "wall";
    for (let i = 0; i + (closed ? 0 : 1) < points.length; ++i) this.lines.edits.add(...(points[i] ?? [0, 0]), ...(points[(i + 1) % points.length] ?? [0, 0]), rgba);
    if (kind !== "erase" && kind !== "forbidden") return;
    const fill = packed(colour(hex, kind === "erase" ? 0.1 : 0.28));
    for (const [x, y] of triangulate(points)) this.areas.corner(x, y, fill);
  }

  editColour(kind: string): string {
    const p = this.palette;
    return kind === "wall" ? p.wall : kind === "crop" ? p.crop : kind === "forbidden" ? p.forbidden : kind === "erase" ? p.erase : p.measure;
  }
}
