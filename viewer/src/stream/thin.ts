// SPDX-License-Identifier: Apache-2.0
// Fewer points for a chart: of each piece of the range its lowest and its highest value stay.

export function thinMinMax(x: ArrayLike<number>, y: ArrayLike<number>, from: number, to: number, most: number): { x: number[]; y: (number | null)[] } {
  const outX: number[] = [];
  const outY: (number | null)[] = [];
  const put = (i: number): void => {
    const value = y[i] ?? NaN;
    outX.push(x[i] ?? 0);
    outY.push(Number.isFinite(value) ? value : null);
  };
  if (to - from <= most) {
    for (let i = from; i < to; ++i) put(i);
    return { x: outX, y: outY };
  }
  const pieces = Math.max(1, Math.floor(most / 2));
  for (let piece = 0; piece < pieces; ++piece) {
    const begin = from + Math.floor(((to - from) * piece) / pieces);
    const end = from + Math.floor(((to - from) * (piece + 1)) / pieces);
    let low = -1;
    let high = -1;
    for (let i = begin; i < end; ++i) {
      const value = y[i] ?? NaN;
      if (!Number.isFinite(value)) continue;
      if (low < 0 || value < (y[low] ?? 0)) low = i;
      if (high < 0 || value > (y[high] ?? 0)) high = i;
    }
    if (low < 0) put(begin);
    else if (low === high) put(low);
    else {
      put(Math.min(low, high));
      put(Math.max(low, high));
    }
  }
  return { x: outX, y: outY };
}
