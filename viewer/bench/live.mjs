// SPDX-License-Identifier: Apache-2.0
// node bench/live.mjs URL SECONDS [CLIENTS [STALLED]]: a page that shows live work, beside so many other clients of which some take
// nothing: scan to pixel, frames a second, the server's memory, every half minute.
import { chromium } from "playwright-core";
import { WebSocket } from "ws";

const [url, seconds = "60", clients = "0", stalled = "0"] = process.argv.slice(2);
const others = [];
for (let i = 0; i < +clients; ++i) {
  const socket = new WebSocket(url.replace("http", "ws") + "stream", { origin: new URL(url).origin });
  const one = { socket, bytes: 0 };
  socket.on("message", (data) => (one.bytes += data.length));
  socket.on("error", () => {});
  if (i < +stalled) socket.on("open", () => socket._socket.pause());
  others.push(one);
}

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"],
});
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
await page.goto(url);
await page.waitForFunction(() => window.majak?.counts().frames > 1);
await page.waitForTimeout(3000);
await page.evaluate(() => window.majak.resetLatency());
console.log("   s  scan to pixel ms   fps  scans/s  server MB  heap MB  estimates");
for (let t = 0; t < +seconds; ) {
  const wait = Math.min(30, +seconds - t);
  await page.waitForTimeout(1000 * wait);
  t += wait;
  const now = await page.evaluate(() => {
    const { latency, fps, counts, session } = window.majak;
    return { latency: latency(), fps: fps(), status: session.model.status, heap: performance.memory.usedJSHeapSize / 1e6, estimates: counts().estimates };
  });
  const cells = [[t, 0, 4], [now.latency, 1, 18], [now.fps, 1, 6], [now.status.scans_per_second, 1, 9], [now.status.memory_mb, 0, 11], [now.heap, 1, 9], [now.estimates, 0, 11]];
  console.log(cells.map(([value, digits, width]) => Number(value ?? NaN).toFixed(digits).padStart(width)).join(""));
}
console.log(`others: ${others.map((one) => (one.bytes / 1e6).toFixed(1)).join(" ")} MB`);
for (const one of others) one.socket.terminate();
await browser.close();
