// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import type { Page } from "playwright-core";
import { count, drag, lastCommand, middle, openTab, ownTopic, picture, topic } from "./harness.js";

const take = (page: Page, name: string): Promise<void> => page.getByRole("button", { name, exact: true }).click();

async function clicks(page: Page, places: readonly (readonly [number, number])[]): Promise<void> {
  for (const [dx, dy] of places) await page.mouse.click(...(await middle(page, dx, dy)));
}

topic("every edit tool: drawn, confirmed, listed, shown; undo and redo", async (page) => {
  await openTab(page, "Edit");
  if (!(await page.getByRole("button", { name: "Erase a box" }).isEnabled())) return; // this run may not be changed
  const first = await count(page, "edits");
  const done = async (name: string): Promise<void> => {
    assert.deepEqual(await lastCommand(page), { do: "edit", fate: "done", error: "" }, name);
    await page.keyboard.press("Escape");
  };
  const before = await picture(page);
  await take(page, "Erase a box");
  await drag(page, await middle(page, -40, -30), await middle(page, 20, 10));
  await done("erase a box");
  await take(page, "Erase an area");
  await clicks(page, [[-60, 20], [-20, 30], [-40, 60]]);
  await page.keyboard.press("Enter");
  await done("erase an area");
  await take(page, "Add a wall");
  await clicks(page, [[10, 30], [60, 30]]);
  await page.keyboard.press("Enter");
  await done("wall");
  await take(page, "Forbidden zone");
  await clicks(page, [[30, -20], [60, -20]]);
  await page.mouse.dblclick(...(await middle(page, 50, -60)));
  await done("forbidden");
  await take(page, "Crop");
  await page.locator(".map-canvas").focus();
  for (const key of ["Enter", "Shift+ArrowLeft", "Enter", "Shift+ArrowUp", "Enter", "Shift+Enter", "Shift+ArrowRight", "Shift+ArrowDown"]) await page.keyboard.press(key);
  await done("crop");
  await take(page, "Turn by a line");
  await drag(page, await middle(page, -50, 0), await middle(page, 50, 10));
  await done("turn");
  await take(page, "Turn upright");
  await done("upright");
  const all = await count(page, "edits");
  assert.equal(all, first + 7);
  assert.ok(!before.equals(await picture(page)));
  const kinds = await page.evaluate((n) => window.majak!.session.model.edits.edits.slice(n).map((one) => one.kind), first);
  assert.deepEqual(kinds.slice(0, 6), ["erase", "erase", "wall", "forbidden", "crop", "turn"]);
  assert.ok(((await page.locator(".saving").textContent()) ?? "").includes("on the disk"));

  for (let i = 1; i <= 7; ++i) {
    await page.keyboard.press("Control+z");
    await lastCommand(page);
    await page.waitForFunction((n) => window.majak!.counts()["edits"] === n, all - i);
  }
  await page.keyboard.press("Control+Shift+Z");
  await lastCommand(page);
  await page.waitForFunction((n) => window.majak!.counts()["edits"] === n, first + 1);
  await page.keyboard.press("Control+z");
  await lastCommand(page);
  await page.waitForFunction((n) => window.majak!.counts()["edits"] === n, first);
  await page.getByRole("button", { name: "Write files" }).click();
  assert.deepEqual(await lastCommand(page), { do: "write_files", fate: "done", error: "" });
});

ownTopic("edits say where they lie, a line how far the map turns; nothing is sent for what was not finished", async (page, server) => {
  await openTab(page, "Edit");
  const metres = (dx: number, dy: number): Promise<[number, number]> => page.evaluate(([x, y]) => window.majak!.map.camera.toMetres(window.majak!.map.camera.width / 2 + x, window.majak!.map.camera.height / 2 + y), [dx, dy] as const);
  const last = (): { edit: { points: [number, number][]; radians: number } } => server.received.at(-1) as never;
  await take(page, "Add a wall");
  await clicks(page, [[-30, 30], [40, 30]]);
  await page.keyboard.press("Enter");
  await lastCommand(page);
  const expected = [await metres(-30, 30), await metres(40, 30)];
  last().edit.points.forEach(([x, y], i) => assert.ok(Math.hypot(x - (expected[i]?.[0] ?? NaN), y - (expected[i]?.[1] ?? NaN)) < 0.05));
  await take(page, "Turn by a line");
  await drag(page, await middle(page, -100, 0), await middle(page, 100, 20));
  await lastCommand(page);
  assert.ok(Math.abs(last().edit.radians - Math.atan2(20, 200)) < 0.01, `${last().edit.radians}`);
  const sent = server.received.length;
  await take(page, "Erase an area");
  await clicks(page, [[0, 0], [20, 0]]);
  await page.keyboard.press("Enter"); // two corners are no area
  await page.keyboard.press("Escape");
  await page.keyboard.press("Escape");
  assert.equal(server.received.length, sent);
  for (let i = 0; i < 2; ++i) {
    await page.keyboard.press("Control+z");
    await lastCommand(page);
  }
});
