// SPDX-License-Identifier: Apache-2.0
// What the program found out about the log.
import { element } from "../dom.js";
import type { Session } from "../session.js";
import { clock, count, duration, fixed } from "../text.js";

export class RunPanel {
  readonly element = element("div", { class: "page" });
  private drawn = "";

  constructor(private readonly session: Session) {}

  frame(): void {
    const { model } = this.session;
    const { run, estimates, scans } = model;
    const key = [model.versions.run, Math.floor(model.versions.estimates / 50)].join(" ");
    if (key === this.drawn) return;
    this.drawn = key;
    const begin = Number(run.begin) / 1e9;
    const end = Number(run.end) / 1e9;
    const facts: [string, string][] = [["Log", run.name], ["Scans", count(Math.max(run.scans, estimates.size))], ["Begin (UTC)", begin > 0 ? clock(begin).slice(0, 19) : "\u2013"], ["Length", end > begin ? duration(end - begin, 0) : "\u2013"], ["Beams here", count(scans.beams)], ["majak", run.version]];
    if (model.map) facts.push(["Map", `${fixed(model.map.width * model.map.resolution, 0)} \u00d7 ${fixed(model.map.height * model.map.resolution, 0)} m at ${fixed(100 * model.map.resolution, 0)} cm`]);
    const list = element("dl", { class: "facts" });
    for (const [name, value] of facts) list.append(element("dt", {}, name), element("dd", {}, value));
    this.element.replaceChildren(list);
    if (run.findings.length > 0) this.element.append(element("div", {}, element("h3", {}, "Found out about the robot"), element("ul", { class: "words" }, ...run.findings.map((text) => element("li", {}, text)))));
    if (run.report.length > 0) this.element.append(element("div", {}, element("h3", {}, "Put aside while reading"), element("ul", { class: "words" }, ...run.report.map((one) => element("li", {}, `${count(one.count)} \u00d7 ${one.what}${one.first_line ? ` (first in line ${count(one.first_line)})` : ""}`)))));
  }
}
