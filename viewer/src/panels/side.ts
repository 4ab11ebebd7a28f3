// SPDX-License-Identifier: Apache-2.0
// The panel at the side, with a tab for each task.
import { element, setAttribute } from "../dom.js";
import type { Session } from "../session.js";
import type { MapView } from "../view/map_view.js";
import { ClosuresPanel } from "./closures_panel.js";
import { EditPanel } from "./edit_panel.js";
import { LocalizePanel } from "./localize_panel.js";
import { PosePanel } from "./pose_panel.js";
import { RunPanel } from "./run_panel.js";

interface Page {
  element: HTMLElement;
  frame(): void;
}

let nextId = 0;

export class Side {
  readonly element = element("aside", { class: "side", "aria-label": "Details" });
  readonly edit: EditPanel;
  private readonly pages: { name: string; page: Page; tab: HTMLButtonElement }[];
  private open = 0;

  constructor(private readonly session: Session, map: MapView) {
    this.edit = new EditPanel(session);
    const localize = new LocalizePanel(session);
    map.hand.onFinished = (finished) => {
      this.edit.finished(finished);
      localize.finished(finished);
    };
    map.onPick = () => this.show(0);
    map.onPickClosure = () => this.show(1);
    map.hand.onCancel = () => {
      session.tool = "look";
      session.touch();
    };
    const tabs = element("div", { class: "tabs", role: "tablist", "aria-label": "Details" });
    const named: [string, Page][] = [["Pose", new PosePanel(session)], ["Closures", new ClosuresPanel(session, map)], ["Edit", this.edit], ["Localize", localize], ["Run", new RunPanel(session)]];
    const prefix = `majak-${++nextId}`;
    this.pages = named.map(([name, page], i) => {
      const tab = element("button", { type: "button", role: "tab", id: `${prefix}-tab-${i}`, "aria-controls": `${prefix}-page-${i}` }, name);
      page.element.id = `${prefix}-page-${i}`;
      setAttribute(page.element, "role", "tabpanel");
      setAttribute(page.element, "aria-labelledby", tab.id);
      setAttribute(page.element, "tabindex", "0");
      tab.addEventListener("click", () => this.show(i));
      tab.addEventListener("keydown", (event) => this.key(event, i));
      tabs.append(tab);
      return { name, page, tab };
    });
    this.element.append(tabs, ...this.pages.map(({ page }) => page.element));
    this.show(0);
  }

  private key(event: KeyboardEvent, i: number): void {
    const to = event.key === "ArrowRight" ? i + 1 : event.key === "ArrowLeft" ? i - 1 : undefined;
    if (to === undefined) return;
    event.preventDefault();
    const at = (to + this.pages.length) % this.pages.length;
    this.show(at);
    this.pages[at]?.tab.focus();
  }

  show(which: number): void {
    this.open = which;
    this.pages.forEach(({ page, tab }, i) => {
      page.element.hidden = i !== which;
      setAttribute(tab, "aria-selected", String(i === which));
      setAttribute(tab, "tabindex", i === which ? "0" : "-1");
    });
    this.pages[which]?.page.frame();
    this.session.touch();
  }

  frame(): void {
    if (!this.element.hidden) this.pages[this.open]?.page.frame();
  }
}
