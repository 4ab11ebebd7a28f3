// SPDX-License-Identifier: Apache-2.0
// The head of the page: which run, how the program is, one line of news, and what concerns the whole page.
import { button, element, iconButton, kIcons, setAttribute, setText, svg } from "../dom.js";
import type { Session } from "../session.js";
import type { Command } from "../stream/commands.js";
import { count, fixed } from "../text.js";

export interface HeadActions {
  theme(): void;
  charts(): void;
  side(): void;
  help(): void;
  retry(): void;
}

const kStates: Record<string, string> = { mapping: "mapping", finished: "finished", localizing: "localizing", recording: "recording" };

export class Head {
  readonly element = element("header", { class: "head" });
  readonly banner = element("div", { class: "banner", role: "alert", hidden: "" });
  private readonly name = element("span", { class: "run-name" });
  private readonly state = element("span", { class: "pill" });
  private readonly news = element("span", { class: "status", "aria-live": "polite", role: "status" });
  private readonly bannerText = element("span");
  private readonly theme: HTMLButtonElement;
  readonly charts: HTMLButtonElement;
  readonly side: HTMLButtonElement;
  private said: { text: string; bad: boolean } | undefined;

  constructor(private readonly session: Session, actions: HeadActions) {
    this.theme = iconButton(kIcons.moon, "Night colours (N)", actions.theme);
    this.charts = iconButton(kIcons.chart, "Charts (C)", actions.charts, { "aria-pressed": "true" });
    this.side = iconButton(kIcons.panel, "Side panel (P)", actions.side, { "aria-pressed": "true" });
    const help = iconButton(kIcons.help, "Help and keys (?)", actions.help);
    this.element.append(element("span", { class: "mark" }, "majak"), this.name, this.state, this.news, element("div", { class: "group" }, this.charts, this.side, this.theme, help));
    this.banner.append(this.bannerText, button("Try now", actions.retry));
  }

  /// One sentence in the line of news.
  say(text: string, bad = false): void {
    this.said = { text, bad };
  }

  tell(command: Command): void {
    if (command.fate === "done") this.say(`${command.label}: done and saved.`);
    if (command.fate === "refused") this.say(`${command.label}: ${command.error}.`, true);
    if (command.fate === "unknown") this.say(`${command.label}: ${command.error}.`, true);
  }

  frame(): void {
    const { session } = this;
    const { run } = session.model;
    setText(this.name, run.name || "waiting for a run");
    setText(this.state, session.link === "embedded" ? "report" : (kStates[run.state] ?? run.state));
    const pending = session.commands.pending();
    const text = pending.length > 0 ? `${pending[pending.length - 1]?.label ?? ""} \u2026` : (this.said?.text ?? this.activity());
    setText(this.news, text);
    this.news.title = text;
    this.news.classList.toggle("bad", pending.length === 0 && (this.said?.bad ?? false));
    this.showLink();
    const name = session.night ? "Day colours (N)" : "Night colours (N)";
    if (this.theme.title !== name) {
      this.theme.title = name;
      setAttribute(this.theme, "aria-label", name);
      this.theme.innerHTML = svg(session.night ? kIcons.sun : kIcons.moon);
    }
  }

  private activity(): string {
    const { status } = this.session.model;
    const parts = [status.activity ?? ""];
    if (status.scans_per_second) parts.push(`${fixed(status.scans_per_second, 0)} scans/s`);
    if (status.skipped) parts.push(`${count(status.skipped)} skipped`);
    if (status.memory_mb) parts.push(`${fixed(status.memory_mb, 0)} MB`);
    return parts.filter((part) => part !== "").join("  \u00b7  ");
  }

  private showLink(): void {
    const { session } = this;
    const broken = session.link === "lost" || (session.link === "connecting" && session.retryAt > 0);
    this.banner.hidden = !broken;
    if (!broken) return;
    const left = Math.max(0, Math.ceil((session.retryAt - Date.now()) / 1000));
    setText(this.bannerText, session.link === "lost" ? `The connection to majak is lost; the page shows what it had. Trying again in ${left} s.` : "Connecting to majak again \u2026");
  }
}
