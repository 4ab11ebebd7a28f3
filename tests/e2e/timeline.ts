// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { picture, row, settled, time, topic } from "./harness.js";

topic("time: step, play, pause, speed, loop, slider, all layers follow", async (page) => {
  const slider = page.getByRole("slider", { name: "Time in the run" });
  const box = await slider.boundingBox();
  assert.ok(box);
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  const half = await row(page);
  const size = await page.evaluate(() => window.majak!.session.model.estimates.size);
  assert.ok(half > 0.3 * size && half < 0.7 * size);
  const middleOfRun = await picture(page);

  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowLeft");
  assert.equal(await row(page), half + 1);
  await slider.focus();
  await page.keyboard.press("Home");
  assert.equal(await row(page), 0);
  assert.ok(!middleOfRun.equals(await picture(page)));
  await page.keyboard.press("PageDown");
  assert.ok((await row(page)) > 0);
  await page.keyboard.press("End");
  assert.equal(await row(page), size - 1);
  await settled(page);
  assert.equal(await slider.getAttribute("aria-valuenow"), await slider.getAttribute("aria-valuemax"));

  await page.keyboard.press("Home");
  await page.getByRole("combobox", { name: "Speed" }).selectOption("5");
  const begin = await time(page);
  await page.locator(".map-canvas").focus();
  await page.keyboard.press("Space");
  await page.waitForFunction((from) => window.majak!.session.time > from + 1, begin);
  await page.keyboard.press("Space");
  const stopped = await time(page);
  await settled(page);
  assert.equal(await time(page), stopped);

  // A loop at full speed comes by the beginning again.
  await page.getByRole("button", { name: "Loop" }).click();
  await page.getByRole("combobox", { name: "Speed" }).selectOption("100");
  await slider.focus();
  await page.keyboard.press("PageDown");
  await page.evaluate(() => {
    const { session } = window.majak!;
    session.goTo(session.axis.time(session.axis.length - 1));
    session.play(true);
  });
  await page.waitForFunction(() => window.majak!.session.axis.place(window.majak!.session.time) < window.majak!.session.axis.length - 1 && window.majak!.session.playing);
});

topic("pauses of the robot take no room", async (page) => {
  const found = await page.evaluate(() => {
    const { axis, model } = window.majak!.session;
    const { time: times, size } = model.estimates;
    let walked = 0;
    let gaps = 0;
    for (let i = 1; i < size; ++i) {
      const step = times[i]! - times[i - 1]!;
      if (step > 5) ++gaps;
      else walked += step;
    }
    return { walked, gaps, length: axis.length, marked: axis.gaps.length };
  });
  assert.equal(found.marked, found.gaps);
  assert.ok(Math.abs(found.walked - found.length) < 1e-3);
});
