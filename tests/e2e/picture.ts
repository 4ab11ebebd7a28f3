// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { count, picture, topic } from "./harness.js";

topic("the page shows the run: a map that is not empty, its name, all of its scans", async (page) => {
  const whole = await picture(page);
  assert.ok(whole.length > 3000, `a picture of ${whole.length} bytes`);
  const run = await page.evaluate(() => ({ name: window.majak!.session.model.run.name, scans: window.majak!.session.model.run.scans }));
  assert.equal(await page.locator(".run-name").textContent(), run.name);
  await page.waitForFunction((scans) => window.majak!.counts()["estimates"] === scans, run.scans);
  assert.equal(await count(page, "refused"), 0);
});
