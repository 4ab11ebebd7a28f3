// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { levelling } from "../src/panels/edit_panel.js";
import { truthAt } from "../src/panels/charts.js";
import { Commands, type Command } from "../src/stream/commands.js";
import { Estimates } from "../src/stream/columns.js";
import { McapReader } from "../src/stream/mcap.js";
import { Model } from "../src/stream/model.js";
import { type Pose, compose, ellipse, inverse, wrap } from "../src/stream/pose.js";
import { Scans, stepFor } from "../src/stream/scans.js";
import { CdrWriter, StreamWriter, estimate, roomsStream, runRecord, way } from "./stream.js";

const near = (a: readonly number[], b: readonly number[], tolerance = 1e-12): void => a.forEach((value, i) => assert.ok(Math.abs(value - (b[i] ?? NaN)) <= tolerance, `${a.join(" ")} against ${b.join(" ")}`));
const poses: Pose[] = [[0, 0, 0], [1, 2, Math.PI], [-3, 0.5, -1e-9], [1e4, -1e4, 3], [0.1, 0, -2.5]];

test("poses: a group, angles wrapped", () => {
  for (const a of poses) {
    near(compose(a, inverse(a)), [0, 0, 0], 1e-11);
    for (const b of poses) for (const c of poses) near(compose(compose(a, b), c).slice(0, 2), compose(a, compose(b, c)).slice(0, 2), 1e-7);
  }
  for (const angle of [0, Math.PI, -Math.PI, 3 * Math.PI, 7, -100]) {
    const w = wrap(angle);
    assert.ok(w > -Math.PI && w <= Math.PI);
    near([Math.cos(w), Math.sin(w)], [Math.cos(angle), Math.sin(angle)]);
  }
});

test("the ellipse has the covariance it came from", () => {
  for (const [xx, xy, yy] of [[1, 0, 4], [2, 1.2, 3], [1, -0.9, 1], [0, 0, 0]] as const) {
    const { major, minor, angle } = ellipse(xx, xy, yy);
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    near([c * c * major ** 2 + s * s * minor ** 2, c * s * (major ** 2 - minor ** 2), s * s * major ** 2 + c * c * minor ** 2], [xx, xy, yy]);
  }
});

test("16 bits hold every range to half a step, and no return and invalid as such", () => {
  assert.deepEqual([stepFor(8), stepFor(50), stepFor(80)], [0.0005, 0.001, 0.002]);
  const scans = new Scans();
  const ranges = [0, 0.1234, 12.3456, 79.9, Infinity, NaN, -1];
  scans.set(3, { laser: 0, angleMin: 0, increment: 0, ranges });
  const out = new Float32Array(20);
  const n = scans.points(3, out);
  assert.equal(n, 8);
  near([out[0] ?? 0, out[2] ?? 0, out[4] ?? 0, out[6] ?? 0], ranges.slice(0, 4), 0.001 + 1e-5);
  assert.equal(scans.points(2, out), 0);
  assert.equal(scans.points(99, out), 0);
});

test("scans keep apart over many pages, and a later one replaces", () => {
  const scans = new Scans();
  const out = new Float32Array(2 * 1000);
  for (let i = 0; i < 5000; ++i) scans.set(i, { laser: 1, angleMin: 0, increment: 0, ranges: new Array<number>(361).fill(1 + i / 1000) });
  scans.set(17, { laser: 0, angleMin: 0, increment: 0, ranges: [9, 8] });
  assert.deepEqual([scans.count, scans.beamsOf(17), scans.beamsOf(16)], [5000, 2, 361]);
  for (const i of [0, 2904, 2905, 4999]) {
    assert.equal(scans.points(i, out), 722);
    near([out[0] ?? 0, out[720] ?? 0], [1 + i / 1000, 1 + i / 1000], 0.0003);
  }
  assert.equal(scans.points(17, out), 4);
  near([out[0] ?? 0, out[2] ?? 0], [9, 8], 0.0003);
});

const plainEstimate = (scan: number, key: number, pose: Pose) => ({ time: scan, scan, key, health: 0, isKey: scan === key, score: 1, milliseconds: NaN, particles: 0, pose, covariance: [0, 0, 0, 0, 0, 0] as const, odometry: [NaN, NaN, NaN] as Pose, frontEnd: [NaN, NaN, NaN] as Pose });

test("estimates in any order are rows ordered by scan; the same scan again replaces", () => {
  const estimates = new Estimates();
  for (const scan of [4, 0, 9, 2, 7, 2]) estimates.set(plainEstimate(scan, scan, [scan, -scan, 0.1 * scan]));
  assert.deepEqual([...estimates.scan.subarray(0, estimates.size)], [0, 2, 4, 7, 9]);
  for (let row = 0; row < estimates.size; ++row) {
    const scan = estimates.scan[row] ?? 0;
    assert.equal(estimates.row(scan), row);
    near(estimates.pose(row), [scan, -scan, 0.1 * scan]);
  }
  assert.deepEqual([estimates.row(3), estimates.row(1000), estimates.rowAt(-1), estimates.rowAt(6.5), estimates.rowAt(100)], [-1, -1, -1, 2, 4]);
  assert.throws(() => estimates.set(plainEstimate(4e9, 0, [0, 0, 0])), /scan number/);
});

