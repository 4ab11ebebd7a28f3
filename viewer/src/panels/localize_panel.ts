// SPDX-License-Identifier: Apache-2.0
// Localization in the map: a simulated robot, its start, and where the filter believes it to be.
import { button, element, setAttribute, setText } from "../dom.js";
import type { Session, Tool } from "../session.js";
import { count, degrees, fixed, metres } from "../text.js";
import type { Finished } from "../view/tools.js";

const kMethods = ["monte-carlo", "markov", "global", "tracking"];

export class LocalizePanel {
  readonly element = element("div", { class: "page" });
  private readonly method = element("select", { "aria-label": "Method" });
  private readonly start = button("Start a simulated robot", () => this.issueStart(), { class: "primary" });
  private readonly stop = button("Stop", () => this.session.commands.issue("Stop localizing", { do: "stop_localizing" }));
  private readonly poses = new Map<Tool, HTMLButtonElement>();
  private readonly list = element("ul", { class: "plain" });
  private readonly words = element("p", { class: "note" });
  private drawn = "";

  constructor(private readonly session: Session) {
    for (const method of kMethods) this.method.append(element("option", { value: method }, method));
    this.method.value = "monte-carlo";
    this.poses.set("start_pose", button("Set start pose", () => this.take("start_pose"), { "aria-pressed": "false", "data-tool": "start_pose" }));
    this.poses.set("kidnap", button("Kidnap robot", () => this.take("kidnap"), { "aria-pressed": "false", "data-tool": "kidnap" }));
    this.element.append(
      element("div", { class: "row" }, this.method, this.start, this.stop), element("div", { class: "tools" }, ...this.poses.values()), this.words,
      element("div", {}, element("h3", {}, "Hypotheses"), this.list));
  }

  private issueStart(): void {
    this.session.commands.issue("Start localizing", { do: "localize", method: this.method.value });
    this.session.live = true;
    this.session.touch();
  }

  private take(tool: Tool): void {
    this.session.tool = this.session.tool === tool ? "look" : tool;
    this.session.touch();
  }

  finished({ tool, points: [a, b] }: Finished): void {
    if (!a || !b || (tool !== "start_pose" && tool !== "kidnap")) return;
    const pose = [a[0], a[1], Math.atan2(b[1] - a[1], b[0] - a[0])];
    this.session.commands.issue(tool === "kidnap" ? "Kidnap" : "Start pose", { do: tool, pose });
    this.session.tool = "look";
  }

  frame(): void {
    const { session } = this;
    const { model } = session;
    const running = model.run.state === "localizing";
    this.start.disabled = !session.may("localize");
    this.method.disabled = this.start.disabled;
    this.stop.disabled = session.link !== "open" || !(running || model.run.may.includes("stop_localizing"));
    for (const [tool, one] of this.poses) {
      one.disabled = !session.may(tool);
      setAttribute(one, "aria-pressed", String(session.tool === tool));
    }
    const particles = (model.particles?.poses.length ?? 0) / 3;
    setText(this.words, this.sentence(running, particles));
    const key = String(model.versions.hypotheses);
    if (key === this.drawn) return;
    this.drawn = key;
    const sorted = [...model.hypotheses].sort((a, b) => b.weight - a.weight).slice(0, 20);
    this.list.replaceChildren(...sorted.map(({ pose, weight }) => element("li", {}, `${fixed(100 * weight, 0)} %`, element("span", { class: "note" }, `${metres(pose[0])}, ${metres(pose[1])}, ${degrees(pose[2], 0)}`))));
    if (sorted.length === 0) this.list.append(element("li", { class: "note" }, "none"));
  }

  private sentence(running: boolean, particles: number): string {
    if (this.session.link === "embedded") return "Only with a running majak view.";
    const cloud = particles > 0 ? ` ${count(particles)} particles are shown.` : "";
    return running ? `The robot drives.${cloud}` : `A simulated robot drives through this map and must find where it is.${cloud}`;
  }
}
