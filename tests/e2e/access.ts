// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { topic, openTab } from "./harness.js";
import { createRequire } from "node:module";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

interface Finding {
  id: string;
  impact: string;
  nodes: { html: string; failureSummary: string }[];
}

topic("axe finds nothing serious on any tab, by day and by night", async (page) => {
  await page.evaluate(axe);
  for (const night of [false, true]) {
    await page.evaluate((on) => {
      window.majak!.session.night = on;
      window.majak!.session.touch();
    }, night);
    for (const tab of night ? ["Closures", "Edit"] : ["Pose", "Closures", "Edit", "Localize", "Run"]) {
      await openTab(page, tab);
      if (tab === "Closures") await page.locator("tbody tr").first().click();
      await page.waitForTimeout(200); // colours change softly
      const found = await page.evaluate(async () => {
        const { axe } = window as unknown as { axe: { run(): Promise<{ violations: Finding[] }> } };
        return (await axe.run()).violations;
      });
      const serious = found.filter((one) => one.impact === "serious" || one.impact === "critical").map((one) => `${tab}: ${one.id}: ${one.nodes.map((node) => `${node.html} ${node.failureSummary}`).join(" | ")}`);
      assert.deepEqual(serious, []);
    }
  }
});

topic("the keyboard reaches every control, and the focus is seen", async (page) => {
  await page.evaluate(() => (document.activeElement as HTMLElement | null)?.blur());
  const seen = new Set<string>();
  for (let i = 0; i < 80; ++i) {
    await page.keyboard.press("Tab");
    const at = await page.evaluate(() => {
      const one = document.activeElement;
      if (!(one instanceof HTMLElement) || one === document.body) return undefined;
      const shown = one.matches("input[type=checkbox]") ? one.closest("label")! : one;
      return { name: one.getAttribute("aria-label") ?? one.getAttribute("data-layer") ?? one.textContent ?? "", outline: getComputedStyle(shown).outlineStyle };
    });
    if (!at) continue;
    assert.notEqual(at.outline, "none", at.name);
    seen.add(at.name);
  }
  for (const name of ["grid", "trail", "Zoom in (+)", "Measure (M)", "Play (space)", "Time in the run", "Pose", "Help and keys (?)"]) assert.ok(seen.has(name), `${name} is not reached; ${[...seen].join(", ")}`);
});
