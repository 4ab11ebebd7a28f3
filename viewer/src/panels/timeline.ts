// SPDX-License-Identifier: Apache-2.0
// The strip of time: health by colour, number of scans by height, pauses cut out; and the buttons that move along it.
import { button, element, iconButton, kIcons, setAttribute, setText, svg } from "../dom.js";
import { type Session, kSpeeds } from "../session.js";
import { count, duration } from "../text.js";

const kHealth = ["ok", "degraded", "lost"] as const;

function healthKey(): HTMLElement {
  const out = element("span", { class: "key" });
  for (const health of kHealth) {
    const mark = element("i");
    mark.style.background = `var(--${health})`;
    out.append(element("span", {}, mark, health));
  }
  return out;
}

export class Timeline {
  readonly element = element("section", { class: "timeline", "aria-label": "Time" });
  private readonly strip = element("div", { class: "strip", role: "slider", tabindex: "0", "aria-label": "Time in the run", "aria-valuemin": "0" });
  private readonly canvas = element("canvas");
  private readonly cursor = element("div", { class: "cursor" });
  private readonly play = iconButton(kIcons.play, "Play (space)", () => this.session.play(!this.session.playing), { class: "icon round", "data-id": "play" });
  private readonly loop = iconButton(kIcons.loop, "Loop", () => this.toggleLoop(), { "aria-pressed": "false" });
  private readonly live = button("Live", () => this.goLive(), { class: "live", "aria-pressed": "false", title: "Stay at the newest scan" });
  private readonly speed = element("select", { "aria-label": "Speed" });
  private readonly clock = element("output", { class: "clock", "aria-label": "Present time" });
  private drawn = "";
  private width = 0; ///< px of the strip

