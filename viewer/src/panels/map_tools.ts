// SPDX-License-Identifier: Apache-2.0
// The buttons at the map's edge.
import { element, iconButton, kIcons, setAttribute, setText } from "../dom.js";
import type { Session } from "../session.js";
import type { MapView } from "../view/map_view.js";
import { kToolHints } from "../view/tools.js";

export class MapTools {
  readonly element = element("div", { class: "map-tools card", role: "toolbar", "aria-label": "Map", "aria-orientation": "vertical" });
  readonly hint = element("div", { class: "hint", role: "status", hidden: "" });
  private readonly follow: HTMLButtonElement;
  private readonly measure: HTMLButtonElement;
  private readonly north: HTMLButtonElement;

  constructor(private readonly session: Session, private readonly map: MapView) {
    const zoom = (factor: number) => () => map.zoom(factor);
    this.follow = iconButton(kIcons.follow, "Follow the robot (F)", () => this.toggleFollow(), { "aria-pressed": "false" });
    this.measure = iconButton(kIcons.ruler, "Measure (M)", () => this.toggleMeasure(), { "aria-pressed": "false" });
    this.north = iconButton(kIcons.north, "North up (0)", () => this.northUp());
    this.element.append(iconButton(kIcons.plus, "Zoom in (+)", zoom(1.4)), iconButton(kIcons.minus, "Zoom out (\u2212)", zoom(1 / 1.4)), iconButton(kIcons.fit, "Show all (A)", () => map.fit()), this.north, this.follow, this.measure);
  }

  toggleFollow(): void {
    this.session.follow = !this.session.follow;
    this.session.touch();
  }

  toggleMeasure(): void {
    this.session.tool = this.session.tool === "measure" ? "look" : "measure";
    this.session.touch();
  }

  northUp(): void {
    this.map.rotate(-this.map.camera.rotation);
  }

  frame(): void {
    const { session } = this;
    setAttribute(this.follow, "aria-pressed", String(session.follow));
    setAttribute(this.measure, "aria-pressed", String(session.tool === "measure"));
    setAttribute(this.map.element, "data-tool", session.tool);
    const arrow = this.north.firstElementChild;
    if (arrow instanceof SVGElement) arrow.style.transform = `rotate(${-this.map.camera.rotation}rad)`;
    this.hint.hidden = session.tool === "look";
    setText(this.hint, kToolHints[session.tool]);
  }
}
