// SPDX-License-Identifier: Apache-2.0
// The few things that the map is drawn of, on PixiJS: thick lines, round dots, triangles and pictures, all in metres
// of the map. Two triangles a line and one vertex a dot, without instances, is what also a computer without graphics
// card draws fast enough.
import { Buffer, BufferImageSource, BufferUsage, Geometry, Shader, State, UniformGroup, type WebGLRenderer } from "pixi.js";
import type { Camera } from "./camera.js";

export type Colour = readonly [r: number, g: number, b: number, a: number]; ///< 0 ... 1

/// "#rrggbb", with an opacity.
export function colour(hex: string, alpha = 1): Colour {
  const value = parseInt(hex.slice(1), 16);
  return [(value >> 16) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255, alpha];
}

export function packed([r, g, b, a]: Colour): number {
  const byte = (v: number): number => Math.round(255 * Math.min(1, Math.max(0, v)));
  return (byte(r) | (byte(g) << 8) | (byte(b) << 16) | (byte(a) << 24)) >>> 0;
}

const cameraGroup = (): UniformGroup =>
  new UniformGroup({
    uMatrix: { value: new Float32Array(9), type: "mat3x3<f32>" },
    uHalf: { value: new Float32Array(2), type: "vec2<f32>" }, // half the view in pixels of the screen
  });

/// Where all shaders learn the view from.
export class Stage {
  readonly camera = cameraGroup();
  readonly state = State.for2d();

  constructor(readonly renderer: WebGLRenderer) {}

  look(camera: Camera, ratio: number): void {
    const uniforms = this.camera.uniforms as { uMatrix: Float32Array; uHalf: Float32Array };
    uniforms.uMatrix.set(camera.clipMatrix());
    uniforms.uHalf.set([(camera.width * ratio) / 2, (camera.height * ratio) / 2]);
    this.camera.update();
  }

  draw(geometry: Geometry, shader: Shader, topology: "triangle-list" | "point-list", size: number): void {
    this.renderer.encoder.draw({ geometry, shader, state: this.state, topology, size });
  }
}

const kHeadOfVertex = `precision highp float;
uniform mat3 uMatrix;
uniform vec2 uHalf;
`;

/// Vertices that grow geometrically, in one buffer of words of 32 bits.
class Vertices {
  floats = new Float32Array(0);
  words = new Uint32Array(0);
  used = 0; ///< words
  private readonly buffer = new Buffer({ data: new Float32Array(64), usage: BufferUsage.VERTEX | BufferUsage.COPY_DST, shrinkToFit: false });
  private dirty = false;

  room(words: number): void {
    this.dirty = true;
    if (this.used + words <= this.floats.length) return;
    const floats = new Float32Array(Math.max(2 * this.floats.length, this.used + words, 256));
    floats.set(this.floats);
    this.floats = floats;
    this.words = new Uint32Array(floats.buffer);
  }

  clear(): void {
    this.used = 0;
    this.dirty = true;
  }

  get gpu(): Buffer {
    return this.buffer;
  }

  upload(): void {
    if (!this.dirty) return;
    this.dirty = false;
    if (this.used > 0) this.buffer.setDataWithSize(this.floats, this.used, true);
  }
}

const kLineWords = 7; // from x y, to x y, time, corner, colour
const kNever = -1e30;

export interface LineStyle {
  width: number; ///< px
  dash?: number; ///< px of a period; 0: none
}

export class Lines {
  private readonly vertices = new Vertices();
  private readonly indices = new Buffer({ data: new Uint32Array(6), usage: BufferUsage.INDEX | BufferUsage.COPY_DST, shrinkToFit: false });
  private indexRoom = 0;
  private readonly geometry: Geometry;
  private readonly style = new UniformGroup({
    uWidth: { value: 1, type: "f32" },
    uDash: { value: 0, type: "f32" },
    uNow: { value: 1e30, type: "f32" },
    uFade: { value: 1, type: "f32" },
  });
  private readonly shader: Shader;

