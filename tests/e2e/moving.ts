// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { camera, drag, middle, picture, settled, topic } from "./harness.js";

topic("drag moves, wheel zooms where the pointer is, shift and drag turns, keys do all of it", async (page) => {
  const start = await camera(page);
  const first = await picture(page);
  await drag(page, await middle(page), await middle(page, 80, 40));
  const moved = await camera(page);
  assert.ok(Math.abs(moved.x - (start.x - 80 / start.scale)) < 0.05 && Math.abs(moved.y - (start.y + 40 / start.scale)) < 0.05);

  const [px, py] = await middle(page, 60, -30);
  await settled(page);
  const under = (): Promise<[number, number]> => page.evaluate(([x, y]) => {
    const box = document.querySelector(".map-canvas")!.getBoundingClientRect();
    return window.majak!.map.camera.toMetres(x - box.left, y - box.top);
  }, [px, py] as const);
  const before = await under();
  await page.mouse.move(px, py);
  await page.mouse.wheel(0, -300);
  await page.waitForFunction((scale) => window.majak!.map.camera.scale > scale * 1.3, moved.scale);
  const after = await under();
  assert.ok(Math.hypot(after[0] - before[0], after[1] - before[1]) < 1e-6, `${after.join(" ")} against ${before.join(" ")}`);

  await page.keyboard.down("Shift");
  await drag(page, await middle(page), await middle(page, 100, 0));
  await page.keyboard.up("Shift");
  const turned = (await camera(page)).rotation;
  assert.ok(Math.abs(turned) > 0.2);
  await page.getByRole("button", { name: /North up/ }).click();
  assert.equal((await camera(page)).rotation, 0);

  for (const [key, what] of [["q", "rotation"], ["e", "rotation"], ["+", "scale"], ["-", "scale"], ["Shift+ArrowLeft", "x"], ["Shift+ArrowUp", "y"]] as const) {
    const was = await camera(page);
    await page.keyboard.press(key);
    assert.notEqual((await camera(page))[what], was[what], key);
  }
  await page.keyboard.press("0");
  await page.keyboard.press("a");
  await settled(page);
  const back = await camera(page);
  assert.ok(Math.abs(back.x - start.x) < 1e-6 && Math.abs(back.scale / start.scale - 1) < 1e-6);
  assert.ok((await picture(page)).equals(first), "all again, but the picture is another one");
});

topic("the map follows the robot until it is moved by hand", async (page) => {
  await page.keyboard.press("f");
  for (const share of [0.3, 0.7]) {
    const pose = await page.evaluate((part) => {
      const { session } = window.majak!;
      session.goToRow(Math.floor(session.model.estimates.size * part));
      return session.model.estimates.pose(session.row());
    }, share);
    await settled(page);
    const { x, y } = await camera(page);
    assert.ok(Math.hypot(x - pose[0], y - pose[1]) < 1e-9);
  }
  await drag(page, await middle(page), await middle(page, 50, 0));
  assert.equal(await page.evaluate(() => window.majak!.session.follow), false);
});
