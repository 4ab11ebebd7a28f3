// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import type { Page } from "playwright-core";
import { loaded, picture, topic } from "./harness.js";

const theme = (page: Page): Promise<string | null> => page.locator(".majak").getAttribute("data-theme");

topic("night as the system wants it; a choice is remembered", async (page) => {
  assert.equal(await theme(page), "night");
  const night = await picture(page);
  await page.getByRole("button", { name: /Day colours/ }).click();
  await page.waitForFunction(() => document.querySelector(".majak")!.getAttribute("data-theme") === "day");
  assert.ok(!night.equals(await picture(page)));
  await page.reload();
  await loaded(page);
  assert.equal(await theme(page), "day");
  await page.keyboard.press("n");
  await page.waitForFunction(() => document.querySelector(".majak")!.getAttribute("data-theme") === "night");
}, { dark: true });

topic("help tells the keys", async (page) => {
  await page.keyboard.press("?");
  const help = page.getByRole("dialog");
  await help.waitFor();
  assert.ok((await help.locator("kbd").count()) > 15);
  await page.keyboard.press("Escape");
  await help.waitFor({ state: "hidden" });
});
