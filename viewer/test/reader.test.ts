// SPDX-License-Identifier: Apache-2.0
// MCAP and CDR against bytes written by hand, and against the encoder of the tests.
import assert from "node:assert/strict";
import { test } from "node:test";
import { CdrReader } from "../src/stream/cdr.js";
import { McapReader, type Message } from "../src/stream/mcap.js";
import { readEstimate, readGrid, readScan } from "../src/stream/records.js";
import { StreamWriter, estimate, grid, kMagic, scan } from "./stream.js";

const hex = (text: string): Uint8Array => Uint8Array.from(text.replace(/\s+/g, "").match(/../g) ?? [], (byte) => parseInt(byte, 16));

test("CDR fields stand at multiples of their size, counted after the head", () => {
  // u8 7, pad 3, u32 1, f64 1.0 (at 8), u8 1, pad 3, string "ab"
  const reader = new CdrReader(hex("00010000 07000000 01000000 000000000000f03f 01000000 03000000 616200"));
  assert.equal(reader.u8(), 7);
  assert.equal(reader.u32(), 1);
  assert.equal(reader.f64(), 1);
  assert.equal(reader.bool(), true);
  assert.equal(reader.string(), "ab");
  assert.throws(() => reader.u8(), /CDR ends/);
});

test("CDR arrays: count, then values; an empty one of 8 bytes each takes no padding", () => {
  const reader = new CdrReader(hex("00010000 02000000 05000000 06000000 00000000 09"));
  assert.deepEqual([...reader.u32s()], [5, 6]);
  assert.equal(reader.f64s().length, 0);
  assert.equal(reader.u8(), 9);
});

test("CDR that is big-endian or lies about its length is refused", () => {
  assert.throws(() => new CdrReader(hex("00000000 00")), /little-endian/);
  assert.throws(() => new CdrReader(hex("00010000 ffffff7f 00")).f32s(), /CDR ends/);
});

const written = (): Uint8Array => {
  const writer = new StreamWriter();
  return new Uint8Array(Buffer.concat([writer.begin(), writer.message("/a", Uint8Array.of(1, 2, 3), "cdr", 42, 7n), writer.json("/b", { x: 1 }), writer.message("/a", Uint8Array.of(4), "cdr", 43, 8n)]));
};

function read(pieces: Uint8Array[]): Message[] {
  const out: Message[] = [];
  const reader = new McapReader((message) => out.push({ ...message, data: message.data.slice() }));
  for (const piece of pieces) reader.feed(piece);
  return out;
}

test("an MCAP message by hand", () => {
  const channel = "04 1900000000000000 0100 0000 06000000 2f7363616e31 03000000 636472 00000000";
  const message = "05 1700000000000000 0100 05000000 0200000000000000 0300000000000000 ff";
  const [one] = read([hex(`89 4d 43 41 50 30 0d 0a ${channel} ${message}`)]);
  assert.deepEqual({ ...one, data: [...(one?.data ?? [])] }, { topic: "/scan1", encoding: "cdr", sequence: 5, logTime: 2n, data: [255] });
});

test("a stream cut anywhere tells the same", () => {
  const bytes = written();
  const whole = read([bytes]);
  assert.equal(whole.length, 3);
  for (let cut = 0; cut <= bytes.length; ++cut) assert.deepEqual(read([bytes.subarray(0, cut), bytes.subarray(cut)]), whole);
  assert.deepEqual(read(Array.from(bytes, (byte) => Uint8Array.of(byte))), whole);
});

test("what is no MCAP, or a record beyond all bounds, is refused", () => {
  assert.throws(() => read([new TextEncoder().encode("<!doctype html>")]), /does not begin/);
  assert.throws(() => read([kMagic, hex("05 ffffffffffffff00 00")]), /record of/);
});

test("records come back as they were written", () => {
  const ranges = [1, Infinity, NaN, 79.5];
  const back = readScan(scan(5_000_000_007n, "laser0", -1, 0.5, ranges));
  assert.deepEqual([back.stamp, back.frame, back.angleMin, back.increment], [5_000_000_007n, "laser0", -1, 0.5]);
  assert.deepEqual([...Array.from(back.ranges)], ranges);
  const e = readEstimate(estimate({ stamp: 2_500_000_000n, scan: 9, key: 5, health: 1, isKey: true, score: 0.5, milliseconds: 2, particles: 100, pose: [1, 2, 3], covariance: [1, 2, 3, 4, 5, 6], frontEnd: [7, 8, 9] }));
  assert.deepEqual([e.time, e.scan, e.key, e.health, e.isKey, e.score, e.milliseconds, e.particles], [2.5, 9, 5, 1, true, 0.5, 2, 100]);
  assert.deepEqual([e.pose, e.covariance, e.odometry, e.frontEnd], [[1, 2, 3], [1, 2, 3, 4, 5, 6], [NaN, NaN, NaN], [7, 8, 9]]);
  const map = readGrid(grid(0.05, 2, 3, -1, -2, [-1, 0, 100, 50, -1, 3]));
  assert.deepEqual([[...map.data], map.width, map.height, map.origin.slice(0, 2)], [[-1, 0, 100, 50, -1, 3], 2, 3, [-1, -2]]);
  assert.throws(() => readGrid(grid(0.05, 2, 3, 0, 0, [0])), /with 1 cells/);
});
