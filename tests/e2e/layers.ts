// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { picture, topic } from "./harness.js";

topic("each layer's eye changes the picture, and back", async (page) => {
  // In the middle of the run, where most layers have something to show.
  await page.evaluate(() => {
    const { session, map } = window.majak!;
    session.goToRow(Math.floor(session.model.estimates.size * 0.6));
    map.camera.zoom(0.8);
  });
  const before = await picture(page);
  const eyes = page.locator(".layer:not([hidden]) input");
  for (let i = 0; i < (await eyes.count()); ++i) {
    const eye = eyes.nth(i);
    const name = (await eye.getAttribute("data-layer")) ?? "";
    if (name === "edits") continue; // the topic of edits looks at them
    const was = await eye.isChecked();
    await eye.focus();
    await page.keyboard.press("Space");
    assert.equal(await eye.isChecked(), !was);
    assert.ok(!before.equals(await picture(page)), `${name}: no pixel changed`);
    await page.keyboard.press("Space");
  }
  assert.ok(before.equals(await picture(page)), "all as it was, but the picture is another one");
});
