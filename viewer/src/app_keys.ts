// SPDX-License-Identifier: Apache-2.0
// What each key does.
import { type Key, plain } from "./panels/keys.js";
import type { MapTools } from "./panels/map_tools.js";
import type { Side } from "./panels/side.js";
import { type Session, kSpeeds } from "./session.js";
import type { MapView } from "./view/map_view.js";

export interface KeyTargets {
  session: Session;
  map: MapView;
  tools: MapTools;
  side: Side;
  theme(): void;
  showCharts(): void;
  showSide(): void;
  help(): void;
}

const kTurn = Math.PI / 36;
const kMove = 80; // px

export function appKeys({ session, map, tools, side, theme, showCharts, showSide, help }: KeyTargets): Key[] {
  const zoom = (factor: number) => (): void => map.zoom(factor);
  const turn = (angle: number) => (): void => map.rotate(angle);
  const faster = (by: number) => (): void => {
    const at = (kSpeeds as readonly number[]).indexOf(session.speed) + by;
    session.speed = kSpeeds[Math.min(kSpeeds.length - 1, Math.max(0, at))] ?? 1;
    session.touch();
  };
  const control = (key: string, shift: boolean, shown: string, does: string, run: () => void): Key => ({ shown, does, run, matches: (event) => (event.ctrlKey || event.metaKey) && event.key.toLowerCase() === key && event.shiftKey === shift });
  const move = (dx: number, dy: number) => (): void => {
    map.camera.pan(dx, dy);
    map.moved();
  };
  const moves = (key: string, shown: string, does: string, dx: number, dy: number): Key => ({ shown, does, run: move(dx, dy), matches: (event) => event.shiftKey && event.key === key });
  return [
    plain(" ", "space", "play, pause", () => session.play(!session.playing)),
    moves("ArrowLeft", "shift \u2190 \u2192 \u2191 \u2193", "move the map", kMove, 0),
    moves("ArrowRight", "", "", -kMove, 0),
    moves("ArrowUp", "", "", 0, kMove),
    moves("ArrowDown", "", "", 0, -kMove),
    plain("arrowleft", "\u2190 \u2192", "one scan back, on", () => session.step(-1)),
    plain("arrowright", "", "", () => session.step(1)),
    plain("+", "+ \u2212", "zoom", zoom(1.25)),
    plain("=", "", "", zoom(1.25)),
    plain("-", "", "", zoom(1 / 1.25)),
    plain(",", ", .", "slower, faster", faster(-1)),
    plain(".", "", "", faster(1)),
    plain("q", "Q E", "turn the map", turn(kTurn)),
    plain("e", "", "", turn(-kTurn)),
    plain("a", "A", "show all", () => void map.fit()),
    plain("0", "0", "north up", () => tools.northUp()),
    plain("f", "F", "follow the robot", () => tools.toggleFollow()),
    plain("m", "M", "measure", () => tools.toggleMeasure()),
    plain("l", "L", "stay at the newest", () => {
      session.live = true;
      session.touch();
    }),
    plain("n", "N", "day, night", theme),
    plain("c", "C", "charts", showCharts),
    plain("p", "P", "side panel", showSide),
    { shown: "shift Enter", does: "close what is drawn", run: () => map.hand.finish(), matches: (event) => event.key === "Enter" && event.shiftKey },
    plain("enter", "Enter", "use the tool in the middle; close what is drawn", () => (map.hand.drawnByMouse() ? map.hand.finish() : map.clickMiddle())),
    plain("backspace", "\u232b", "take the last point back", () => map.hand.back()),
    plain("escape", "Esc", "put the tool away", () => map.hand.cancel()),
    control("z", false, "ctrl Z", "undo", () => side.edit.undo()),
    control("z", true, "ctrl shift Z", "redo", () => side.edit.redo()),
    plain("?", "?", "this page", help),
  ];
}
