// SPDX-License-Identifier: Apache-2.0
// 10^6 returns of a made-up building (walls of rooms, 5 mm of noise), and the walk of the view over them.
export const count = Number(new URLSearchParams(location.search).get("points") ?? 1e6);

export function points() {
  let state = 1;
  const random = () => ((state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 4294967296);
  const xy = new Float32Array(2 * count);
  for (let i = 0; i < count; ++i) {
    const room = Math.floor(random() * 60);
    const x0 = (room % 10) * 6;
    const y0 = Math.floor(room / 10) * 5;
    const t = random();
    const side = Math.floor(random() * 4);
    xy[2 * i] = x0 + (side === 0 ? 6 * t : side === 1 ? 6 : side === 2 ? 6 * t : 0) + 0.01 * (random() - 0.5);
    xy[2 * i + 1] = y0 + (side === 0 ? 0 : side === 1 ? 5 * t : side === 2 ? 5 : 5 * t) + 0.01 * (random() - 0.5);
  }
  return xy;
}

/// Centre in metres and pixels per metre at frame n: pan over the building, zoom from all of it to a room.
export function view(n) {
  return { x: 30 + 15 * Math.sin(n / 15), y: 15 + 8 * Math.cos(n / 20), scale: 20 * Math.pow(8, 0.5 - 0.5 * Math.cos(n / 30)) };
}

const next = () => new Promise((done) => requestAnimationFrame(done));

/// Draws `draw(view)` in every frame for some seconds; leaves the figures in window.result.
export async function measure(draw) {
  draw(view(0));
  await next();
  await next();
  const first = performance.now();
  for (let n = 0; n < 10; ++n) { draw(view(n)); await next(); }
  const times = [];
  window.started = true;
  let last = performance.now();
  const end = last + 6000;
  for (let n = 0; last < end; ++n) {
    draw(view(n));
    await next();
    const now = performance.now();
    times.push(now - last);
    last = now;
  }
  times.sort((a, b) => a - b);
  const mean = times.reduce((a, b) => a + b, 0) / times.length;
  window.result = { first_ms: Math.round(first), frames: times.length, fps: +(1000 / mean).toFixed(1), worst_ms: Math.round(times[Math.floor(times.length * 0.95)]), heap_mb: Math.round(performance.memory.usedJSHeapSize / 1e6) };
}
