// SPDX-License-Identifier: Apache-2.0
// A simple polygon as triangles, by cutting ears; crossing polygons come out as well as they can.

export type Point = [number, number];

const turn = (a: Point, b: Point, c: Point): number => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);

/// Twice the area, positive when it turns to the left.
export function area2(points: readonly Point[]): number {
  let sum = 0;
  points.forEach(([x, y], i) => {
    const [nextX, nextY] = points[(i + 1) % points.length] ?? [0, 0];
    sum += x * nextY - nextX * y;
  });
  return sum;
}

/// Corners, three a triangle.
export function triangulate(points: readonly Point[]): Point[] {
  const left = area2(points) < 0 ? [...points].reverse() : [...points];
  const out: Point[] = [];
  while (left.length > 3) {
    const i = ear(left);
    const n = left.length;
    out.push(left[(i + n - 1) % n] as Point, left[i] as Point, left[(i + 1) % n] as Point);
    left.splice(i, 1);
  }
  if (left.length === 3) out.push(...left);
  return out;
}

function ear(points: Point[]): number {
  const n = points.length;
  for (let i = 0; i < n; ++i) {
    const a = points[(i + n - 1) % n] as Point;
    const b = points[i] as Point;
    const c = points[(i + 1) % n] as Point;
    if (turn(a, b, c) <= 0) continue;
    const inside = points.some((p) => p !== a && p !== b && p !== c && turn(a, b, p) > 0 && turn(b, c, p) > 0 && turn(c, a, p) > 0);
    if (!inside) return i;
  }
  return 0;
}
