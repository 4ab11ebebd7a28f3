// SPDX-License-Identifier: Apache-2.0
// All that the stream has told so far. Each part has a version, so that who draws it knows when it changed.
import { Estimates } from "./columns.js";
import type { Message } from "./mcap.js";
import type { Pose } from "./pose.js";
import { type Closure, type Edits, type Graph, type Grid, type Hypothesis, type Landmark, type Particles, type Path, type Run, type Status, readEstimate, readGraph, readGrid, readJson, readKeyPoses, readParticles, readPath, readScan, readSegments } from "./records.js";
import { Scans } from "./scans.js";

export type Part = "run" | "estimates" | "poses" | "scans" | "map" | "graph" | "truth" | "segments" | "particles" | "hypotheses" | "landmarks" | "closures" | "edits" | "status";

const noRun = (): Run => ({ name: "", state: "finished", scans: 0, begin: "0", end: "0", lasers: [], version: "", may: [], findings: [], report: [], generation: 0 });
const noEdits = (): Edits => ({ edits: [], can_undo: false, can_redo: false, saved: true });

export class Model {
  run: Run = noRun();
  estimates = new Estimates();
  scans = new Scans();
  map: Grid | undefined;
  graph: Graph | undefined;
  truth: Path | undefined;
  segments: Float32Array = new Float32Array(0);
  particles: Particles | undefined;
  hypotheses: Hypothesis[] = [];
  landmarks: Landmark[] = [];
  closures: Closure[] = [];
  edits: Edits = noEdits();
  status: Status = {};
  newestScan = -1;
  newestStamp = 0n; ///< ns, of that scan
  private generation: number | undefined;
  refused = 0; ///< records that could not be read
  readonly versions: Record<Part, number> = { run: 0, estimates: 0, poses: 0, scans: 0, map: 0, graph: 0, truth: 0, segments: 0, particles: 0, hypotheses: 0, landmarks: 0, closures: 0, edits: 0, status: 0 };

  /// One broken record spoils only itself.
  apply(message: Message): void {
    try {
      this.take(message);
    } catch (error) {
      ++this.refused;
      if (this.refused === 1) console.warn(`${message.topic}: ${error instanceof Error ? error.message : String(error)}`);
    }
  }

  laserPose(index: number): Pose {
    return this.run.lasers[index]?.pose ?? [0, 0, 0];
  }

  private take({ topic, sequence, data }: Message): void {
    switch (topic) {
      case "/run": return this.takeRun({ ...noRun(), ...readJson<Partial<Run>>(data) });
      case "/scan": return this.takeScan(sequence, data);
      case "/estimate": return this.takeEstimate(data);
      case "/key_poses": return this.takeKeyPoses(data);
      case "/map": this.map = readGrid(data); return this.changed("map");
      case "/graph": this.graph = readGraph(data); return this.changed("graph");
      case "/truth": this.truth = readPath(data); return this.changed("truth");
      case "/segments": this.segments = readSegments(data); return this.changed("segments");
      case "/particles": this.particles = readParticles(data); return this.changed("particles");
      case "/hypotheses": this.hypotheses = readJson<Hypothesis[]>(data); return this.changed("hypotheses");
      case "/landmarks": this.landmarks = readJson<Landmark[]>(data); return this.changed("landmarks");
      case "/closures": this.closures = readJson<Closure[]>(data); return this.changed("closures");
      case "/edits": this.edits = { ...noEdits(), ...readJson<Partial<Edits>>(data) }; return this.changed("edits");
      case "/status": this.status = readJson<Status>(data); return this.changed("status");
    }
  }

  private changed(...parts: Part[]): void {
    for (const part of parts) ++this.versions[part];
  }

  private takeRun(run: Run): void {
    if (this.generation !== undefined && run.generation !== this.generation) this.forget();
    this.generation = run.generation;
    this.run = run;
    this.changed("run");
  }

  /// A whole new picture follows.
  forget(): void {
    this.generation = undefined;
    this.estimates = new Estimates();
    this.scans = new Scans();
    this.map = undefined;
    this.graph = undefined;
    this.truth = undefined;
    this.segments = new Float32Array(0);
    this.particles = undefined;
    this.hypotheses = [];
    this.landmarks = [];
    this.closures = [];
    this.edits = noEdits();
    this.status = {};
    this.newestScan = -1;
    this.newestStamp = 0n;
    for (const part of Object.keys(this.versions) as Part[]) ++this.versions[part];
  }

  private takeScan(sequence: number, data: Uint8Array): void {
    const scan = readScan(data);
    scan.laser = Math.max(0, this.run.lasers.findIndex((laser) => laser.frame === scan.frame));
    this.scans.set(sequence, scan);
    if (sequence >= this.newestScan) {
      this.newestScan = sequence;
      this.newestStamp = scan.stamp;
    }
    this.changed("scans");
  }

  private takeEstimate(data: Uint8Array): void {
    this.estimates.set(readEstimate(data));
    this.changed("estimates", "poses");
  }

  private takeKeyPoses(data: Uint8Array): void {
    const { scans, poses } = readKeyPoses(data);
    this.estimates.moveKeys(scans, poses);
    this.changed("poses");
  }
}
