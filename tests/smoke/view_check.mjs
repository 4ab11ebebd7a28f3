// SPDX-License-Identifier: Apache-2.0
// node view_check.mjs MAJAK ROOT: in a folder with short.log and its run; see view.sh.
import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { statSync } from "node:fs";
import { createRequire } from "node:module";

const [majak, root] = process.argv.slice(2);
const { WebSocket } = createRequire(`${root}/viewer/package.json`)("ws");
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

async function until(what, test, seconds = 30) {
  for (const end = Date.now() + 1000 * seconds; Date.now() < end; await sleep(20)) {
    const value = test();
    if (value) return value;
  }
  throw new Error(`waited in vain for ${what}`);
}

/// The program, and the address that it prints.
async function start(...words) {
  const child = spawn(majak, words, { stdio: ["ignore", "pipe", "inherit"] });
  const program = { child, text: "" };
  child.stdout.on("data", (data) => (program.text += data));
  child.on("exit", (code, signal) => (program.end = signal ?? code));
  const url = await until("an address", () => /view: +(http:\/\/\S+)/.exec(program.text)?.[1]);
  return Object.assign(program, { url, origin: new URL(url).origin });
}

async function ended(program, signal) {
  program.child.kill(signal);
  return until("its end", () => program.end !== undefined && { code: program.end });
}

/// All that a page is told, by topic.
class Page {
  constructor({ url, origin }, from = origin) {
    this.socket = new WebSocket(url.replace("http", "ws") + "stream", { origin: from });
    this.socket.on("message", (data, binary) => (binary ? this.take(data) : this.answer(JSON.parse(data.toString()))));
    this.socket.on("error", (error) => (this.error = error.message));
    Object.assign(this, { topics: new Map(), count: {}, json: {}, newest: {}, answers: new Map(), rest: Buffer.alloc(0), id: 0 });
  }
  take(data) {
    this.rest = Buffer.concat([this.rest, data]);
    if (!this.begun) this.rest = this.rest.subarray(8), (this.begun = true);
    while (this.rest.length >= 9) {
      const size = Number(this.rest.readBigUInt64LE(1));
      if (this.rest.length < 9 + size) return;
      this.record(this.rest[0], this.rest.subarray(9, 9 + size));
      this.rest = this.rest.subarray(9 + size);
    }
  }
  record(opcode, bytes) {
    if (opcode === 4) this.topics.set(bytes.readUInt16LE(0), bytes.subarray(8, 8 + bytes.readUInt32LE(4)).toString());
    if (opcode !== 5) return;
    const topic = this.topics.get(bytes.readUInt16LE(0));
    this.count[topic] = (this.count[topic] ?? 0) + 1;
    this.newest[topic] = bytes.readUInt32LE(2);
    if (bytes[22] === 0x7b || bytes[22] === 0x5b) this.json[topic] = JSON.parse(bytes.subarray(22).toString());
  }
  answer(reply) {
    this.answers.set(reply.id, reply);
  }
  async ask(command) {
    const id = ++this.id;
    this.socket.send(JSON.stringify({ id, ...command }));
    return until(`an answer to ${command.do}`, () => this.answers.get(id));
  }
  async done(command) {
    const reply = await this.ask(command);
    assert.equal(reply.ok, true, `${command.do}: ${reply.error}`);
  }
  async refused(command, why) {
    const reply = await this.ask(command);
    assert.equal(reply.ok, false, command.do);
    assert.match(reply.error, why);
  }
}

const wall = { do: "edit", edit: { kind: "wall", points: [[0, 1], [1, 1]] } };

let program = await start("view", "run");
let page = new Page(program);
await until("the run", () => page.json["/run"] && page.count["/scan"] >= page.json["/run"].scans);
assert.equal(page.count["/estimate"], page.json["/run"].scans);
for (const topic of ["/map", "/graph", "/closures", "/edits", "/truth"]) assert.ok(page.count[topic] > 0, topic);
await until("walls", () => page.count["/segments"]);
assert.equal((await fetch(program.url)).status, 200);
assert.equal((await fetch(program.origin + "/site.majak")).status, 404);

const stranger = new Page(program, "http://elsewhere.example");
await until("a refusal", () => stranger.error);
assert.match(stranger.error, /403/);

