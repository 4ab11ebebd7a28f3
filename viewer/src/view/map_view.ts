// SPDX-License-Identifier: Apache-2.0
// The map: canvas, camera, layers, the tool in the hand, and the few words that lie over it.
import { RenderContainer, WebGLRenderer } from "pixi.js";
import "pixi.js/unsafe-eval"; // PixiJS writes no code at run time: pages may forbid it
import { element, setText } from "../dom.js";
import type { Session } from "../session.js";
import type { Grid } from "../stream/records.js";
import { fixed } from "../text.js";
import { Camera, roundLength } from "./camera.js";
import { watch } from "./gestures.js";
import { Stage, colour } from "./gpu.js";
import { Layers } from "./layers.js";
import { ToolHand } from "./tools.js";

const kNearPose = 14; // px
const kNearLine = 8; // px
const kFlight = 350; // ms
const kFitEvery = 500; // ms
const kAroundRobot: [number, number, number, number] = [-10, -10, 10, 10]; // m, when there are only scans
const kWall = 60; // of 100

export class MapView {
  readonly element = element("div", { class: "map" });
  readonly camera = new Camera();
  readonly hand: ToolHand;
  frames = 0;
  onPick: () => void = () => undefined; ///< a pose was asked for
  onPickClosure: () => void = () => undefined;
  private readonly words = element("div", { class: "map-words", "aria-hidden": "true" });
  private readonly scaleBar = element("div", { class: "scale-bar" });
  private readonly scaleText = element("span");
  private readonly pointer = element("div", { class: "pointer-place" });
  private readonly cross = element("div", { class: "cross", "aria-hidden": "true" });
  private flight: { from: [number, number, number]; to: [number, number, number]; begin: number } | undefined;
  private drawn = "";
  private auto = true; ///< nobody has moved the map: it shows all there is
  private fittedTo = "";
  private fittedAt = -Infinity;
  private ratio = 1;

  static async create(session: Session): Promise<MapView> {
    const renderer = new WebGLRenderer();
    const canvas = element("canvas", { class: "map-canvas", tabindex: "0", role: "application", "aria-label": "Map. Plus and minus zoom, shift and arrows move, Q and E turn, Enter uses the tool in the middle." });
    await renderer.init({ canvas, width: 64, height: 64, antialias: false, backgroundAlpha: 1, resolution: 1, gcActive: false });
    return new MapView(session, renderer, canvas);
  }

  private readonly stage: Stage;
  readonly layers: Layers;
  private readonly root: RenderContainer;

