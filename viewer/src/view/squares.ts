// SPDX-License-Identifier: Apache-2.0
// Which squares of the map the view shows, and how fine they must be.
import type { Camera } from "./camera.js";

export const kFinest = 0.01; // m a cell

/// Fineness 0: 1 cm a cell, each next one twice as coarse.
export function levelFor(scale: number): number {
  return Math.max(0, Math.floor(Math.log2(1 / (scale * kFinest))));
}

/// Squares that the view shows.
export function visible(camera: Camera, side: number): [number, number][] {
  const corners = [camera.toMetres(0, 0), camera.toMetres(camera.width, 0), camera.toMetres(0, camera.height), camera.toMetres(camera.width, camera.height)];
  const xs = corners.map((corner) => corner[0]);
  const ys = corners.map((corner) => corner[1]);
  const out: [number, number][] = [];
  for (let i = Math.floor(Math.min(...xs) / side); i <= Math.floor(Math.max(...xs) / side); ++i)
    for (let j = Math.floor(Math.min(...ys) / side); j <= Math.floor(Math.max(...ys) / side); ++j) out.push([i, j]);
  return out;
}
