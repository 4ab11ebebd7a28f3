// SPDX-License-Identifier: Apache-2.0
// The tool in the hand: what clicks and strokes on the map become. Points are in m of the map.
import type { Session, Tool } from "../session.js";
import { metres } from "../text.js";
import type { Camera } from "./camera.js";
import { colour, packed } from "./gpu.js";
import type { Layers } from "./layers.js";

type Point = [number, number];

export interface Finished {
  tool: Tool;
  points: Point[];
}

export const kToolHints: Record<Tool, string> = {
  "look": "",
  "measure": "Click points to measure. Backspace takes the last one back, Esc ends.",
  "erase-box": "Drag a box over traces of people and things that are gone.",
  "erase": "Click the corners of the area to erase; Enter or a double click closes it.",
  "wall": "Click along the wall that is missing; Enter or a double click ends it.",
  "forbidden": "Click the corners of the area where no robot may go; Enter or a double click closes it.",
  "crop": "Click around what shall stay; Enter or a double click closes it. All else goes.",
  "turn": "Drag along a wall that shall run from left to right.",
  "start_pose": "Press where the robot is and drag to where it looks.",
  "kidnap": "Press where the robot shall be put and drag to where it shall look.",
};

const kStrokes: ReadonlySet<Tool> = new Set(["erase-box", "turn", "start_pose", "kidnap"]);
const kSame = 6; // px: a double click's second point

export class ToolHand {
  version = 0;
  points: Point[] = [];
  onFinished: (finished: Finished) => void = () => undefined;
  onCancel: () => void = () => undefined;
  private end: Point | undefined; ///< where the pointer is
  private stroking = false;
  private byKey = false; ///< the last point came from the keyboard
  private tool: Tool = "look";

  constructor(
    private readonly session: Session,
    private readonly camera: Camera,
    private readonly layers: Layers,
  ) {}

  strokes(): boolean {
    return kStrokes.has(this.session.tool);
  }

  /// Another tool: what was begun is forgotten.
  sync(): void {
    if (this.tool === this.session.tool) return;
    this.tool = this.session.tool;
    this.reset();
  }

  reset(): void {
    this.points = [];
    this.end = undefined;
    this.stroking = false;
    ++this.version;
  }

  hover(x: number, y: number): void {
    if (this.points.length === 0 || this.session.tool === "look") return;
    this.end = [x, y];
    ++this.version;
  }

  /// Something is begun, with the mouse.
  drawnByMouse(): boolean {
    return this.points.length > 0 && !this.byKey;
  }

  click(x: number, y: number, double: boolean, byKey = false): void {
    this.sync();
    this.byKey = byKey;
    if (double && this.points.length > 0 && this.session.tool !== "measure") return this.finish();
    const last = this.points[this.points.length - 1];
    if (last && Math.hypot(x - last[0], y - last[1]) * this.camera.scale < kSame) return;
    this.points.push([x, y]);
    ++this.version;
    this.session.touch();
  }

  stroke(phase: "begin" | "move" | "end" | "cancel", x: number, y: number): void {
    this.sync();
    if (phase === "begin") this.points = [[x, y]];
    this.end = [x, y];
    this.stroking = phase === "begin" || phase === "move";
    ++this.version;
    if (phase === "cancel") this.reset();
    if (phase === "end") this.finishStroke();
  }

  /// First key press: begins; second one: ends.
  strokeByKey(x: number, y: number): void {
    this.byKey = true;
    this.stroke(this.stroking ? "end" : "begin", x, y);
  }

  private finishStroke(): void {
    const [a] = this.points;
    const b = this.end;
    if (!a || !b) return this.reset();
    const tool = this.session.tool;
    const long = Math.hypot(b[0] - a[0], b[1] - a[1]) * this.camera.scale > kSame;
    this.reset();
    // A pose without a drag looks along x; a box or a line without a length is nothing.
    if (tool === "start_pose" || tool === "kidnap") this.onFinished({ tool, points: [a, long ? b : [a[0] + 1, a[1]]] });
    else if (long) this.onFinished({ tool, points: tool === "erase-box" ? this.box(a, b) : [a, b] });
  }

