// SPDX-License-Identifier: Apache-2.0
// Where the run came back to a place it knew: sortable, with both scans before and after, and a switch.
import { button, element, setAttribute, setText } from "../dom.js";
import type { Session } from "../session.js";
import { three } from "../stream/columns.js";
import { type Pose, compose, inverse } from "../stream/pose.js";
import type { Closure } from "../stream/records.js";
import { count, degrees, fixed, metres } from "../text.js";
import type { MapView } from "../view/map_view.js";

type Column = "from" | "to" | "score" | "effect_m" | "chi2";

const kColumns: readonly { id: Column; label: string; hint: string; text(closure: Closure): string }[] = [
  { id: "from", label: "from", hint: "number of the earlier scan", text: (c) => count(c.from) },
  { id: "to", label: "to", hint: "number of the later scan", text: (c) => count(c.to) },
  { id: "score", label: "score", hint: "share of the returns that meet the other scan's", text: (c) => fixed(c.score, 2) },
  { id: "effect_m", label: "effect", hint: "how far it moved the later scan", text: (c) => metres(c.effect_m, 2) },
  { id: "chi2", label: "\u03c7\u00b2", hint: "how much it disagrees with the rest", text: (c) => fixed(c.chi2, 1) },
];

const kMostRows = 400; // in the table; sort to see others

export class ClosuresPanel {
  readonly element = element("div", { class: "page" });
  private readonly summary = element("p", { class: "note" });
  private readonly body = element("tbody");
  private readonly heads = new Map<Column, HTMLElement>();
  private readonly detail = element("div", { class: "page-part" });
  private readonly before = element("canvas", { width: "300", height: "300", role: "img", "aria-label": "Both scans as the front end had them" });
  private readonly after = element("canvas", { width: "300", height: "300", role: "img", "aria-label": "Both scans where they lie now" });
  private readonly words = element("p", { class: "note" });
  private readonly toggle = button("Switch off", () => this.flip(), { class: "primary" });
  private readonly undo = button("Undo", () => this.session.commands.issue("Undo", { do: "undo" }));
  private sort: { by: Column; down: boolean } = { by: "effect_m", down: true };
  private rows = new Map<string, HTMLElement>();
  private drawn = "";
  private drawnDetail = "";

  constructor(private readonly session: Session, private readonly map: MapView) {
    const head = element("tr");
    for (const { id, label, hint } of kColumns) {
      const cell = element("th", { scope: "col" }, button(label, () => this.sortBy(id), { title: hint }));
      this.heads.set(id, cell);
      head.append(cell);
    }
    const table = element("table", {}, element("caption", { class: "sr" }, "Loop closures"), element("thead", {}, head), this.body);
    this.detail.append(
      element("div", { class: "pair" },
        element("figure", {}, this.before, element("figcaption", {}, "before: front end")),
        element("figure", {}, this.after, element("figcaption", {}, "after: now"))),
      this.words, element("div", { class: "row" }, this.toggle, this.undo));
    this.element.append(this.summary, element("div", { class: "scroll grow", tabindex: "0", role: "region", "aria-label": "List of closures" }, table), this.detail);
  }

  private sortBy(by: Column): void {
    this.sort = { by, down: this.sort.by === by ? !this.sort.down : by !== "from" && by !== "to" };
    this.session.touch();
  }

  private select(index: number): void {
    const { session } = this;
    session.closure = index;
    const closure = session.model.closures[index];
    if (closure) {
      const { estimates } = session.model;
      const ends = [closure.from, closure.to].map((scan) => estimates.row(scan)).filter((row) => row >= 0).map((row) => estimates.pose(row));
      const [a, b] = [ends[0], ends[ends.length - 1]];
      if (a && b) this.map.flyTo((a[0] + b[0]) / 2, (a[1] + b[1]) / 2);
    }
    session.touch();
  }

  private flip(): void {
    const closure = this.session.model.closures[this.session.closure];
    if (!closure) return;
    const on = !closure.enabled;
    this.session.commands.issue(`Closure ${closure.from} \u2013 ${closure.to} ${on ? "on" : "off"}`, { do: "switch_closure", from: closure.from, to: closure.to, on });
  }

  frame(): void {
    const { session } = this;
    const { closures, versions } = session.model;
    if (session.closure >= closures.length) session.closure = -1;
    const key = [versions.closures, this.sort.by, this.sort.down].join(" ");
    if (key !== this.drawn) {
      this.drawn = key;
      this.list();
    }
    this.mark();
    this.showDetail();
  }