  constructor(private readonly stage: Stage) {
    const attribute = (format: "float32x2" | "float32" | "unorm8x4", offset: number) => ({ buffer: this.vertices.gpu, format, stride: 4 * kLineWords, offset });
    this.geometry = new Geometry({
      attributes: { aFrom: attribute("float32x2", 0), aTo: attribute("float32x2", 8), aTime: attribute("float32", 16), aCorner: attribute("unorm8x4", 20), aColour: attribute("unorm8x4", 24) },
      indexBuffer: this.indices,
      topology: "triangle-list",
    });
    this.shader = Shader.from({
      gl: {
        vertex: `${kHeadOfVertex}
in vec2 aFrom; in vec2 aTo; in float aTime; in vec4 aCorner; in vec4 aColour;
uniform float uWidth; uniform float uNow;
out vec4 vColour; out float vSide; out float vAlong;
void main() {
  vec2 a = (uMatrix * vec3(aFrom, 1.0)).xy * uHalf;
  vec2 b = (uMatrix * vec3(aTo, 1.0)).xy * uHalf;
  vec2 along = b - a;
  float size = length(along);
  along = size > 0.0 ? along / size : vec2(1.0, 0.0);
  float half_ = 0.5 * uWidth + 0.5;
  vSide = (2.0 * aCorner.y - 1.0) * half_;
  vAlong = mix(-0.5, size + 0.5, aCorner.x);
  vec2 p = mix(a, b, aCorner.x) + vec2(-along.y, along.x) * vSide + along * (aCorner.x - 0.5) * min(uWidth, 3.0) * 0.3;
  vColour = aColour;
  gl_Position = aTime > uNow ? vec4(2.0, 2.0, 2.0, 1.0) : vec4(p / uHalf, 0.0, 1.0);
}`,
        fragment: `precision highp float;
in vec4 vColour; in float vSide; in float vAlong;
uniform float uWidth; uniform float uDash; uniform float uFade;
out vec4 finalColor;
void main() {
  float alpha = vColour.a * uFade * clamp(0.5 * uWidth + 0.5 - abs(vSide), 0.0, 1.0);
  if (uDash > 0.0 && fract(vAlong / uDash) > 0.55) alpha = 0.0;
  finalColor = vec4(vColour.rgb * alpha, alpha);
}`,
      },
      resources: { camera: stage.camera, style: this.style },
    });
  }

  get count(): number {
    return this.vertices.used / (4 * kLineWords);
  }

  clear(): void {
    this.vertices.clear();
  }

  /// Times as numbers small enough for 32 bits: seconds since the run began.
  add(x1: number, y1: number, x2: number, y2: number, rgba: number, time = kNever): void {
    const v = this.vertices;
    v.room(4 * kLineWords);
    for (let corner = 0; corner < 4; ++corner) {
      const at = v.used;
      v.floats[at] = x1;
      v.floats[at + 1] = y1;
      v.floats[at + 2] = x2;
      v.floats[at + 3] = y2;
      v.floats[at + 4] = time;
      v.words[at + 5] = (corner & 1 ? 0xff : 0) | (corner & 2 ? 0xff00 : 0);
      v.words[at + 6] = rgba;
      v.used = at + kLineWords;
    }
  }

  draw(style: LineStyle, now = 1e30, fade = 1): void {
    const count = this.count;
    if (count === 0) return;
    this.vertices.upload();
    this.index(count);
    const u = this.style.uniforms as { uWidth: number; uDash: number; uNow: number; uFade: number };
    u.uWidth = style.width * this.stage.renderer.resolution;
    u.uDash = (style.dash ?? 0) * this.stage.renderer.resolution;
    u.uNow = now;
    u.uFade = fade;
    this.style.update();
    this.stage.draw(this.geometry, this.shader, "triangle-list", 6 * count);
  }

  private index(lines: number): void {
    if (lines <= this.indexRoom) return;
    this.indexRoom = Math.max(lines, 2 * this.indexRoom, 64);
    const data = new Uint32Array(6 * this.indexRoom);
    for (let i = 0; i < this.indexRoom; ++i) data.set([4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 2, 4 * i + 1, 4 * i + 3], 6 * i);
    this.indices.setDataWithSize(data, data.length, true);
  }
}

const kDotWords = 3; // x y, colour

export class Dots {
  private readonly vertices = new Vertices();
  private readonly geometry: Geometry;
  private readonly style = new UniformGroup({ uSize: { value: 1, type: "f32" }, uFade: { value: 1, type: "f32" } });
  private readonly shader: Shader;

  constructor(private readonly stage: Stage) {
    const attribute = (format: "float32x2" | "unorm8x4", offset: number) => ({ buffer: this.vertices.gpu, format, stride: 4 * kDotWords, offset });
    this.geometry = new Geometry({ attributes: { aPosition: attribute("float32x2", 0), aColour: attribute("unorm8x4", 8) }, topology: "point-list" });
    this.shader = Shader.from({
      gl: {
        vertex: `${kHeadOfVertex}
in vec2 aPosition; in vec4 aColour;
uniform float uSize;
out vec4 vColour;
void main() {
  vColour = aColour;
  gl_Position = vec4((uMatrix * vec3(aPosition, 1.0)).xy, 0.0, 1.0);
  gl_PointSize = uSize + 1.0;
}`,
        fragment: `precision highp float;
in vec4 vColour;
uniform float uSize; uniform float uFade;
out vec4 finalColor;
void main() {
  float from = length(gl_PointCoord - 0.5) * (uSize + 1.0);
  float alpha = vColour.a * uFade * clamp(0.5 * uSize + 0.5 - from, 0.0, 1.0);
  finalColor = vec4(vColour.rgb * alpha, alpha);
}`,
      },
      resources: { camera: stage.camera, style: this.style },
    });
  }

  get count(): number {
    return this.vertices.used / kDotWords;
  }

  clear(): void {
    this.vertices.clear();
  }

  add(x: number, y: number, rgba: number): void {
    const v = this.vertices;
    v.room(kDotWords);
    const at = v.used;
    v.floats[at] = x;
    v.floats[at + 1] = y;
    v.words[at + 2] = rgba;
    v.used = at + kDotWords;
  }

