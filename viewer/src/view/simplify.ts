// SPDX-License-Identifier: Apache-2.0
// Fewer poses of a path, so that what is drawn looks the same.

const kMostBetween = 64; // poses that one piece may replace

/// Rows to be joined by straight pieces: none of the poses left out lies farther than `bend` from its piece, no piece
/// is longer than `longest` (m) unless the path itself jumps, and none spans a change of colour.
export function fewerPoses(poses: Float64Array, size: number, bend: number, longest: number, colourOf: (row: number) => number): number[] {
  const rows: number[] = [];
  const x = (row: number): number => poses[3 * row] ?? NaN;
  const y = (row: number): number => poses[3 * row + 1] ?? NaN;
  let last = -1; // row of `rows`
  let before = -1; // last row seen
  for (let row = 0; row < size; ++row) {
    if (!Number.isFinite(x(row))) continue;
    if (last < 0) {
      rows.push(row);
      last = row;
    } else if (before > last && !fits(last, row)) {
      rows.push(before);
      last = before;
    }
    before = row;
  }
  if (before > last) rows.push(before);
  return rows;

  function fits(from: number, to: number): boolean {
    if (to - from > kMostBetween || colourOf(to) !== colourOf(from + 1)) return false;
    const dx = x(to) - x(from);
    const dy = y(to) - y(from);
    const long = Math.hypot(dx, dy);
    if (long > longest) return false;
    for (let row = from + 1; row < to; ++row) {
      const px = x(row) - x(from);
      const py = y(row) - y(from);
      // Beside the piece, or beyond one of its ends.
      const along = long > 0 ? (px * dx + py * dy) / long : 0;
      const beside = long > 0 ? Math.abs(px * dy - py * dx) / long : Math.hypot(px, py);
      if (beside > bend || along < -bend || along > long + bend) return false;
    }
    return true;
  }
}
