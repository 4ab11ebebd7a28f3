// SPDX-License-Identifier: Apache-2.0
// Mouse, fingers and wheel on the map: moves the camera, and hands clicks and strokes to the tool in the hand.
import type { Camera } from "./camera.js";

export interface Hand {
  /// Whether a stroke with the left button belongs to the tool instead of the camera.
  strokes(): boolean;
  click(px: number, py: number, double: boolean): void;
  hover(px: number, py: number): void;
  stroke(phase: "begin" | "move" | "end" | "cancel", px: number, py: number): void;
  moved(): void; ///< the camera did
}

const kClick = 5; // px that a click may move
const kDouble = 350; // ms

export function watch(target: HTMLElement, camera: Camera, hand: Hand): void {
  const fingers = new Map<number, [number, number]>();
  let mode: "none" | "pan" | "rotate" | "stroke" | "pinch" = "none";
  let begin: [number, number] = [0, 0];
  let lastClick = 0;
  let lastPlace: [number, number] = [0, 0];
  let dragged = false;

  const place = (event: MouseEvent): [number, number] => {
    const box = target.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };

  target.addEventListener("pointerdown", (event) => {
    const at = place(event);
    target.setPointerCapture(event.pointerId);
    target.focus({ preventScroll: true });
    fingers.set(event.pointerId, at);
    if (fingers.size === 2) {
      if (mode === "stroke") hand.stroke("cancel", ...at);
      mode = "pinch";
      dragged = true;
      return;
    }
    begin = at;
    dragged = false;
    mode = event.button !== 0 ? "pan" : event.shiftKey ? "rotate" : hand.strokes() ? "stroke" : "pan";
    if (mode === "stroke") hand.stroke("begin", ...at);
  });

  target.addEventListener("pointermove", (event) => {
    const at = place(event);
    const before = fingers.get(event.pointerId);
    if (!before) return hand.hover(...at);
    if (mode === "pinch") pinch(event.pointerId, before, at);
    fingers.set(event.pointerId, at);
    if (Math.hypot(at[0] - begin[0], at[1] - begin[1]) > kClick) dragged = true;
    if (mode === "stroke") return hand.stroke("move", ...at);
    if (!dragged) return;
    if (mode === "pan") camera.pan(at[0] - before[0], at[1] - before[1]);
    if (mode === "rotate") camera.rotate((before[0] - at[0]) / 200);
    hand.moved();
  });

  const pinch = (id: number, before: [number, number], at: [number, number]): void => {
    const other = [...fingers].find(([key]) => key !== id)?.[1];
    if (!other) return;
    const was = [before[0] - other[0], before[1] - other[1]] as const;
    const is = [at[0] - other[0], at[1] - other[1]] as const;
    camera.pan((at[0] - before[0]) / 2, (at[1] - before[1]) / 2);
    const middle: [number, number] = [(at[0] + other[0]) / 2, (at[1] + other[1]) / 2];
    camera.zoom(Math.hypot(...is) / Math.max(1, Math.hypot(...was)), ...middle);
    camera.rotate(Math.atan2(-is[1], is[0]) - Math.atan2(-was[1], was[0]), ...middle);
    hand.moved();
  };

  const up = (event: PointerEvent): void => {
    const at = place(event);
    if (!fingers.delete(event.pointerId)) return;
    if (mode === "stroke") hand.stroke(event.type === "pointercancel" ? "cancel" : "end", ...at);
    else if (!dragged && event.type === "pointerup" && event.button === 0) {
      const now = performance.now();
      const near = Math.hypot(at[0] - lastPlace[0], at[1] - lastPlace[1]) < kClick;
      hand.click(...at, near && now - lastClick < kDouble);
      lastClick = now;
      lastPlace = at;
    }
    if (fingers.size === 0) mode = "none";
  };
  target.addEventListener("pointerup", up);
  target.addEventListener("pointercancel", up);
  target.addEventListener("contextmenu", (event) => event.preventDefault());
  target.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 20 : 1;
      camera.zoom(Math.exp(-event.deltaY * lines * (event.ctrlKey ? 0.01 : 0.0016)), ...place(event));
      hand.moved();
    },
    { passive: false },
  );
}
