// SPDX-License-Identifier: Apache-2.0
// Corrections of the map by hand.
import { button, element, iconButton, kIcons, setAttribute, setText } from "../dom.js";
import type { Session, Tool } from "../session.js";
import type { Command } from "../stream/commands.js";
import type { Edit } from "../stream/records.js";
import { degrees } from "../text.js";
import type { Finished } from "../view/tools.js";

const kTools: readonly { tool: Tool; label: string }[] = [
  { tool: "erase-box", label: "Erase a box" },
  { tool: "erase", label: "Erase an area" },
  { tool: "wall", label: "Add a wall" },
  { tool: "forbidden", label: "Forbidden zone" },
  { tool: "crop", label: "Crop" },
  { tool: "turn", label: "Turn by a line" },
];

const kNames: Record<Edit["kind"], string> = { erase: "Erased area", wall: "Wall", forbidden: "Forbidden zone", crop: "Crop", turn: "Turn", closure_off: "Closure switched off" };

/// By how much a line must turn so that it is level, the shorter way.
export function levelling([a, b]: readonly [number, number][]): number {
  if (!a || !b) return 0;
  const angle = Math.atan2(b[1] - a[1], b[0] - a[0]);
  const turn = -angle;
  return turn > Math.PI / 2 ? turn - Math.PI : turn < -Math.PI / 2 ? turn + Math.PI : turn;
}

export class EditPanel {
  readonly element = element("div", { class: "page" });
  private readonly tools = new Map<Tool, HTMLButtonElement>();
  private readonly upright: HTMLButtonElement;
  private readonly undoButton: HTMLButtonElement;
  private readonly redoButton: HTMLButtonElement;
  private readonly write: HTMLButtonElement;
  private readonly list = element("ul", { class: "plain" });
  private readonly saving = element("p", { class: "saving", role: "status" });
  private readonly why = element("p", { class: "note" });
  private drawn = "";

  constructor(private readonly session: Session) {
    const grid = element("div", { class: "tools", role: "group", "aria-label": "Edit tools" });
    for (const { tool, label } of kTools) {
      const one = button(label, () => this.take(tool), { "aria-pressed": "false", "data-tool": tool });
      this.tools.set(tool, one);
      grid.append(one);
    }
    this.upright = button("Turn upright", () => this.issue("Turn upright", { kind: "upright" }));
    grid.append(this.upright);
    this.undoButton = iconButton(kIcons.undo, "Undo (ctrl Z)", () => this.undo());
    this.redoButton = iconButton(kIcons.redo, "Redo (ctrl shift Z)", () => this.redo());
    this.write = button("Write files", () => this.session.commands.issue("Write files", { do: "write_files" }), { class: "primary", title: "Writes the corrected map and its files anew" });
    this.element.append(this.why, grid, element("div", { class: "row" }, this.undoButton, this.redoButton, this.write), this.saving, element("div", {}, element("h3", {}, "Edits"), this.list));
  }

  private take(tool: Tool): void {
    this.session.tool = this.session.tool === tool ? "look" : tool;
    this.session.touch();
  }

  private issue(label: string, edit: Record<string, unknown>): Command {
    return this.session.commands.issue(label, { do: "edit", edit });
  }

  /// What was drawn on the map becomes an edit.
  finished({ tool, points }: Finished): void {
    const shorter = points.map(([x, y]) => [Math.round(1000 * x) / 1000, Math.round(1000 * y) / 1000]);
    if (tool === "turn") this.issue("Turn", { kind: "turn", radians: levelling(points) });
    else if (tool === "erase-box" || tool === "erase") this.issue("Erase", { kind: "erase", points: shorter });
    else if (tool === "wall" || tool === "forbidden" || tool === "crop") this.issue(kNames[tool], { kind: tool, points: shorter });
  }

  undo(): void {
    if (this.session.may("undo") && this.session.model.edits.can_undo) this.session.commands.issue("Undo", { do: "undo" });
  }
  redo(): void {
    if (this.session.may("redo") && this.session.model.edits.can_redo) this.session.commands.issue("Redo", { do: "redo" });
  }

  frame(): void {
    const { session } = this;
    const { edits, versions } = session.model;
    const may = session.may("edit");
    for (const [tool, one] of this.tools) {
      one.disabled = !may;
      setAttribute(one, "aria-pressed", String(session.tool === tool));
    }
    this.upright.disabled = !may;
    this.undoButton.disabled = !session.may("undo") || !edits.can_undo;
    this.redoButton.disabled = !session.may("redo") || !edits.can_redo;
    this.write.disabled = !session.may("write_files");
    setText(this.why, may ? "Corrections keep with the run; each can be taken back." : session.link === "lost" ? "There is no connection; the map cannot be changed now." : "This run cannot be changed here: open it with majak view.");
    this.showSaving();
    const key = String(versions.edits);
    if (key === this.drawn) return;
    this.drawn = key;
    this.list.replaceChildren(...edits.edits.map((edit) => element("li", {}, kNames[edit.kind] ?? edit.kind, element("span", { class: "note" }, detail(edit)))));
    if (edits.edits.length === 0) this.list.append(element("li", { class: "note" }, "none yet"));
  }

  private showSaving(): void {
    const { commands, model } = this.session;
    const pending = commands.pending().length;
    const last = commands.log[commands.log.length - 1];
    const kind = pending > 0 ? "pending" : last?.fate === "unknown" || last?.fate === "refused" ? "bad" : "ok";
    const text =
      pending > 0 ? (pending === 1 ? "Saving: one change is not confirmed yet \u2026" : `Saving: ${pending} changes are not confirmed yet \u2026`)
      : last?.fate === "unknown" ? `${last.label}: not confirmed before the connection broke. It was not sent again; look whether it was done.`
      : last?.fate === "refused" ? `${last.label} was not done: ${last.error}.`
      : model.edits.saved ? "All changes are on the disk." : "Some changes are not on the disk yet.";
    setAttribute(this.saving, "data-kind", model.edits.saved || kind === "bad" ? kind : "pending");
    setText(this.saving, text);
  }
}

function detail(edit: Edit): string {
  if (edit.kind === "turn") return degrees(edit.radians ?? 0, 2);
  if (edit.kind === "closure_off") return `${edit.from ?? ""} \u2013 ${edit.to ?? ""}`;
  return edit.points ? `${edit.points.length} points` : "";
}