// Corrections are told, can be undone and done again, and are on the disk when the page is told so.
await page.done(wall);
await until("the wall", () => page.json["/edits"].edits.length === 1);
await page.done({ do: "undo" });
await page.refused({ do: "undo" }, /nothing to undo/);
await page.done({ do: "redo" });
await page.refused({ do: "redo" }, /nothing to do again/);
await page.done({ do: "edit", edit: { kind: "upright" } });
await page.done({ do: "undo" });
await page.refused({ do: "kidnap", pose: [0, 0, 0] }, /no robot/);
await page.refused({ do: "switch_closure", from: 1, to: 2, on: false }, /closure/);
const closure = page.json["/closures"].find((one) => one.enabled);
if (closure) {
  const estimates = page.count["/estimate"];
  await page.done({ do: "switch_closure", from: closure.from, to: closure.to, on: false });
  await until("new poses", () => page.count["/estimate"] === estimates + page.json["/run"].scans);
  await until("the closure off", () => page.json["/closures"].some((one) => one.from === closure.from && one.to === closure.to && one.by_hand && !one.enabled));
  await page.done({ do: "undo" });
  await page.done({ do: "redo" });
}
await until("all edits", () => page.json["/edits"].edits.length === (closure ? 2 : 1));
const kept = JSON.stringify(page.json["/edits"].edits.map((one) => one.kind));
await ended(program, "SIGKILL");
const listed = spawnSync(majak, ["edit", "run", "--list"], { encoding: "utf8" }).stdout;
assert.match(listed, /wall/);
if (closure) assert.match(listed, new RegExp(`closure_off ${closure.from}-${closure.to}`));

// The same again after the kill; the files of the run follow when asked for, or at the end.
program = await start("view", "run");
page = new Page(program);
await until("the edits", () => page.json["/edits"]);
assert.equal(JSON.stringify(page.json["/edits"].edits.map((one) => one.kind)), kept);
const before = statSync("run/map.png").mtimeMs;
await sleep(20);
await page.done({ do: "write_files" });
assert.ok(statSync("run/map.png").mtimeMs > before);

// A robot that does not know where it is.
await until("the whole run", () => page.count["/scan"] >= page.json["/run"].scans);
const { scans, begin } = page.json["/run"];
await page.refused({ do: "localize", method: "kalman" }, /map/);
await page.done({ do: "localize", method: "monte-carlo" });
await until("particles", () => page.count["/particles"] > 3 && page.newest["/estimate"] >= scans);
assert.equal(page.json["/run"].state, "localizing");
await page.refused(wall, /stop it first/);
await page.done({ do: "start_pose", pose: [0, 0, 0] });
await page.done({ do: "kidnap", pose: [0, 0, 1] });
await page.refused({ do: "kidnap", pose: [1e5, 0, 0] }, /./);
const particles = page.count["/particles"];
await until("more particles", () => page.count["/particles"] > particles + 2);
await page.done({ do: "stop_localizing" });
await until("the run again", () => page.json["/run"].state === "finished" && page.json["/run"].begin === begin);
// What is erased goes from the scans that the page has; undone, it comes back.
let told = -1;
for (; told !== page.count["/scan"]; await sleep(500)) told = page.count["/scan"];
await page.done({ do: "edit", edit: { kind: "erase", points: [[-50, -50], [50, -50], [50, 50], [-50, 50]] } });
const erased = (await until("erased scans", () => page.count["/scan"] > told && page.count["/scan"])) - told;
await page.done({ do: "undo" });
await until("the scans as they were", () => page.count["/scan"] === told + 2 * erased);
await page.done({ do: "redo" });
const written = statSync("run/map.png").mtimeMs;
assert.equal((await ended(program, "SIGINT")).code, 0);
assert.ok(statSync("run/map.png").mtimeMs > written, "the run's files are older than its corrections");

// Work that is watched, then corrected.
program = await start("map", "short.log", "-o", "watched", "--view");
page = new Page(program);
await until("the finished map", () => page.json["/run"]?.state === "finished");
await until("a folder", () => /report: +watched/.test(program.text));
await page.done(wall);
assert.equal((await ended(program, "SIGINT")).code, 0);
program = await start("view", "short.log");
page = new Page(program);
await until("the finished map", () => page.json["/run"]?.state === "finished");
await page.refused({ do: "write_files" }, /folder/);
await page.done(wall);
assert.equal((await ended(program, "SIGTERM")).code, 0);
console.log("the page was told all that it should be");
