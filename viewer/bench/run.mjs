// SPDX-License-Identifier: Apache-2.0
// Points in PixiJS and deck.gl: frames a second, bytes, first frame, memory.   node run.mjs [points] [page ...]
import { mkdtempSync, rmSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";
import { chromium } from "playwright-core";
import { memory, processorTime } from "./processes.mjs";

const points = Number(process.argv[2] ?? 1e6);
const pages = process.argv.length > 3 ? process.argv.slice(3) : ["pixi_mesh", "pixi_particles", "pixi_graphics", "deck_scatter", "deck_cloud"];

console.log("| page | bundle kB (gzip) | first frame ms | fps | 95 % ms | CPU ms a frame | JS heap MB | browser MB |\n|---|---|---|---|---|---|---|---|");
for (const page of pages) {
  const bundle = (await build({ entryPoints: [`${page}.js`], bundle: true, minify: true, format: "esm", write: false, logLevel: "error" })).outputFiles[0].contents;
  const server = createServer((request, response) => {
    const script = request.url.startsWith("/b.js");
    response.setHeader("content-type", script ? "text/javascript" : "text/html");
    response.end(script ? bundle : `<!doctype html><body style="margin:0"><script type="module" src="/b.js?points=${points}"></script>`);
  }).listen(0);
  const profile = mkdtempSync(join(tmpdir(), "bench-"));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    viewport: { width: 1600, height: 900 },
    args: ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox", "--enable-precise-memory-info"],
  });
  const tab = await context.newPage();
  tab.on("pageerror", (error) => console.error(page, error.message));
  tab.on("console", (message) => message.type() === "error" && console.error(page, message.text()));
  await tab.goto(`http://127.0.0.1:${server.address().port}/?points=${points}`, { waitUntil: "commit" });
  try {
    await tab.waitForFunction(() => window.started, undefined, { timeout: 120000 });
    const begin = processorTime(profile);
    await tab.waitForFunction(() => window.result, undefined, { timeout: 120000 });
    const r = await tab.evaluate(() => window.result);
    const cpu = Math.round((processorTime(profile) - begin) / r.frames);
    const kb = Math.round(bundle.length / 1000), gz = Math.round(gzipSync(bundle).length / 1000);
    console.log(`| ${page} | ${kb} (${gz}) | ${r.first_ms} | ${r.fps} | ${r.worst_ms} | ${cpu} | ${r.heap_mb} | ${memory(profile)} |`);
  } catch (error) { console.error(page, error.message.split("\n")[0]); }
  await context.close();
  rmSync(profile, { recursive: true, force: true });
  server.close();
}