  private list(): void {
    const { closures } = this.session.model;
    const off = closures.filter((one) => !one.enabled).length;
    setText(this.summary, closures.length === 0 ? "This run has no loop closures." : `${count(closures.length)} closures${off > 0 ? `, ${off} switched off` : ""}. Click one to see its two scans.${closures.length > kMostRows ? ` The first ${kMostRows} in this order are listed.` : ""}`);
    const { by, down } = this.sort;
    for (const [id, cell] of this.heads) setAttribute(cell, "aria-sort", id !== by ? "none" : down ? "descending" : "ascending");
    const order = closures.map((_, i) => i).sort((a, b) => (down ? -1 : 1) * ((closures[a]?.[by] ?? 0) - (closures[b]?.[by] ?? 0)) || a - b);
    this.rows.clear();
    this.body.replaceChildren(...order.slice(0, kMostRows).map((index) => this.row(index)));
  }

  private row(index: number): HTMLElement {
    const closure = this.session.model.closures[index];
    const row = element("tr", { tabindex: "0", "data-index": String(index), class: closure?.enabled ? "" : "off" });
    if (closure) for (const column of kColumns) row.append(element("td", {}, column.text(closure)));
    row.addEventListener("click", () => this.select(index));
    row.addEventListener("keydown", (event) => {
      if (event.key === "Enter" || event.key === " ") this.select(index);
      else if (event.key === "ArrowDown") (row.nextElementSibling as HTMLElement | null)?.focus();
      else if (event.key === "ArrowUp") (row.previousElementSibling as HTMLElement | null)?.focus();
      else return;
      event.preventDefault();
    });
    this.rows.set(String(index), row);
    return row;
  }

  private mark(): void {
    for (const [index, row] of this.rows) setAttribute(row, "aria-selected", String(Number(index) === this.session.closure));
  }

  private showDetail(): void {
    const { session } = this;
    const closure = session.model.closures[session.closure];
    this.detail.hidden = !closure;
    if (!closure) return;
    const pending = session.commands.pending().some((one) => one.do === "switch_closure" || one.do === "undo");
    setText(this.toggle, pending ? "Working \u2026" : closure.enabled ? "Switch off" : "Switch on");
    this.toggle.disabled = pending || !session.may("switch_closure");
    this.toggle.title = session.may("switch_closure") ? "" : "Only with a running majak view";
    this.undo.disabled = pending || !session.may("undo") || !session.model.edits.can_undo;
    const key = [session.closure, session.model.versions.closures, session.model.versions.poses, session.model.versions.scans, session.night].join(" ");
    if (key === this.drawnDetail) return;
    this.drawnDetail = key;
    setText(this.words, `Scans ${count(closure.from)} and ${count(closure.to)}: overlap ${fixed(100 * closure.overlap, 0)} %, moved the later one by ${metres(closure.effect_m)} and ${degrees(closure.effect_rad)}.${closure.enabled ? "" : closure.by_hand ? " Switched off by hand." : " Not used."}`);
    this.overlay(this.before, closure, (row) => three(session.model.estimates.frontEnd, row));
    this.overlay(this.after, closure, (row) => session.model.estimates.pose(row));
  }

  private overlay(canvas: HTMLCanvasElement, closure: Closure, poseOf: (row: number) => Pose): void {
    const { model } = this.session;
    const context = canvas.getContext("2d");
    if (!context) return;
    context.clearRect(0, 0, canvas.width, canvas.height);
    const rows = [model.estimates.row(closure.from), model.estimates.row(closure.to)] as const;
    if (rows[0] < 0 || rows[1] < 0) return;
    const relative = compose(inverse(poseOf(rows[0])), poseOf(rows[1]));
    if (!Number.isFinite(relative[0])) return this.sorry(context, canvas, "not in this stream");
    const palette = this.map.layers.palette;
    const reach = 9; // m to each side
    const scale = canvas.width / 2 / reach;
    const draw = (scan: number, pose: Pose, colour: string): void => {
      const points = new Float32Array(2 * model.scans.beamsOf(scan));
      const n = model.scans.points(scan, points);
      const [x, y, theta] = compose(pose, model.laserPose(model.scans.laser(scan)));
      context.fillStyle = colour;
      for (let i = 0; i < n; i += 2) {
        const [px, py] = [points[i] ?? 0, points[i + 1] ?? 0];
        const mx = x + Math.cos(theta) * px - Math.sin(theta) * py;
        const my = y + Math.sin(theta) * px + Math.cos(theta) * py;
        context.fillRect(canvas.width / 2 + mx * scale - 1.5, canvas.height / 2 - my * scale - 1.5, 3, 3);
      }
    };
    draw(closure.from, [0, 0, 0], palette.trail);
    draw(closure.to, relative, palette.closure);
  }

  private sorry(context: CanvasRenderingContext2D, canvas: HTMLCanvasElement, text: string): void {
    context.fillStyle = this.map.layers.palette.graph;
    context.font = "24px system-ui, sans-serif";
    context.textAlign = "center";
    context.fillText(text, canvas.width / 2, canvas.height / 2);
  }
}
