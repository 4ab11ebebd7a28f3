// SPDX-License-Identifier: Apache-2.0
// One browser for all topics. Without an address a server of the tests' own stands in for the program.
import assert from "node:assert/strict";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { type Browser, type Page, chromium } from "playwright-core";
import type { Hooks } from "../../viewer/src/hooks.js";
import { type TestServer, startServer } from "../../viewer/test/server.js";
import { roomsStream } from "../../viewer/test/stream.js";

declare global {
  interface Window {
    majak?: Hooks;
  }
}

const kLongestCommand = 60_000; // ms: a large run is optimised anew
const kFlags = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"];

let browser: Browser | undefined;
let server: TestServer | undefined;
export const address = process.argv.slice(2).find((argument) => argument.startsWith("http"));
export const shots = mkdtempSync(join(tmpdir(), "majak-e2e-"));

export function startAll(): void {
  before(async () => {
    browser = await chromium.launch({ executablePath: process.env["CHROMIUM"] ?? "/usr/bin/chromium", args: kFlags });
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
    rmSync(shots, { recursive: true, force: true });
  });
}

export async function ownServer(): Promise<TestServer> {
  server ??= await startServer(roomsStream(), "dist");
  Object.assign(server, { refuse: "", answerAfter: 0 });
  return server;
}

export interface OpenOptions {
  width?: number;
  height?: number;
  url?: string;
  dark?: boolean;
  watch?: (page: Page) => void; ///< before anything is loaded
  own?: boolean; ///< the tests' own server, whatever address was given
}

/// A page with the whole stream in it.
export async function open({ width = 940, height = 600, url, dark = false, watch, own = false }: OpenOptions = {}): Promise<Page> {
  assert.ok(browser);
  const page = await browser.newPage({ viewport: { width, height }, colorScheme: dark ? "dark" : "light", reducedMotion: "reduce" });
  page.setDefaultTimeout(15000);
  watch?.(page);
  await page.goto(url ?? (own ? undefined : address) ?? (await ownServer()).url);
  await loaded(page);
  return page;
}

/// All scans that the run speaks of are there and drawn.
export async function loaded(page: Page): Promise<void> {
  await page.waitForFunction(() => {
    const m = window.majak;
    return m && m.session.link !== "connecting" && m.counts()["scans"]! > 0 && m.counts()["estimates"]! > 0 && m.counts()["frames"]! > 1;
  });
  await settled(page);
}

/// Nothing has been drawn for a moment, and nothing is left to paint.
export async function settled(page: Page): Promise<void> {
  await page.evaluate(async () => {
    const next = (): Promise<number> => new Promise((done) => requestAnimationFrame(done));
    for (let quiet = 0, last = -1; quiet < 4; ) {
      await next();
      const now = window.majak!.counts()["frames"]!;
      quiet = now === last && window.majak!.map.finished() ? quiet + 1 : 0;
      last = now;
    }
  });
}

/// The map as it looks, as PNG.
export async function picture(page: Page): Promise<Buffer> {
  await settled(page);
  const box = await page.locator(".map-canvas").boundingBox();
  assert.ok(box);
  // Without the cards that float at its sides.
  return page.screenshot({ clip: { x: box.x + 190, y: box.y + 60, width: box.width - 250, height: box.height - 100 } });
}

export const count = (page: Page, what: string): Promise<number> => page.evaluate((name) => window.majak!.counts()[name] ?? 0, what);

export const camera = (page: Page): Promise<{ x: number; y: number; scale: number; rotation: number }> =>
  page.evaluate(() => {
    const { x, y, scale, rotation } = window.majak!.map.camera;
    return { x, y, scale, rotation };
  });

export const time = (page: Page): Promise<number> => page.evaluate(() => window.majak!.session.time);
export const row = (page: Page): Promise<number> => page.evaluate(() => window.majak!.session.row());

/// Pixel of the page where that place of the map (m) is.
export const pixelOf = (page: Page, x: number, y: number): Promise<[number, number]> =>
  page.evaluate(([mx, my]) => {
    const box = document.querySelector(".map-canvas")!.getBoundingClientRect();
    const [px, py] = window.majak!.map.camera.toPixels(mx, my);
    return [box.left + px, box.top + py] as [number, number];
  }, [x, y] as const);

/// Middle of the map on the page, moved by so many pixels.
export async function middle(page: Page, dx = 0, dy = 0): Promise<[number, number]> {
  const box = await page.locator(".map-canvas").boundingBox();
  assert.ok(box);
  return [Math.round(box.x + box.width / 2 + dx), Math.round(box.y + box.height / 2 + dy)]; // the mouse knows whole pixels only
}

export async function drag(page: Page, from: readonly [number, number], to: readonly [number, number], button: "left" | "right" = "left"): Promise<void> {
  await page.mouse.move(...from);
  await page.mouse.down({ button });
  await page.mouse.move((from[0] + to[0]) / 2, (from[1] + to[1]) / 2);
  await page.mouse.move(...to);
  await page.mouse.up({ button });
}

/// The newest command, once its fate is known.
export async function lastCommand(page: Page): Promise<{ do: string; fate: string; error: string }> {
  await page.waitForFunction(() => window.majak!.session.commands.log.length > 0 && window.majak!.session.commands.pending().length === 0, undefined, { timeout: kLongestCommand });
  return page.evaluate(() => {
    const { do: what, fate, error } = window.majak!.session.commands.log.at(-1)!;
    return { do: what, fate, error };
  });
}

export const openTab = (page: Page, name: string): Promise<void> => page.getByRole("tab", { name }).click();

let shared: Page | undefined;
let errors: string[] = [];

/// The page that topics share, as it was when it was opened: opening one takes seconds without a graphics card.
async function sharedPage(): Promise<Page> {
  if (shared) {
    await shared.evaluate(() => window.majak!.reset());
    await settled(shared);
    return shared;
  }
  shared = await open();
  shared.on("pageerror", (error) => errors.push(error.message));
  return shared;
}

/// A topic on the shared page, or with options of its own on one of its own. After a failure the next gets a new page.
export function topic(name: string, steps: (page: Page) => Promise<void>, options?: OpenOptions): void {
  test(name, async () => {
    errors = [];
    const page = options ? await open(options) : await sharedPage();
    try {
      await steps(page);
      assert.deepEqual(errors, []);
    } catch (error) {
      if (process.env["SHOTS"] && existsSync(process.env["SHOTS"])) await page.screenshot({ path: join(process.env["SHOTS"], `${name.replace(/\W+/g, "_")}.png`) });
      if (page === shared) shared = undefined;
      await page.close();
      throw error;
    }
    if (page !== shared) await page.close();
  });
}

/// A topic that needs the tests' own server.
export function ownTopic(name: string, steps: (page: Page, server: TestServer) => Promise<void>, options?: OpenOptions): void {
  topic(name, async (page) => steps(page, await ownServer()), address ? { ...options, own: true } : options);
}
