// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { openTab, picture, pixelOf, row, topic } from "./harness.js";

topic("a click on a pose goes to its time and shows its scan, pose, health and match", async (page) => {
  await openTab(page, "Run");
  const pose = await page.evaluate(() => {
    // One of the first half that is near the middle of the view, where no card lies over the map.
    const { map, session } = window.majak!;
    const { estimates } = session.model;
    const poses = Array.from({ length: Math.floor(estimates.size / 2) }, (_, row) => estimates.pose(row));
    const far = ([x, y]: readonly [number, number, number]): number => Math.hypot(x - map.camera.x, y - map.camera.y);
    return poses.reduce((best, pose) => (far(pose) < far(best) ? pose : best));
  });
  const before = await picture(page);
  await page.mouse.click(...(await pixelOf(page, pose[0], pose[1])));
  const now = await page.evaluate(() => window.majak!.session.model.estimates.pose(window.majak!.session.row()));
  const scale = await page.evaluate(() => window.majak!.map.camera.scale);
  assert.ok(Math.hypot(now[0] - pose[0], now[1] - pose[1]) < 14 / scale);
  assert.equal(await page.evaluate(() => window.majak!.session.selected), await row(page));
  assert.ok(!before.equals(await picture(page)));
  assert.equal(await page.getByRole("tab", { name: "Pose" }).getAttribute("aria-selected"), "true");
  const facts = (await page.locator(".facts:visible").textContent()) ?? "";
  for (const word of ["Scan", "Time", "Health", "\u00b1", "Heading", "Score"]) assert.ok(facts.includes(word), word);
});
