// SPDX-License-Identifier: Apache-2.0
// The layers with their eyes.
import { element, kIcons, svg } from "../dom.js";
import type { Session } from "../session.js";
import { type Layers, type LayerId, kLayers } from "../view/layers.js";

export class LayerList {
  readonly element = element("details", { class: "layers card", open: "" });
  private readonly rows = new Map<LayerId, { label: HTMLElement; box: HTMLInputElement; eye: HTMLElement; swatch: HTMLElement }>();
  private drawn = "";

  constructor(private readonly session: Session, private readonly layers: Layers) {
    const list = element("fieldset", {}, element("legend", { class: "sr" }, "Layers"));
    this.element.append(element("summary", {}, "Layers"), list);
    for (const { id, label } of kLayers) {
      const box = element("input", { type: "checkbox", "data-layer": id });
      const eye = element("span", { class: "eye" });
      const swatch = element("span", { class: "swatch" });
      const row = element("label", { class: "layer" }, box, eye, swatch, label);
      box.addEventListener("change", () => {
        layers.on.set(id, box.checked);
        session.touch();
      });
      this.rows.set(id, { label: row, box, eye, swatch });
      list.append(row);
    }
  }

  frame(): void {
    const { session, layers } = this;
    const key = [session.version, session.night, ...Object.values(session.model.versions)].join(" ");
    if (key === this.drawn) return;
    this.drawn = key;
    for (const { id, swatch: name, has } of kLayers) {
      const row = this.rows.get(id);
      if (!row) continue;
      const on = layers.on.get(id) ?? false;
      row.box.checked = on;
      if (row.eye.dataset["on"] !== String(on)) {
        row.eye.dataset["on"] = String(on);
        row.eye.innerHTML = svg(on ? kIcons.eye : kIcons.eyeOff);
      }
      row.swatch.style.background = layers.palette[name];
      row.label.hidden = !has(session);
    }
  }
}
