// SPDX-License-Identifier: Apache-2.0
// Time without pauses, thinning, camera, triangles.
import assert from "node:assert/strict";
import { test } from "node:test";
import { thinMinMax } from "../src/stream/thin.js";
import { TimeAxis } from "../src/stream/time_axis.js";
import { Camera, roundLength } from "../src/view/camera.js";
import { levelFor, visible } from "../src/view/squares.js";
import { area2, triangulate, type Point } from "../src/view/triangulate.js";
import { count, duration, fixed } from "../src/text.js";

test("pauses of more than 5 s take no room, shorter ones do", () => {
  const axis = new TimeAxis();
  const times = Float64Array.of(100, 101, 106, 200, 200.5, 1000);
  axis.extend(times, 3);
  axis.extend(times, times.length);
  assert.equal(axis.length, 6.5);
  assert.deepEqual(axis.gaps, [{ at: 6, seconds: 94 }, { at: 6.5, seconds: 799.5 }]);
  assert.deepEqual([100, 103, 106, 150, 200.25, 999, 1000, 2000, 0].map((t) => axis.place(t)), [0, 3, 6, 6, 6.25, 6.5, 6.5, 6.5, 0]);
});

test("time and place are each other's inverse, but within pauses", () => {
  const axis = new TimeAxis();
  const times = Float64Array.from({ length: 500 }, (_, i) => 50 + i * 0.3 + 20 * Math.floor(i / 100));
  axis.extend(times, times.length);
  for (let row = 0; row < times.length; ++row) {
    const time = times[row] ?? 0;
    assert.ok(Math.abs(axis.time(axis.place(time)) - time) < 1e-9 || axis.gaps.some((gap) => Math.abs(gap.at - axis.place(time)) < 1e-9));
  }
  for (let place = 0; place < axis.length; place += 0.7) assert.ok(Math.abs(axis.place(axis.time(place)) - place) < 1e-9);
  assert.equal(axis.time(1e9), times[times.length - 1]);
});

test("an axis without scans, and one that begins anew", () => {
  const axis = new TimeAxis();
  assert.deepEqual([axis.place(5), axis.time(5), axis.length], [0, 0, 0]);
  axis.extend(Float64Array.of(1, 2, 3), 3);
  axis.extend(Float64Array.of(10), 1);
  assert.deepEqual([axis.length, axis.place(10), axis.time(0)], [0, 0, 10]);
});

test("thinning keeps the lowest, the highest, and the order", () => {
  const n = 10_000;
  const x = Float64Array.from({ length: n }, (_, i) => i);
  const y = Float64Array.from({ length: n }, (_, i) => Math.sin(i / 50) + (i === 7777 ? 9 : 0) - (i === 3333 ? 9 : 0));
  const thin = thinMinMax(x, y, 0, n, 400);
  assert.ok(thin.x.length <= 400 && thin.x.length > 300);
  assert.ok(thin.x.includes(7777) && thin.x.includes(3333));
  assert.ok(thin.x.every((value, i) => i === 0 || value > (thin.x[i - 1] ?? 0)));
  assert.deepEqual(thinMinMax(x, y, 10, 15, 400).x, [10, 11, 12, 13, 14]);
  assert.deepEqual(thinMinMax([0, 1], [NaN, 2], 0, 2, 10).y, [null, 2]);
  assert.deepEqual(new Set(thinMinMax(x, x.map(() => NaN), 0, n, 100).y), new Set([null]));
});

test("pixels to metres and back; what is under the pointer stays there", () => {
  const camera = new Camera();
  Object.assign(camera, { width: 800, height: 500, x: 3, y: -2, scale: 33, rotation: 0.7 });
  const near = (a: number[], b: number[]): void => a.forEach((value, i) => assert.ok(Math.abs(value - (b[i] ?? NaN)) < 1e-9));
  near(camera.toMetres(...camera.toPixels(7, 9)), [7, 9]);
  const under = camera.toMetres(100, 450);
  camera.zoom(2.5, 100, 450);
  near(camera.toMetres(100, 450), under);
  camera.rotate(-1.1, 100, 450);
  near(camera.toMetres(100, 450), under);
  const before = camera.toMetres(200, 200);
  camera.pan(30, -40);
  near(camera.toMetres(230, 160), before);
});

test("the matrix of the camera says the same as toPixels", () => {
  const camera = new Camera();
  Object.assign(camera, { width: 800, height: 500, x: 3, y: -2, scale: 33, rotation: -2 });
  const m = camera.clipMatrix();
  for (const [x, y] of [[0, 0], [5, -7], [-3, 2]] as const) {
    const [px, py] = camera.toPixels(x, y);
    const clip = [0, 1].map((row) => (m[row] ?? 0) * x + (m[3 + row] ?? 0) * y + (m[6 + row] ?? 0));
    assert.ok(Math.abs((clip[0] ?? 0) - (px / 400 - 1)) < 1e-12 && Math.abs((clip[1] ?? 0) - (1 - py / 250)) < 1e-12);
  }
});

test("fit shows the whole box, however it is turned", () => {
  for (const rotation of [0, 0.5, 2]) {
    const camera = new Camera();
    Object.assign(camera, { width: 900, height: 400, rotation });
    camera.fit(-10, 2, 30, 12);
    for (const [x, y] of [[-10, 2], [30, 2], [-10, 12], [30, 12]] as const) {
      const [px, py] = camera.toPixels(x, y);
      assert.ok(px >= 0 && px <= 900 && py >= 0 && py <= 400);
    }
  }
});

test("round lengths and fineness", () => {
  assert.deepEqual([roundLength(20, 56), roundLength(1000, 56), roundLength(1, 56)], [5, 0.1, 100]);
  assert.deepEqual([levelFor(100), levelFor(50), levelFor(10), levelFor(1000)], [0, 1, 3, 0]);
  const camera = new Camera();
  Object.assign(camera, { width: 100, height: 100, scale: 10 });
  assert.deepEqual(visible(camera, 10), [[-1, -1], [-1, 0], [0, -1], [0, 0]]);
});

test("triangles cover the polygon, whichever way it goes", () => {
  const shape: Point[] = [[0, 0], [4, 0], [4, 4], [2, 1], [0, 4]];
  for (const points of [shape, [...shape].reverse()]) {
    const corners = triangulate(points);
    assert.equal(corners.length, 9);
    let sum = 0;
    for (let i = 0; i < corners.length; i += 3) {
      const part = area2(corners.slice(i, i + 3));
      assert.ok(part > 0);
      sum += part;
    }
    assert.ok(Math.abs(sum - Math.abs(area2(shape))) < 1e-12);
  }
});

test("numbers as people read them", () => {
  assert.deepEqual([duration(59.96), duration(61.2), duration(3723.4, 0), fixed(-0.001, 2), fixed(-1.5, 1), fixed(NaN, 1), count(1234567)], ["1:00.0", "1:01.2", "1:02:03", "0.00", "\u22121.5", "\u2013", "1\u202f234\u202f567"]);
});
