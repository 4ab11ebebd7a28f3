// SPDX-License-Identifier: Apache-2.0
// PixiJS: a ParticleContainer with one particle a point.
import { Container, Particle, ParticleContainer, Texture, WebGLRenderer } from "pixi.js";
import { measure, points } from "./points.js";

const renderer = new WebGLRenderer();
await renderer.init({ width: innerWidth, height: innerHeight, background: "#ffffff", antialias: false });
document.body.append(renderer.canvas);
const container = new ParticleContainer({ texture: Texture.WHITE, dynamicProperties: { position: false, vertex: false, rotation: false, color: false, uvs: false } });
const xy = points();
for (let i = 0; i < xy.length / 2; ++i)
  container.particleChildren.push(new Particle({ texture: Texture.WHITE, x: xy[2 * i], y: xy[2 * i + 1], scaleX: 0.02, scaleY: 0.02, tint: 0x1a3380 }));
container.update();
const world = new Container();
world.addChild(container);
measure((v) => {
  world.setFromMatrix(world.localTransform.set(v.scale, 0, 0, -v.scale, innerWidth / 2 - v.x * v.scale, innerHeight / 2 + v.y * v.scale));
  renderer.render(world);
});
