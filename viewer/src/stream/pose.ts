// SPDX-License-Identifier: Apache-2.0
// Poses in the plane: x, y in m, theta in rad; compose(T_a_b, T_b_c) = T_a_c.

export type Pose = readonly [x: number, y: number, theta: number];
/// xx xy xt yy yt tt
export type Covariance = readonly [number, number, number, number, number, number];

export function compose(a: Pose, b: Pose): Pose {
  const c = Math.cos(a[2]);
  const s = Math.sin(a[2]);
  return [a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], wrap(a[2] + b[2])];
}

export function inverse(a: Pose): Pose {
  const c = Math.cos(a[2]);
  const s = Math.sin(a[2]);
  return [-c * a[0] - s * a[1], s * a[0] - c * a[1], wrap(-a[2])];
}

/// Into (-pi, pi].
export function wrap(angle: number): number {
  const turn = 2 * Math.PI;
  const out = angle - turn * Math.round(angle / turn);
  return out <= -Math.PI ? out + turn : out;
}

/// Half axes and direction of the ellipse of one sigma of xx, xy, yy.
export function ellipse(xx: number, xy: number, yy: number): { major: number; minor: number; angle: number } {
  const mean = (xx + yy) / 2;
  const half = Math.hypot((xx - yy) / 2, xy);
  return { major: Math.sqrt(Math.max(0, mean + half)), minor: Math.sqrt(Math.max(0, mean - half)), angle: 0.5 * Math.atan2(2 * xy, xx - yy) };
}
