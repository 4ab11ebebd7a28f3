// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { camera, lastCommand, openTab, ownTopic, picture, settled, topic } from "./harness.js";

topic("closures: sort, look at both scans, switch off, undo", async (page) => {
  await openTab(page, "Closures");
  const rows = page.locator("tbody tr");
  const scores = async (): Promise<number[]> => (await rows.locator("td:nth-child(3)").allTextContents()).map(Number);
  const sortByScore = async (): Promise<void> => {
    await page.getByRole("button", { name: "score" }).click();
    await settled(page);
  };
  await sortByScore();
  const falling = await scores();
  assert.deepEqual(falling, [...falling].sort((a, b) => b - a));
  await sortByScore();
  const rising = await scores();
  assert.deepEqual(rising, [...rising].sort((a, b) => a - b));

  const before = await camera(page);
  await rows.first().focus();
  await page.keyboard.press("Enter");
  await settled(page);
  assert.notDeepEqual(await camera(page), before);
  assert.equal(await rows.first().getAttribute("aria-selected"), "true");
  const inked = await page.evaluate(() => Array.from(document.querySelectorAll<HTMLCanvasElement>(".pair canvas"), (canvas) => canvas.getContext("2d")!.getImageData(0, 0, canvas.width, canvas.height).data.filter((value, i) => i % 4 === 3 && value > 0).length));
  assert.ok(inked.length === 2 && (inked[1] ?? 0) > 50, inked.join(" "));

  const toggle = page.getByRole("button", { name: /^Switch o/ });
  if (!(await toggle.isEnabled())) return; // this run may not be changed
  const enabled = (): Promise<boolean[]> => page.evaluate(() => window.majak!.session.model.closures.map((one) => one.enabled));
  const was = await enabled();
  await toggle.click();
  assert.deepEqual(await lastCommand(page), { do: "switch_closure", fate: "done", error: "" });
  const is = await enabled();
  assert.equal(is.filter((value, i) => value !== was[i]).length, 1);
  await page.locator(".page:visible").getByRole("button", { name: "Undo" }).click();
  assert.equal((await lastCommand(page)).do, "undo");
  await page.waitForFunction((all) => JSON.stringify(window.majak!.session.model.closures.map((one) => one.enabled)) === all, JSON.stringify(was));
});

ownTopic("a closure's switch tells that it works, and an error", async (page, server) => {
  await openTab(page, "Closures");
  await page.locator("tbody tr").first().click();
  server.answerAfter = 700;
  const shown = await picture(page);
  await page.getByRole("button", { name: /^Switch o/ }).click();
  assert.ok(await page.getByRole("button", { name: "Working" }).isDisabled());
  assert.equal((await lastCommand(page)).fate, "done");
  Object.assign(server, { answerAfter: 0, refuse: "the disk is full" });
  await page.getByRole("button", { name: /^Switch o/ }).click();
  assert.equal((await lastCommand(page)).error, "the disk is full");
  await page.waitForFunction(() => document.querySelector(".status")!.textContent!.includes("the disk is full"));
  assert.ok(shown.length > 0);
  server.refuse = "";
  await page.getByRole("button", { name: /^Switch o/ }).click();
  await lastCommand(page);
});
