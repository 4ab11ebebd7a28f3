// SPDX-License-Identifier: Apache-2.0
// Figures over time (uPlot). All charts share the range of time; a click goes there.
import uPlot from "uplot";
import { element, setText } from "../dom.js";
import type { Session } from "../session.js";
import { compose, inverse, type Pose } from "../stream/pose.js";
import { three } from "../stream/columns.js";
import { thinMinMax } from "../stream/thin.js";
import { duration, fixed, kDegree } from "../text.js";

interface Series {
  unit: string;
  digits: number;
  colour: string; ///< of style.css
  value(session: Session, row: number): number;
}

interface ChartInfo {
  title: string;
  series: Series[];
  has(session: Session): boolean;
  steps?: boolean;
}

const always = (): boolean => true;

const kCharts: readonly ChartInfo[] = [
  { title: "Error against truth", has: ({ model }) => model.truth !== undefined, series: [{ unit: "m", digits: 3, colour: "--lost", value: errorAt }] },
  {
    title: "Uncertainty", has: always, series: [
      { unit: "m", digits: 3, colour: "--accent", value: ({ model: { estimates: e } }, row) => Math.sqrt(Math.max(0, (e.covariances[6 * row] ?? 0) + (e.covariances[6 * row + 3] ?? 0))) },
      { unit: "\u00b0", digits: 2, colour: "--degraded", value: ({ model: { estimates: e } }, row) => Math.sqrt(Math.max(0, e.covariances[6 * row + 5] ?? 0)) / kDegree },
    ],
  },
  { title: "Score", has: always, series: [{ unit: "", digits: 2, colour: "--accent", value: ({ model }, row) => model.estimates.score[row] ?? NaN }] },
  { title: "Time per scan", has: ({ model: { estimates: e } }) => e.milliseconds.subarray(0, e.size).some((ms) => Number.isFinite(ms)), series: [{ unit: "ms", digits: 1, colour: "--accent", value: ({ model }, row) => model.estimates.milliseconds[row] ?? NaN }] },
  { title: "Particles", has: ({ model: { estimates: e } }) => e.particles.subarray(0, e.size).some((n) => n > 0), series: [{ unit: "", digits: 0, colour: "--accent", value: ({ model }, row) => model.estimates.particles[row] ?? 0 }] },
  { title: "Health", has: always, steps: true, series: [{ unit: "", digits: 0, colour: "--degraded", value: ({ model }, row) => model.estimates.health[row] ?? 0 }] },
];

/// Distance in m to the truth, which is interpolated; NaN where there is none near.
export function errorAt({ model }: Session, row: number): number {
  const { truth, estimates } = model;
  if (!truth || truth.times.length === 0) return NaN;
  const at = truthAt(truth.times, truth.poses, estimates.time[row] ?? 0);
  if (!at) return NaN;
  const [x, y] = compose(inverse(at), estimates.pose(row));
  return Math.hypot(x, y);
}

const kFarthest = 1; // s between two poses of the truth

export function truthAt(times: Float64Array, poses: Float64Array, time: number): Pose | undefined {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? 0) <= time) low = middle + 1;
    else high = middle;
  }
  const a = low - 1;
  if (a < 0) return undefined;
  const from = times[a] ?? 0;
  const to = times[a + 1] ?? from;
  if (time === from) return three(poses, a);
  if (a + 1 >= times.length || to - from > kFarthest) return undefined;
  const part = (time - from) / (to - from);
  const step = compose(inverse(three(poses, a)), three(poses, a + 1));
  return compose(three(poses, a), [part * step[0], part * step[1], part * step[2]]);
}

const kMost = 4000; // points a chart
const kHeight = 96; // px
const kEvery = 400; // ms between new data
const kHealthNames = ["ok", "degr.", "lost"];

class Chart {
  readonly element = element("section", { class: "chart" });
  private readonly figure = element("output");
  private readonly place = element("div");
  private readonly now = element("div", { class: "now" });
  private plot: uPlot | undefined;
  private styled = "";

  constructor(private readonly session: Session, readonly info: ChartInfo, private readonly zoomed: (range: [number, number] | undefined) => void) {
    this.element.setAttribute("aria-label", info.title);
    this.element.append(element("h3", {}, info.title, this.figure), this.place);
  }

  frame(): void {
    const { session, plot } = this;
    if (!plot) return;
    const row = session.row();
    setText(this.figure, row < 0 ? "" : this.info.series.map((one) => this.text(one, one.value(session, row))).join("  "));
  }

  /// The line of the present time, in every frame.
  follow(): void {
    if (!this.plot) return;
    const at = this.plot.valToPos(this.session.axis.place(this.session.time), "x");
    const shown = at >= -1 && at <= this.plot.bbox.width / devicePixelRatio + 1;
    const to = `translateX(${(shown ? at : -10000).toFixed(1)}px)`;
    if (this.now.style.transform !== to) this.now.style.transform = to;
  }

  private text(one: Series, value: number): string {
    if (this.info.steps) return ["ok", "degraded", "lost"][value] ?? "";
    if (!Number.isFinite(value)) return "";
    return `${fixed(value, one.digits)}${one.unit === "" ? "" : one.unit === "\u00b0" ? "\u00b0" : ` ${one.unit}`}`;
  }

