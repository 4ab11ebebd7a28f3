// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { StreamWriter, estimate, runRecord, scanAt, way } from "../../viewer/test/stream.js";
import { count, loaded, openTab, ownTopic } from "./harness.js";

ownTopic("a broken connection is told, tried again, and unconfirmed commands are not sent twice", async (page, server) => {
  await openTab(page, "Edit");
  server.answerAfter = -1;
  const before = server.received.length;
  await page.getByRole("button", { name: "Write files" }).click();
  await page.waitForFunction(() => document.querySelector(".saving")!.textContent!.includes("not confirmed yet"));
  server.dropAll();
  await page.locator(".banner").waitFor();
  await page.waitForFunction(() => document.querySelector(".saving")!.textContent!.includes("not sent again"));
  assert.ok((await count(page, "scans")) > 0, "what was there is still shown");
  await page.locator(".banner").waitFor({ state: "hidden" });
  await loaded(page);
  assert.equal(server.received.length, before + 1);
  assert.ok((await page.locator(".saving").textContent())?.includes("Write files"));
});

ownTopic("live: the time sticks to the newest scan until it is moved, and again by the button", async (page, server) => {
  const poses = way();
  const n = poses.length;
  const writer = new StreamWriter(500);
  const send = (i: number): void => {
    const pose = poses[i % n] ?? [1, 5, 0];
    const now = BigInt(Date.now()) * 1_000_000n;
    server.send(writer.message("/scan", scanAt(i, pose, now), "cdr", i, now));
    server.send(writer.message("/estimate", estimate({ stamp: now, scan: i, key: i, isKey: true, pose }), "cdr", i, now));
  };
  const row = (): Promise<number> => page.evaluate(() => window.majak!.session.row());
  server.send(writer.json("/run", runRecord(n, "mapping")));
  await page.getByRole("button", { name: "Live" }).waitFor();
  for (let i = n; i < n + 5; ++i) {
    send(i);
    await page.waitForFunction((wanted) => window.majak!.session.row() === wanted && window.majak!.map.layers.scanDrawn === wanted, i);
  }
  const latency = await page.evaluate(() => window.majak!.latency());
  assert.ok(latency > 0 && latency < 5000, `${latency} ms`);
  await page.keyboard.press("ArrowLeft");
  const held = await row();
  send(n + 5);
  await page.waitForFunction((size) => window.majak!.session.model.estimates.size === size, n + 6);
  assert.equal(await row(), held);
  await page.getByRole("button", { name: "Live" }).click();
  await page.waitForFunction((wanted) => window.majak!.session.row() === wanted, n + 5);
}, {});
