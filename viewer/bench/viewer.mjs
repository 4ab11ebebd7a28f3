// SPDX-License-Identifier: Apache-2.0
// The viewer itself: frames a second, processor time a frame, memory.   node viewer.mjs URL [returns]
// Returns: so many made-up ones take the place of the run's, for panning and zooming (default 10^6).
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";
import { memory, processorTime } from "./processes.mjs";

const [url, returns = "1000000"] = process.argv.slice(2);
const profile = mkdtempSync(join(tmpdir(), "bench-"));
const context = await chromium.launchPersistentContext(profile, {
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  viewport: { width: 1600, height: 900 },
  args: ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox", "--enable-precise-memory-info"],
});
const tab = await context.newPage();
const begin = performance.now();
await tab.goto(url, { waitUntil: "commit" });
await tab.waitForFunction(() => (window.majak?.map.frames ?? 0) > 0);
console.log(`first picture after ${Math.round(performance.now() - begin)} ms`);
await tab.waitForFunction(() => {
  const m = window.majak.session.model;
  return m.estimates.size > 0 && m.scans.count >= Math.min(m.run.scans, m.estimates.size);
}, undefined, { timeout: 60000 });
console.log(`whole run after ${Math.round(performance.now() - begin)} ms`, await tab.evaluate(() => majak.counts()));
await tab.waitForTimeout(1500);

console.log("| what | fps | CPU ms a frame |\n|---|---|---|");
async function measure(name, setUp, step) {
  await tab.evaluate(setUp, Number(returns));
  await tab.waitForTimeout(800);
  const before = processorTime(profile);
  const [frames, ms] = await tab.evaluate(async (source) => {
    const each = new Function("n", source);
    const from = performance.now();
    let n = 0;
    for (; performance.now() - from < 5000; ++n) {
      each(n);
      await new Promise((done) => requestAnimationFrame(done));
    }
    return [n, performance.now() - from];
  }, step);
  console.log(`| ${name} | ${((1000 * frames) / ms).toFixed(1)} | ${((processorTime(profile) - before) / frames).toFixed(0)} |`);
}
const pan = "majak.map.camera.pan(8 * Math.sin(n / 9), 5 * Math.cos(n / 9)); majak.session.touch();";
const zoom = "majak.map.camera.zoom(Math.exp(0.04 * Math.sin(n / 15))); majak.session.touch();";
await measure("at rest", () => undefined, "");
await measure("pan, map and trail", () => undefined, pan);
const many = (count) => {
  const { map, session } = majak;
  map.layers.on.set("points", true);
  map.layers.on.set("grid", false);
  session.touch();
  requestAnimationFrame(() => requestAnimationFrame(() => {
    const box = session.model.map;
    const xy = new Float32Array(2 * count);
    for (let i = 0; i < count; ++i) {
      const wall = i % 97;
      const along = ((i * 7919) % 10007) / 10007;
      const [u, v] = wall % 2 ? [along, (wall % 13) / 13] : [(wall % 17) / 17, along];
      xy[2 * i] = box.origin[0] + u * box.width * box.resolution + 0.01 * Math.sin(i);
      xy[2 * i + 1] = box.origin[1] + v * box.height * box.resolution + 0.01 * Math.cos(i);
    }
    map.layers.points.set(xy);
    session.touch();
  }));
};
await measure(`pan, ${returns} returns`, many, pan);
await measure(`zoom, ${returns} returns`, () => undefined, zoom);
await measure("play at 50 times the speed", () => {
  const { map, session } = majak;
  map.layers.on.set("points", false);
  map.layers.on.set("grid", true);
  map.fit();
  session.speed = 50;
  session.goToRow(0);
  session.play(true);
}, "");
const heap = await tab.evaluate(() => performance.memory.usedJSHeapSize / 1e6);
console.log(`JS heap ${heap.toFixed(0)} MB, browser ${memory(profile)} MB, scans ${((await tab.evaluate(() => majak.counts().scanBytes)) / 1e6).toFixed(1)} MB`);
await context.close();
rmSync(profile, { recursive: true, force: true });