  private constructor(private readonly session: Session, private readonly renderer: WebGLRenderer, private readonly canvas: HTMLCanvasElement) {
    this.stage = new Stage(renderer);
    this.layers = new Layers(this.stage, session);
    this.root = new RenderContainer(() => this.paint());
    this.hand = new ToolHand(session, this.camera, this.layers);
    this.scaleBar.append(this.scaleText);
    this.element.append(canvas, this.words, this.cross, this.scaleBar, this.pointer);
    watch(canvas, this.camera, {
      strokes: () => this.hand.strokes(),
      click: (px, py, double) => this.click(px, py, double),
      hover: (px, py) => this.hover(px, py),
      stroke: (phase, px, py) => {
        this.hover(px, py);
        this.hand.stroke(phase, ...this.camera.toMetres(px, py));
      },
      moved: () => this.moved(),
    });
    canvas.addEventListener("pointerleave", () => setText(this.pointer, ""));
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  /// A person moved the map.
  moved(): void {
    this.auto = false;
    this.flight = undefined;
    this.session.follow = false;
    this.session.touch();
  }

  /// Turns or zooms about the middle, which following the robot allows.
  zoom(factor: number): void {
    this.auto = false;
    this.camera.zoom(factor);
    this.session.touch();
  }
  rotate(angle: number): void {
    this.camera.rotate(angle);
    this.session.touch();
  }

  private more = false;
  private paint(): void {
    this.stage.look(this.camera, this.ratio);
    this.more = this.layers.draw(this.camera);
  }

  /// Draws if anything changed since the last frame; whether it did.
  frame(): boolean {
    const { session } = this;
    this.fitByItself();
    this.fly();
    if (session.follow) this.centreOnRobot();
    this.hand.drawDraft();
    const { x, y, scale, rotation, width, height } = this.camera;
    const now = [x, y, scale, rotation, width, height, this.ratio, session.version, session.time, session.night, this.hand.version, ...Object.values(session.model.versions)].join(" ");
    if (now === this.drawn && !this.more) return false;
    this.drawn = now;
    this.renderer.render({ container: this.root, clearColor: colour(this.layers.palette.background) as unknown as number[] });
    this.write();
    ++this.frames;
    return true;
  }

  /// Nothing is left to paint.
  finished(): boolean {
    return !this.more;
  }

  private write(): void {
    const { camera } = this;
    const step = roundLength(camera.scale, 56);
    this.scaleBar.style.width = `${step * camera.scale}px`;
    setText(this.scaleText, step < 1 ? `${fixed(100 * step, 0)} cm` : `${fixed(step, 0)} m`);
    this.words.replaceChildren(...this.labels().map(({ text, x, y, kind }) => {
      const [px, py] = camera.toPixels(x, y);
      const label = element("span", { class: kind }, text);
      label.style.transform = `translate(${Math.round(px)}px, ${Math.round(py)}px)`;
      return label;
    }));
  }

  private labels(): { text: string; x: number; y: number; kind: string }[] {
    const out = this.hand.labels().map((label) => ({ ...label, kind: "measure" }));
    if (this.layers.on.get("landmarks"))
      for (const { name, x, y } of this.session.model.landmarks) {
        const [px, py] = this.camera.toPixels(x, y);
        if (px < 0 || py < 0 || px > this.camera.width || py > this.camera.height) continue;
        if (out.length > 80) break;
        out.push({ text: name, x, y, kind: "landmark" });
      }
    return out;
  }

  resize(): void {
    const box = this.element.getBoundingClientRect();
    if (box.width < 1 || box.height < 1) return;
    this.ratio = Math.min(2, window.devicePixelRatio || 1);
    this.camera.width = box.width;
    this.camera.height = box.height;
    this.renderer.resize(box.width, box.height, this.ratio);
    this.canvas.style.width = `${box.width}px`;
    this.canvas.style.height = `${box.height}px`;
  }

  /// Shows all there is; false: nothing is there yet.
  fit(): boolean {
    const box = this.contents();
    if (!box || this.camera.width < 2) return false;
    this.auto = true;
    this.flight = undefined;
    this.camera.fit(...box, this.covered("left"), this.covered("right"), 34);
    this.session.touch();
    return true;
  }

  /// Pixels that the cards at that side of the map hide, if enough is left between them.
  private covered(side: "left" | "right"): number {
    const card = this.element.querySelector(side === "left" ? ".layers" : ".map-tools");
    const width = card instanceof HTMLElement && !(card instanceof HTMLDetailsElement && !card.open) ? card.offsetWidth : 0;
    return this.camera.width > 480 ? width + 28 : 28;
  }

  private fitByItself(): void {
    const { versions, estimates, map, newestScan } = this.session.model;
    const what = `${versions.map} ${map ? 0 : estimates.size} ${newestScan >= 0} ${this.camera.width} ${this.camera.height}`;
    if (!this.auto || what === this.fittedTo || performance.now() - this.fittedAt < kFitEvery) return;
    if (!this.fit()) return;
    this.fittedTo = what;
    this.fittedAt = performance.now();
  }

  private contents(): [number, number, number, number] | undefined {
    const { map, estimates } = this.session.model;
    if (map) {
      const walls = wallsOf(map);
      if (walls) return walls;
    }
    if (estimates.size === 0) return this.session.model.newestScan >= 0 ? kAroundRobot : undefined;
    let box: [number, number, number, number] = [Infinity, Infinity, -Infinity, -Infinity];
    for (let row = 0; row < estimates.size; ++row) {
      const [x, y] = estimates.pose(row);
      box = [Math.min(box[0], x), Math.min(box[1], y), Math.max(box[2], x), Math.max(box[3], y)];
    }
    return [box[0] - 8, box[1] - 8, box[2] + 8, box[3] + 8];
  }

  /// Goes there gently, zooming in if the view is far away.
  flyTo(x: number, y: number, scale = Math.max(this.camera.scale, 40)): void {
    this.session.follow = false;
    this.auto = false;
    const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.flight = { from: [this.camera.x, this.camera.y, this.camera.scale], to: [x, y, scale], begin: performance.now() - (still ? kFlight : 0) };
  }

  private fly(): void {
    if (!this.flight) return;
    const { from, to, begin } = this.flight;
    const t = Math.min(1, (performance.now() - begin) / kFlight);
    const soft = t * t * (3 - 2 * t);
    this.camera.x = from[0] + (to[0] - from[0]) * soft;
    this.camera.y = from[1] + (to[1] - from[1]) * soft;
    this.camera.scale = from[2] * (to[2] / from[2]) ** soft;
    if (t === 1) this.flight = undefined;
  }

  private centreOnRobot(): void {
    const row = this.session.row();
    if (row < 0) return;
    [this.camera.x, this.camera.y] = this.session.model.estimates.pose(row);
  }

  private hover(px: number, py: number): void {
    const [x, y] = this.camera.toMetres(px, py);
    this.hand.hover(x, y);
    setText(this.pointer, `x ${fixed(x, 2)}  y ${fixed(y, 2)} m`);
  }

  private click(px: number, py: number, double: boolean): void {
    const [x, y] = this.camera.toMetres(px, py);
    if (this.session.tool !== "look") this.hand.click(x, y, double);
    else this.pick(px, py);
  }

  /// The tool in the middle of the view, by the keyboard.
  clickMiddle(): void {
    if (this.hand.strokes()) this.hand.strokeByKey(this.camera.x, this.camera.y);
    else if (this.session.tool !== "look") this.hand.click(this.camera.x, this.camera.y, false, true);
    else this.pick(this.camera.width / 2, this.camera.height / 2);
  }

  private pick(px: number, py: number): void {
    const { estimates } = this.session.model;
    let best = -1;
    let nearest = kNearPose;
    for (let row = 0; row < estimates.size; ++row) {
      const [x, y] = this.camera.toPixels(...xy(estimates.pose(row)));
      const distance = Math.hypot(x - px, y - py);
      if (distance < nearest) {
        nearest = distance;
        best = row;
      }
    }
    this.session.selected = best;
    if (best >= 0) {
      this.session.goToRow(best);
      this.onPick();
    } else if (this.layers.on.get("closures")) this.pickClosure(px, py);
    this.session.touch();
  }

  private pickClosure(px: number, py: number): void {
    const { estimates, closures } = this.session.model;
    let nearest = kNearLine;
    closures.forEach(({ from, to }, i) => {
      const rows = [estimates.row(from), estimates.row(to)] as const;
      if (rows[0] < 0 || rows[1] < 0) return;
      const distance = toPiece([px, py], this.camera.toPixels(...xy(estimates.pose(rows[0]))), this.camera.toPixels(...xy(estimates.pose(rows[1]))));
      if (distance >= nearest) return;
      nearest = distance;
      this.session.closure = i;
    });
    if (nearest < kNearLine) this.onPickClosure();
  }
}

/// From a point to the piece of a line between two others.
function toPiece(p: readonly [number, number], a: readonly [number, number], b: readonly [number, number]): number {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  const t = Math.min(1, Math.max(0, ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / Math.max(dx * dx + dy * dy, 1e-12)));
  return Math.hypot(p[0] - a[0] - t * dx, p[1] - a[1] - t * dy);
}

const xy = (pose: readonly [number, number, number]): [number, number] => [pose[0], pose[1]];

/// Box in m around nearly all walls, for maps that are not turned: rays through a window do not count.
function wallsOf(map: Grid): [number, number, number, number] | undefined {
  const columns = new Uint32Array(map.width);
  const rows = new Uint32Array(map.height);
  let all = 0;
  for (let row = 0; row < map.height; ++row)
    for (let column = 0; column < map.width; ++column) {
      if ((map.data[row * map.width + column] ?? -1) < kWall) continue;
      columns[column] = (columns[column] ?? 0) + 1;
      rows[row] = (rows[row] ?? 0) + 1;
      ++all;
    }
  if (all === 0) return undefined;
  const [left, right] = most(columns, all);
  const [low, high] = most(rows, all);
  const [x, y] = map.origin;
  const r = map.resolution;
  return [x + r * left, y + r * low, x + r * (right + 1), y + r * (high + 1)];
}

/// First and last place with all but a two-thousandth on either side between them.
function most(counts: Uint32Array, all: number): [number, number] {
  const least = all / 2000;
  const from = (places: number[]): number => {
    let sum = 0;
    return places.find((place) => (sum += counts[place] ?? 0) > least) ?? 0;
  };
  const places = Array.from(counts.keys());
  return [from(places), from([...places].reverse())];
}
