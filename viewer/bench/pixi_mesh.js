// SPDX-License-Identifier: Apache-2.0
// PixiJS: one Mesh of points with a small shader.
import { Buffer, BufferUsage, Container, Geometry, Mesh, Shader, WebGLRenderer } from "pixi.js";
import { measure, points } from "./points.js";

const renderer = new WebGLRenderer();
await renderer.init({ width: innerWidth, height: innerHeight, background: "#ffffff", antialias: false });
document.body.append(renderer.canvas);
const geometry = new Geometry({
  attributes: { aPosition: { buffer: new Buffer({ data: points(), usage: BufferUsage.VERTEX }), format: "float32x2" } },
  topology: "point-list",
});
const shader = Shader.from({
  gl: {
    vertex: `in vec2 aPosition; uniform mat3 uProjectionMatrix; uniform mat3 uWorldTransformMatrix; uniform mat3 uTransformMatrix;
      void main() { gl_Position = vec4((uProjectionMatrix * uWorldTransformMatrix * uTransformMatrix * vec3(aPosition, 1.0)).xy, 0.0, 1.0); gl_PointSize = 2.0; }`,
    fragment: `void main() { gl_FragColor = vec4(0.1, 0.2, 0.5, 1.0); }`,
  },
  resources: {},
});
const world = new Container();
world.addChild(new Mesh({ geometry, shader }));
measure((v) => {
  world.setFromMatrix(world.localTransform.set(v.scale, 0, 0, -v.scale, innerWidth / 2 - v.x * v.scale, innerHeight / 2 + v.y * v.scale));
  renderer.render(world);
});
