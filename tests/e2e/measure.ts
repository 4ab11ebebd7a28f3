// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { middle, pixelOf, settled, topic } from "./harness.js";

topic("measure: distances between clicks and their sum in metres", async (page) => {
  await page.getByRole("button", { name: /Measure/ }).click();
  const start = await page.evaluate(() => window.majak!.map.camera.toMetres(window.majak!.map.camera.width / 2, window.majak!.map.camera.height / 2));
  for (const [dx, dy] of [[0, 0], [1, 0], [1, 1]] as const) await page.mouse.click(...(await pixelOf(page, start[0] + dx, start[1] + dy)));
  await settled(page);
  const labels = await page.locator(".map-words .measure").allTextContents();
  const metres = labels.map((label) => Number(/([\d.]+) m/.exec(label)?.[1]));
  const scale = await page.evaluate(() => window.majak!.map.camera.scale);
  const pixel = 2.5 / scale; // clicks land on whole pixels
  for (const [i, expected] of [1, 1].entries()) assert.ok(Math.abs((metres[i] ?? 0) - expected) <= pixel, labels.join("; "));
  assert.ok(Math.abs((metres.at(-1) ?? 0) - 2) <= 2 * pixel && labels.at(-1)?.startsWith("total"), labels.join("; "));
  await page.keyboard.press("Backspace");
  assert.equal(await page.evaluate(() => window.majak!.map.hand.points.length), 2);
  await page.keyboard.press("Escape");
  await page.keyboard.press("Escape");
  assert.equal(await page.evaluate(() => window.majak!.session.tool), "look");
  await page.mouse.move(...(await middle(page)));
  assert.match((await page.locator(".pointer-place").textContent()) ?? "", /x .* y .* m/);
});
