// SPDX-License-Identifier: Apache-2.0
// PixiJS: rectangles in Graphics (10 000 in one, or building the paths fails).
import { Container, Graphics, WebGLRenderer } from "pixi.js";
import { measure, points } from "./points.js";

const renderer = new WebGLRenderer();
await renderer.init({ width: innerWidth, height: innerHeight, background: "#ffffff", antialias: false });
document.body.append(renderer.canvas);
const xy = points();
const world = new Container();
for (let i = 0; i < xy.length / 2; i += 10000) {
  const graphics = new Graphics();
  for (let k = i; k < Math.min(i + 10000, xy.length / 2); ++k) graphics.rect(xy[2 * k], xy[2 * k + 1], 0.02, 0.02);
  world.addChild(graphics.fill(0x1a3380));
}
measure((v) => {
  world.setFromMatrix(world.localTransform.set(v.scale, 0, 0, -v.scale, innerWidth / 2 - v.x * v.scale, innerHeight / 2 + v.y * v.scale));
  renderer.render(world);
});
