// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { drag, topic } from "./harness.js";

topic("a click in a chart goes there, a drag zooms, a double click shows all", async (page) => {
  const plot = page.getByRole("region", { name: "Score" }).locator(".u-over");
  await plot.waitFor();
  const box = await plot.boundingBox();
  assert.ok(box);
  const place = (): Promise<number> => page.evaluate(() => window.majak!.session.axis.place(window.majak!.session.time) / window.majak!.session.axis.length);
  const y = box.y + box.height / 2;
  await page.mouse.click(box.x + 0.25 * box.width, y);
  assert.ok(Math.abs((await place()) - 0.25) < 0.02);
  await drag(page, [box.x + 0.5 * box.width, y], [box.x + 0.75 * box.width, y]);
  assert.ok(Math.abs((await place()) - 0.25) < 0.02, "a drag is no click");
  await page.waitForTimeout(600);
  await page.mouse.click(box.x + 0.5 * box.width, y);
  assert.ok(Math.abs((await place()) - 0.625) < 0.02);
  await page.mouse.dblclick(box.x + 0.5 * box.width, y);
  await page.waitForTimeout(600);
  await page.mouse.click(box.x + 0.1 * box.width, y);
  assert.ok(Math.abs((await place()) - 0.1) < 0.02);
  // All charts of one run stand beside each other.
  assert.ok((await page.locator(".chart:not([hidden])").count()) >= 3);
});