  draw(size: number, fade = 1): void {
    if (this.count === 0) return;
    this.vertices.upload();
    const u = this.style.uniforms as { uSize: number; uFade: number };
    u.uSize = size * this.stage.renderer.resolution;
    u.uFade = fade;
    this.style.update();
    this.stage.draw(this.geometry, this.shader, "point-list", this.count);
  }
}

export class Triangles {
  private readonly vertices = new Vertices();
  private readonly geometry: Geometry;
  private readonly shader: Shader;

  constructor(private readonly stage: Stage) {
    const attribute = (format: "float32x2" | "unorm8x4", offset: number) => ({ buffer: this.vertices.gpu, format, stride: 4 * kDotWords, offset });
    this.geometry = new Geometry({ attributes: { aPosition: attribute("float32x2", 0), aColour: attribute("unorm8x4", 8) }, topology: "triangle-list" });
    this.shader = Shader.from({
      gl: {
        vertex: `${kHeadOfVertex}
in vec2 aPosition; in vec4 aColour;
out vec4 vColour;
void main() {
  vColour = aColour;
  gl_Position = vec4((uMatrix * vec3(aPosition, 1.0)).xy + 0.0 * uHalf, 0.0, 1.0);
}`,
        fragment: `precision highp float;
in vec4 vColour;
out vec4 finalColor;
void main() { finalColor = vec4(vColour.rgb * vColour.a, vColour.a); }`,
      },
      resources: { camera: stage.camera },
    });
  }

  clear(): void {
    this.vertices.clear();
  }

  corner(x: number, y: number, rgba: number): void {
    const v = this.vertices;
    v.room(kDotWords);
    v.floats[v.used] = x;
    v.floats[v.used + 1] = y;
    v.words[v.used + 2] = rgba;
    v.used += kDotWords;
  }

  draw(): void {
    if (this.vertices.used === 0) return;
    this.vertices.upload();
    this.stage.draw(this.geometry, this.shader, "triangle-list", this.vertices.used / kDotWords);
  }
}

/// A rectangle of cells of two bytes each, drawn in two colours: the first byte mixes them, the second is the opacity.
export class Picture {
  private readonly geometry: Geometry;
  private readonly shader: Shader;
  private readonly source: BufferImageSource;
  private readonly style = new UniformGroup({ uLow: { value: new Float32Array(4), type: "vec4<f32>" }, uHigh: { value: new Float32Array(4), type: "vec4<f32>" } });

  /// Corners in m: lower left, lower right, upper left, upper right; row 0 of the cells is the lowest; `width` even.
  /// `manyScales`: it is also looked at from so far that many cells are one pixel.
  constructor(private readonly stage: Stage, cells: Uint8Array, width: number, height: number, corners: readonly number[], manyScales: boolean) {
    this.source = new BufferImageSource({ resource: cells, width, height, format: "rg8unorm", autoGenerateMipmaps: manyScales, magFilter: "nearest", minFilter: "linear", mipmapFilter: "nearest", alphaMode: "no-premultiply-alpha" });
    this.geometry = new Geometry({
      attributes: { aPosition: { buffer: new Buffer({ data: new Float32Array(corners), usage: BufferUsage.VERTEX }), format: "float32x2" }, aUv: { buffer: new Buffer({ data: new Float32Array([0, 0, 1, 0, 0, 1, 1, 1]), usage: BufferUsage.VERTEX }), format: "float32x2" } },
      indexBuffer: new Uint32Array([0, 1, 2, 2, 1, 3]),
      topology: "triangle-list",
    });
    this.shader = Shader.from({
      gl: {
        vertex: `${kHeadOfVertex}
in vec2 aPosition; in vec2 aUv;
out vec2 vUv;
void main() {
  vUv = aUv;
  gl_Position = vec4((uMatrix * vec3(aPosition, 1.0)).xy + 0.0 * uHalf, 0.0, 1.0);
}`,
        fragment: `precision highp float;
in vec2 vUv;
uniform sampler2D uTexture; uniform vec4 uLow; uniform vec4 uHigh;
out vec4 finalColor;
void main() {
  vec2 cell = texture(uTexture, vUv).rg;
  // Means over cells are of both bytes; the mix is that of the known ones only.
  vec4 mixed = mix(uLow, uHigh, clamp(cell.r / max(cell.g, 0.004), 0.0, 1.0));
  float alpha = mixed.a * cell.g;
  finalColor = vec4(mixed.rgb * alpha, alpha);
}`,
      },
      resources: { camera: stage.camera, style: this.style, uTexture: this.source, uSampler: this.source.style },
    });
  }

  draw(low: Colour, high: Colour): void {
    const u = this.style.uniforms as { uLow: Float32Array; uHigh: Float32Array };
    u.uLow.set(low);
    u.uHigh.set(high);
    this.style.update();
    this.stage.draw(this.geometry, this.shader, "triangle-list", 6);
  }

  destroy(): void {
    this.geometry.destroy(true);
    this.shader.destroy();
    this.source.destroy();
  }
}