  /// The box as it is seen, also when the map is turned.
  private box(a: Point, b: Point): Point[] {
    const [ax, ay] = this.camera.toPixels(...a);
    const [bx, by] = this.camera.toPixels(...b);
    return [a, this.camera.toMetres(bx, ay), b, this.camera.toMetres(ax, by)];
  }

  /// Enter, or a double click.
  finish(): void {
    const { points } = this;
    const tool = this.session.tool;
    const least = tool === "wall" ? 2 : 3;
    if (tool === "look" || tool === "measure" || this.strokes() || points.length < least) return;
    this.reset();
    this.onFinished({ tool, points });
  }

  back(): void {
    this.points.pop();
    ++this.version;
    this.session.touch();
  }

  cancel(): void {
    if (this.points.length > 0) this.reset();
    else this.onCancel();
  }

  total(): number {
    let sum = 0;
    for (let i = 1; i < this.points.length; ++i) sum += distance(this.points[i - 1], this.points[i]);
    return sum;
  }

  labels(): { text: string; x: number; y: number }[] {
    if (this.session.tool !== "measure") return [];
    const all = this.end && this.points.length > 0 ? [...this.points, this.end] : this.points;
    const out = [];
    for (let i = 1; i < all.length; ++i) {
      const [a, b] = [all[i - 1], all[i]];
      if (a && b) out.push({ text: metres(distance(a, b), 3), x: (a[0] + b[0]) / 2, y: (a[1] + b[1]) / 2 });
    }
    const last = this.points[this.points.length - 1];
    if (last && this.points.length > 2) out.push({ text: `total ${metres(this.total(), 3)}`, x: last[0], y: last[1] });
    return out;
  }

  drawDraft(): void {
    this.sync();
    const { draft } = this.layers;
    draft.clear();
    const tool = this.session.tool;
    if (tool === "look" || this.points.length === 0) return;
    const p = this.layers.palette;
    const rgba = packed(colour(tool === "measure" ? p.measure : tool === "start_pose" || tool === "kidnap" ? p.particle : this.layers.editColour(tool === "erase-box" ? "erase" : tool)));
    const [first] = this.points;
    if (!first) return;
    if (tool === "erase-box") return this.outline(this.end ? this.box(first, this.end) : [], true, rgba);
    const all = this.end ? [...this.points, this.end] : this.points;
    this.outline(all, tool === "erase" || tool === "forbidden" || tool === "crop", rgba);
    const tick = 4 / this.camera.scale;
    for (const [x, y] of this.points) {
      draft.add(x - tick, y - tick, x + tick, y + tick, rgba);
      draft.add(x - tick, y + tick, x + tick, y - tick, rgba);
    }
    if ((tool === "start_pose" || tool === "kidnap") && this.end) this.arrow(first, this.end, rgba);
  }

  private outline(points: Point[], closed: boolean, rgba: number): void {
    for (let i = 0; i + (closed ? 0 : 1) < points.length; ++i) {
      const [a, b] = [points[i], points[(i + 1) % points.length]];
      if (a && b) this.layers.draft.add(...a, ...b, rgba);
    }
  }

  private arrow(a: Point, b: Point, rgba: number): void {
    const theta = Math.atan2(b[1] - a[1], b[0] - a[0]);
    const size = 14 / this.camera.scale;
    for (const side of [2.6, -2.6]) this.layers.draft.add(...b, b[0] + size * Math.cos(theta + side), b[1] + size * Math.sin(theta + side), rgba);
  }
}

function distance(a: Point | undefined, b: Point | undefined): number {
  return a && b ? Math.hypot(b[0] - a[0], b[1] - a[1]) : 0;
}
