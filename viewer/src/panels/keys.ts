// SPDX-License-Identifier: Apache-2.0
// All keys of the page, and the page that tells them.
import { button, element } from "../dom.js";

export interface Key {
  shown: string;
  does: string;
  matches(event: KeyboardEvent): boolean;
  run(): void;
}

/// A key alone (shift is free for signs such as + and ?).
export function plain(key: string, shown: string, does: string, run: () => void): Key {
  return { shown, does, run, matches: (event) => event.key.toLowerCase() === key && !event.ctrlKey && !event.metaKey && !event.altKey };
}

const typing = (target: EventTarget | null): boolean => target instanceof HTMLElement && (target.matches("select, textarea") || (target instanceof HTMLInputElement && target.type !== "checkbox"));

/// Space and Enter press the button that has the focus.
const pressing = (event: KeyboardEvent): boolean => (event.key === " " || event.key === "Enter") && event.target instanceof HTMLElement && event.target.closest("button, summary, tr, label, input") !== null;

export function listen(root: HTMLElement, whole: boolean, keys: Key[]): void {
  (whole ? document : root).addEventListener("keydown", (event) => {
    if (!(event instanceof KeyboardEvent) || event.defaultPrevented || typing(event.target) || pressing(event) || root.querySelector("dialog[open]")) return;
    const key = keys.find((one) => one.matches(event));
    if (!key) return;
    event.preventDefault();
    key.run();
  });
}

export function helpDialog(keys: Key[]): HTMLDialogElement {
  const list = element("dl");
  for (const { shown, does } of keys) if (shown !== "") list.append(element("dt", {}, element("kbd", {}, shown)), element("dd", {}, does));
  const dialog = element("dialog", { "aria-label": "Help and keys" });
  dialog.append(
    element("h2", {}, "Keys"), list,
    element("h2", {}, "Mouse and fingers"),
    element("p", {}, "Drag moves the map (with a drawing tool: the right button does), the wheel or two fingers zoom, shift and drag or two fingers turn it. A click near the trail goes to that pose; a click in a chart goes to that time, a drag in it zooms, a double click shows all again."),
    element("p", { class: "end" }, button("Close", () => dialog.close(), { class: "primary" })));
  return dialog;
}
