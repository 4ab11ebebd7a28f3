// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { drag, lastCommand, middle, openTab, ownTopic } from "./harness.js";

ownTopic("localization: start, start pose and kidnap by press and drag, hypotheses", async (page, server) => {
  await openTab(page, "Localize");
  await page.getByRole("combobox", { name: "Method" }).selectOption("markov");
  await page.getByRole("button", { name: "Start a simulated robot" }).click();
  assert.equal((await lastCommand(page)).do, "localize");
  assert.deepEqual({ ...server.received.at(-1), id: 0 }, { id: 0, do: "localize", method: "markov" });
  for (const [name, what] of [["Set start pose", "start_pose"], ["Kidnap robot", "kidnap"]] as const) {
    await page.getByRole("button", { name }).click();
    await drag(page, await middle(page, 20, 10), await middle(page, 20, -60));
    assert.deepEqual(await lastCommand(page), { do: what, fate: "done", error: "" });
    const { pose } = server.received.at(-1) as { pose: [number, number, number] };
    const at = await page.evaluate(() => window.majak!.map.camera.toMetres(window.majak!.map.camera.width / 2 + 20, window.majak!.map.camera.height / 2 + 10));
    assert.ok(Math.hypot(pose[0] - at[0], pose[1] - at[1]) < 0.05 && Math.abs(pose[2] - Math.PI / 2) < 0.05, pose.join(" "));
    assert.equal(await page.evaluate(() => window.majak!.session.tool), "look");
  }
  const listed = await page.locator(".page:visible ul li").allTextContents();
  assert.ok(listed.length === 2 && listed[0]?.startsWith("70 %"), listed.join("; "));
});
