// SPDX-License-Identifier: Apache-2.0
// What tests may ask the page: window.majak.
import type { Session } from "./session.js";
import type { MapView } from "./view/map_view.js";

export interface Hooks {
  session: Session;
  map: MapView;
  frame(now: number, painted: boolean): void;
  counts(): Record<string, number>;
  fps(): number; ///< of the last 60 frames of the page's loop
  latency(): number; ///< ms: median from a live scan's stamp to the frame that shows it; NaN: none seen
  resetLatency(): void;
  reset(): void; ///< everything that a person may have changed on the page, as at the start
}

const kFrames = 60;
const kLatencies = 1000;

export function makeHooks(session: Session, map: MapView, resetPanels: () => void): Hooks {
  const times: number[] = [];
  let latencies: number[] = [];
  let newest = -1;
  return {
    session,
    map,
    frame(now, painted) {
      times.push(now);
      if (times.length > kFrames + 1) times.shift();
      const shown = map.layers.scanDrawn;
      if (!painted || shown <= newest || shown !== session.model.newestScan) return;
      newest = shown;
      latencies.push(Date.now() - Number(session.model.newestStamp / 1000n) / 1000);
      if (latencies.length > kLatencies) latencies.shift();
    },
    counts() {
      const { model } = session;
      return {
        scans: model.scans.count, beams: model.scans.beams, estimates: model.estimates.size, closures: model.closures.length, edits: model.edits.edits.length, landmarks: model.landmarks.length,
        particles: (model.particles?.poses.length ?? 0) / 3, hypotheses: model.hypotheses.length, points: map.layers.points.count, refused: model.refused, frames: map.frames, scanBytes: model.scans.bytes(),
      };
    },
    fps() {
      const first = times[0];
      const last = times[times.length - 1];
      return first !== undefined && last !== undefined && last > first ? (1000 * (times.length - 1)) / (last - first) : 0;
    },
    latency() {
      const sorted = [...latencies].sort((a, b) => a - b);
      return sorted[Math.floor(sorted.length / 2)] ?? NaN;
    },
    resetLatency() {
      latencies = [];
    },
    reset() {
      session.reset();
      map.hand.reset();
      map.layers.reset();
      map.camera.rotation = 0;
      map.fit();
      resetPanels();
    },
  };
}