  constructor(private readonly session: Session) {
    for (const speed of kSpeeds) this.speed.append(element("option", { value: String(speed) }, `${speed}\u00d7`));
    this.speed.value = String(session.speed);
    this.speed.addEventListener("change", () => {
      session.speed = Number(this.speed.value);
      session.touch();
    });
    this.strip.append(this.canvas, this.cursor);
    this.element.append(
      element("div", { class: "transport" },
        iconButton(kIcons.back, "One scan back (left arrow)", () => session.step(-1)),
        this.play,
        iconButton(kIcons.forward, "One scan on (right arrow)", () => session.step(1)),
        this.speed, this.loop, this.live),
      this.strip,
      element("div", { class: "under-strip" }, this.clock, healthKey()));
    this.strip.addEventListener("pointerdown", (event) => this.grab(event));
    this.strip.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) this.seek(event);
    });
    this.strip.addEventListener("keydown", (event) => this.key(event));
  }

  private toggleLoop(): void {
    this.session.loop = !this.session.loop;
    this.session.touch();
  }

  private goLive(): void {
    this.session.live = true;
    this.session.playing = false;
    this.session.touch();
  }

  private grab(event: PointerEvent): void {
    this.strip.setPointerCapture(event.pointerId);
    this.seek(event);
  }

  private seek(event: PointerEvent): void {
    const box = this.strip.getBoundingClientRect();
    const part = Math.min(1, Math.max(0, (event.clientX - box.left) / Math.max(1, box.width)));
    this.session.goTo(this.session.axis.time(part * this.session.axis.length));
  }

  /// Page keys jump a twentieth; arrows are the page's own step.
  private key(event: KeyboardEvent): void {
    const { axis, model } = this.session;
    const jump = (places: number): void => this.session.goTo(axis.time(Math.min(axis.length, Math.max(0, axis.place(this.session.time) + places))));
    if (event.key === "Home") this.session.goToRow(0);
    else if (event.key === "End") this.session.goToRow(model.estimates.size - 1);
    else if (event.key === "PageUp") jump(-axis.length / 20);
    else if (event.key === "PageDown") jump(axis.length / 20);
    else return;
    event.preventDefault();
  }

  /// The cursor alone, in every frame.
  follow(): void {
    const { axis, time } = this.session;
    const part = axis.length > 0 ? axis.place(time) / axis.length : 0;
    const to = `translateX(${(part * this.width).toFixed(1)}px)`;
    if (this.cursor.style.transform !== to) this.cursor.style.transform = to;
  }

  frame(): void {
    const { session } = this;
    const { axis } = session;
    this.drawStrip();
    const place = axis.place(session.time);
    const row = session.row();
    const { estimates } = session.model;
    const text = `${duration(place)} of ${duration(axis.length)}`;
    setText(this.clock, row < 0 ? "no scans yet" : `${duration(place)} / ${duration(axis.length, 0)}  \u00b7  scan ${count(estimates.scan[row] ?? 0)}`);
    setAttribute(this.strip, "aria-valuemax", axis.length.toFixed(1));
    setAttribute(this.strip, "aria-valuenow", place.toFixed(1));
    setAttribute(this.strip, "aria-valuetext", row < 0 ? "no scans yet" : `${text}, scan ${estimates.scan[row] ?? 0}`);
    this.buttons();
  }

  private buttons(): void {
    const { session } = this;
    const name = session.playing ? "Pause (space)" : "Play (space)";
    if (this.play.title !== name) {
      this.play.title = name;
      setAttribute(this.play, "aria-label", name);
      this.play.innerHTML = svg(session.playing ? kIcons.pause : kIcons.play);
    }
    setAttribute(this.loop, "aria-pressed", String(session.loop));
    setAttribute(this.live, "aria-pressed", String(session.live));
    this.live.hidden = session.link === "embedded" || session.model.run.state === "finished";
    if (this.speed.value !== String(session.speed)) this.speed.value = String(session.speed);
  }

  private drawStrip(): void {
    const { session } = this;
    const { model, axis } = session;
    const box = this.canvas.getBoundingClientRect();
    this.width = box.width;
    const key = [model.versions.estimates, box.width, box.height, session.night].join(" ");
    if (key === this.drawn || box.width < 1) return;
    this.drawn = key;
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    const width = (this.canvas.width = Math.round(box.width * ratio));
    const height = (this.canvas.height = Math.round(box.height * ratio));
    const context = this.canvas.getContext("2d");
    if (!context) return;
    const style = getComputedStyle(this.element);
    const counts = this.bins(width);
    const most = Math.max(1, ...counts.map((bin) => bin[0] + bin[1] + bin[2]));
    kHealth.forEach((health, worst) => {
      context.fillStyle = style.getPropertyValue(`--${health}`);
      counts.forEach((bin, x) => {
        const all = bin[0] + bin[1] + bin[2];
        const whose = bin[2] > 0 ? 2 : bin[1] > 0 ? 1 : 0;
        if (all === 0 || whose !== worst) return;
        const tall = height * (0.3 + 0.45 * Math.sqrt(all / most));
        context.fillRect(x, height - tall, 1, tall);
      });
    });
    context.fillStyle = style.getPropertyValue("--gap");
    for (const gap of axis.gaps) context.fillRect(Math.round((gap.at / axis.length) * width) - 1, 0, 2, height);
  }

  /// Scans of each health in each column of the strip.
  private bins(width: number): [number, number, number][] {
    const { estimates } = this.session.model;
    const { axis } = this.session;
    const wide = Math.max(1, Math.round(Math.min(width / 2, estimates.size / 4)));
    const coarse = Array.from({ length: wide }, (): [number, number, number] => [0, 0, 0]);
    for (let row = 0; row < estimates.size; ++row) {
      const x = Math.min(wide - 1, Math.floor((axis.place(estimates.time[row] ?? 0) / Math.max(axis.length, 1e-9)) * wide));
      const bin = coarse[x];
      const health = Math.min(2, estimates.health[row] ?? 0) as 0 | 1 | 2;
      if (bin) ++bin[health];
    }
    return Array.from({ length: width }, (_, x) => coarse[Math.min(wide - 1, Math.floor((x * wide) / width))] ?? [0, 0, 0]);
  }
}