  fill(range: [number, number] | undefined): void {
    const { session } = this;
    const width = Math.floor(this.place.clientWidth);
    if (width < 20) return;
    const style = `${session.night}/${this.info.series.length}`;
    if (this.styled !== style) this.plot?.destroy();
    if (this.styled !== style) this.plot = this.make(width);
    this.styled = style;
    const data = this.data(range);
    this.plot?.setData(data as uPlot.AlignedData, false);
    this.plot?.setScale("x", { min: range?.[0] ?? 0, max: range?.[1] ?? Math.max(session.axis.length, 1e-3) });
    if (this.plot && this.plot.width !== width) this.plot.setSize({ width, height: kHeight });
  }

  /// Thinned in common: both series of a chart need the same places.
  private data(range: [number, number] | undefined): (number | null)[][] {
    const { session, info } = this;
    const { estimates } = session.model;
    const { axis } = session;
    const from = range ? Math.max(0, estimates.rowAt(axis.time(range[0])) - 1) : 0;
    const to = range ? Math.min(estimates.size, estimates.rowAt(axis.time(range[1])) + 2) : estimates.size;
    const rows = Array.from({ length: Math.max(0, to - from) }, (_, i) => from + i);
    const kept = new Set<number>();
    for (const series of info.series) {
      const y = rows.map((row) => series.value(session, row));
      for (const i of thinMinMax(rows, y, 0, rows.length, kMost / info.series.length).x) kept.add(i);
    }
    const sorted = [...kept].sort((a, b) => a - b);
    const finite = (value: number): number | null => (Number.isFinite(value) ? value : null);
    return [sorted.map((row) => axis.place(estimates.time[row] ?? 0)), ...info.series.map((one) => sorted.map((row) => finite(one.value(session, row))))];
  }

  private make(width: number): uPlot {
    const { session, info } = this;
    const style = getComputedStyle(this.element);
    const colour = (name: string): string => style.getPropertyValue(name).trim();
    const font = "11px system-ui, sans-serif";
    const axis = (scale: string, side: 1 | 3, stroke: string): uPlot.Axis => ({ scale, side, stroke, font, size: 40, gap: 2, space: 26, ticks: { show: false }, grid: { show: side === 3, stroke: colour("--line-soft"), width: 1 }, ...(info.steps ? { splits: [0, 1, 2], values: kHealthNames } : {}) });
    const plot: uPlot = new uPlot(
      {
        width, height: kHeight, legend: { show: false }, padding: [6, info.series.length > 1 ? 0 : 6, 2, 0],
        scales: { x: { time: false }, ...Object.fromEntries(info.series.map((_, i) => [`y${i}`, info.steps ? { range: [-0.15, 2.15] } : { range: (_u: uPlot, _min: number | null, max: number | null): [number, number] => [0, Math.max(max ?? 1, 1e-9) * 1.08] }])) } as uPlot.Scales,
        axes: [{ size: 16, gap: 1, font, stroke: colour("--quiet"), ticks: { show: false }, grid: { show: false }, values: (_u, splits) => splits.map((at) => (at === 0 ? "" : duration(at, 0))) }, ...info.series.map((one, i) => axis(`y${i}`, i === 0 ? 3 : 1, info.series.length > 1 ? colour(one.colour) : colour("--quiet")))],
        series: [{}, ...info.series.map((one, i): uPlot.Series => ({ scale: `y${i}`, stroke: colour(one.colour), width: 1.2, points: { show: false }, ...(info.steps && uPlot.paths.stepped ? { paths: uPlot.paths.stepped({ align: 1 }) } : {}) }))],
        cursor: { y: false, drag: { x: true, y: false, setScale: false, dist: 6 }, points: { show: false } },
        hooks: {
          setSelect: [(u) => {
            if (u.select.width < 6) return;
            this.zoomed([u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x")]);
            u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          }],
        },
      },
      [[], ...info.series.map(() => [])] as unknown as uPlot.AlignedData,
      this.place,
    );
    plot.over.append(this.now);
    let down = 0;
    plot.over.addEventListener("mousedown", (event) => (down = event.clientX));
    plot.over.addEventListener("click", (event) => {
      if (Math.abs(event.clientX - down) > 5) return;
      session.goTo(session.axis.time(plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x")));
    });
    plot.over.addEventListener("dblclick", () => this.zoomed(undefined));
    return plot;
  }
}

export class Charts {
  readonly element = element("div", { class: "charts", role: "group", "aria-label": "Charts", tabindex: "0" });
  private readonly charts: Chart[];
  private range: [number, number] | undefined;
  private drawn = "";
  private drawnAt = 0;

  constructor(private readonly session: Session) {
    this.charts = kCharts.map((info) => new Chart(session, info, (range) => this.zoom(range)));
    this.element.append(...this.charts.map((chart) => chart.element));
  }

  /// Places on the axis of time, undefined: all.
  zoom(range: [number, number] | undefined): void {
    this.range = range;
    this.drawnAt = 0;
  }

  follow(): void {
    if (this.element.hidden) return;
    for (const chart of this.charts) if (!chart.element.hidden) chart.follow();
  }

  frame(): void {
    const { session } = this;
    if (this.element.hidden) return;
    const now = performance.now();
    const key = [session.model.versions.estimates, session.model.versions.poses, session.model.versions.truth, this.element.clientWidth, session.night, this.range].join(" ");
    if (key !== this.drawn && now - this.drawnAt > kEvery) {
      this.drawn = key;
      this.drawnAt = now;
      for (const chart of this.charts) chart.element.hidden = !chart.info.has(session);
      for (const chart of this.charts) if (!chart.element.hidden) chart.fill(this.range);
    }
    for (const chart of this.charts) if (!chart.element.hidden) chart.frame();
  }
}
