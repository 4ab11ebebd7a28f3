// SPDX-License-Identifier: Apache-2.0
// The pose at the present time, and how much to believe it.
import { element, setText } from "../dom.js";
import type { Session } from "../session.js";
import { ellipse } from "../stream/pose.js";
import { clock, count, degrees, fixed, metres, smallLength } from "../text.js";
import { errorAt } from "./charts.js";

const kHealth = ["ok", "degraded", "lost"];

export class PosePanel {
  readonly element = element("div", { class: "page" });
  private readonly list = element("dl", { class: "facts" });
  private readonly note = element("p", { class: "note" });
  private readonly values = new Map<string, HTMLElement>();

  constructor(private readonly session: Session) {
    for (const name of ["Scan", "Time (UTC)", "Health", "x", "y", "Heading", "Ellipse (1\u03c3)", "Score", "Took", "Particles", "Error", "Hangs on"]) {
      const value = element("dd");
      this.values.set(name, value);
      this.list.append(element("dt", {}, name), value);
    }
    this.element.append(this.list, this.note);
  }

  private show(name: string, text: string | undefined): void {
    const value = this.values.get(name);
    if (!value) return;
    value.hidden = text === undefined;
    (value.previousElementSibling as HTMLElement).hidden = text === undefined;
    setText(value, text ?? "");
  }

  frame(): void {
    const { session } = this;
    const { estimates } = session.model;
    const row = session.row();
    this.list.hidden = row < 0;
    if (row < 0) return setText(this.note, "No pose yet.");
    const [x, y, theta] = estimates.pose(row);
    const [xx, xy, , yy, , tt] = estimates.covariance(row);
    const axes = ellipse(xx, xy, yy);
    const health = estimates.health[row] ?? 0;
    this.show("Scan", `${count(estimates.scan[row] ?? 0)}${estimates.isKey[row] ? " (key)" : ""}`);
    this.show("Time (UTC)", clock(estimates.time[row] ?? 0));
    this.badge(health);
    this.show("x", `${metres(x, 3)} \u00b1 ${smallLength(Math.sqrt(Math.max(0, xx)))}`);
    this.show("y", `${metres(y, 3)} \u00b1 ${smallLength(Math.sqrt(Math.max(0, yy)))}`);
    this.show("Heading", `${degrees(theta, 2)} \u00b1 ${degrees(Math.sqrt(Math.max(0, tt)), 2)}`);
    this.show("Ellipse (1\u03c3)", `${smallLength(axes.major)} \u00d7 ${smallLength(axes.minor)}`);
    this.show("Score", fixed(estimates.score[row] ?? NaN, 3));
    const took = estimates.milliseconds[row] ?? NaN;
    this.show("Took", Number.isFinite(took) ? `${fixed(took, 2)} ms` : undefined);
    const particles = estimates.particles[row] ?? 0;
    this.show("Particles", particles > 0 ? count(particles) : undefined);
    const error = errorAt(session, row);
    this.show("Error", Number.isFinite(error) ? metres(error, 3) : undefined);
    const key = estimates.key[row] ?? 0;
    this.show("Hangs on", key === estimates.scan[row] ? undefined : `key scan ${count(key)}`);
    const match = session.selected >= 0 ? " The key scan that it was matched with lies over the map in violet." : "";
    setText(this.note, `The ellipse and the rays of the heading on the map are three sigmas wide.${match} Click near the trail to go to another pose.`);
  }

  private badge(health: number): void {
    const value = this.values.get("Health");
    const name = kHealth[health] ?? "";
    if (!value || value.textContent === name) return;
    value.replaceChildren(element("span", { class: `badge ${name}` }, name));
  }
}
