// SPDX-License-Identifier: Apache-2.0
// node build.mjs: dist/{index.html,viewer.js,viewer.css};  --tests: build/test;  --all: both and the e2e tests.
import { cpSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const wants = (name) => process.argv.includes(name) || process.argv.includes("--all");

async function page() {
  mkdirSync("dist", { recursive: true });
  await build({
    entryPoints: { viewer: "src/main.ts" },
    bundle: true,
    minify: true,
    format: "iife",
    globalName: "majakViewer",
    target: "es2022",
    legalComments: "eof",
    outdir: "dist",
    logLevel: "warning",
  });
  // uPlot's rules, then ours, in one file.
  writeFileSync("dist/viewer.css", readFileSync("node_modules/uplot/dist/uPlot.min.css", "utf8") + readFileSync("src/style.css", "utf8"));
  cpSync("src/index.html", "dist/index.html");
}

async function programs(entryPoints, to) {
  await build({ entryPoints, bundle: true, platform: "node", format: "esm", target: "node18", external: ["ws", "playwright-core", "axe-core"], tsconfigRaw: {}, outdir: to, logLevel: "warning" });
}

if (!process.argv.includes("--tests")) await page();
if (wants("--tests")) await programs(readdirSync("test").filter((name) => name.endsWith(".ts")).map((name) => `test/${name}`), "build/test");
if (wants("--all")) await programs(["../tests/e2e/run.ts"], "build/e2e");