test("what hangs on a key scan moves along with it", () => {
  const estimates = new Estimates();
  const inKey: Pose = [1, 0.5, 0.2];
  const key: Pose = [3, 4, 1];
  estimates.set(plainEstimate(0, 0, key));
  estimates.set(plainEstimate(1, 0, compose(key, inKey)));
  estimates.set(plainEstimate(5, 4, [7, 7, 0])); // its key scan is not here
  const moved: Pose = [-2, 1, -2.5];
  estimates.moveKeys(Uint32Array.of(0, 77), Float64Array.of(...moved, 9, 9, 9));
  near(estimates.pose(0), moved);
  near(estimates.pose(1), compose(moved, inKey));
  near(estimates.pose(2), [7, 7, 0]);
});

function modelOf(...records: Uint8Array[]): Model {
  const model = new Model();
  const reader = new McapReader((message) => model.apply(message));
  for (const bytes of records) reader.feed(bytes);
  return model;
}

test("the made-up rooms arrive whole", () => {
  const model = modelOf(roomsStream());
  const n = way().length;
  assert.deepEqual([model.refused, model.estimates.size, model.scans.count, model.scans.beams, model.closures.length, model.landmarks.length, model.hypotheses.length], [0, n, n, 181 * n, 3, 2, 2]);
  assert.deepEqual([model.map?.width, model.segments.length % 4, model.truth?.times.length, model.particles?.poses.length, model.run.name], [261, 0, n, 600, "rooms.log"]);
});

test("a new generation forgets; a broken record spoils only itself", () => {
  const writer = new StreamWriter();
  const first = [writer.begin(), writer.json("/run", runRecord(1, "mapping", 1)), writer.message("/estimate", estimate({ stamp: 0n, scan: 0, key: 0, pose: [0, 0, 0] }))];
  const model = modelOf(...first, writer.message("/map", Uint8Array.of(0, 1, 0, 0, 9)), writer.json("/closures", []));
  assert.deepEqual([model.refused, model.estimates.size, model.versions.closures], [1, 1, 1]);
  const again = modelOf(...first, writer.json("/run", runRecord(1, "mapping", 1)));
  assert.equal(again.estimates.size, 1);
  const fresh = modelOf(...first, writer.json("/run", runRecord(1, "mapping", 2)));
  assert.deepEqual([fresh.estimates.size, fresh.run.generation], [0, 2]);
  const other = new StreamWriter();
  const fromNought = modelOf(other.begin(), other.json("/run", runRecord(1, "mapping", 0)), other.message("/estimate", estimate({ stamp: 0n, scan: 0, key: 0, pose: [0, 0, 0] })), other.json("/run", runRecord(1, "mapping", 1)));
  assert.deepEqual([fromNought.versions.estimates > 0, fromNought.estimates.size], [true, 0]);
  const w = new CdrWriter();
  const keyed = modelOf(...first, writer.message("/key_poses", w.list([0], w.u32).list([5, 6, 1], w.f64).done()));
  near(keyed.estimates.pose(0), [5, 6, 1]);
});

test("commands: confirmed, refused, or of unknown fate; none is sent twice", () => {
  const sent: string[] = [];
  const told: Command[] = [];
  let open = true;
  const commands = new Commands((text) => open && sent.push(text) > 0, (command) => told.push({ ...command }));
  const a = commands.issue("A", { do: "undo" });
  const b = commands.issue("B", { do: "redo" });
  const c = commands.issue("C", { do: "write_files" });
  commands.answer(`{"id":${a.id},"ok":true}`);
  commands.answer(`{"id":${b.id},"ok":false,"error":"no"}`);
  commands.answer(`{"id":99,"ok":true}`);
  commands.answer("no JSON");
  open = false;
  commands.linkLost();
  commands.linkLost();
  const d = commands.issue("D", { do: "undo" });
  assert.deepEqual([a.fate, b.fate, b.error, c.fate, d.fate], ["done", "refused", "no", "unknown", "refused"]);
  assert.deepEqual(sent.map((text) => JSON.parse(text) as object), [{ id: 1, do: "undo" }, { id: 2, do: "redo" }, { id: 3, do: "write_files" }]);
  assert.equal(told.length, 4);
});

test("truth between its poses, and none where it is far", () => {
  const times = Float64Array.of(0, 1, 10);
  const path = Float64Array.of(0, 0, 3, 2, 0, -3, 5, 5, 0);
  assert.equal(truthAt(times, path, -0.1), undefined);
  assert.equal(truthAt(times, path, 5), undefined);
  near(truthAt(times, path, 0) ?? [], [0, 0, 3]);
  const middle = truthAt(times, path, 0.5) ?? [0, 0, 0];
  near(middle.slice(0, 2), [1, 0]);
  near([Math.cos(middle[2])], [-1]);
});

test("a line is levelled the shorter way", () => {
  for (let angle = -3.1; angle < 3.2; angle += 0.1) {
    const turn = levelling([[1, 1], [1 + Math.cos(angle), 1 + Math.sin(angle)]]);
    assert.ok(Math.abs(turn) <= Math.PI / 2 + 1e-9);
    near([Math.sin(angle + turn)], [0]);
  }
});
