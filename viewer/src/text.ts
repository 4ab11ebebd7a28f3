// SPDX-License-Identifier: Apache-2.0
// Numbers as people read them.

export const kDegree = Math.PI / 180;
const kMinus = "\u2212";

export function fixed(value: number, digits: number): string {
  if (!Number.isFinite(value)) return "\u2013";
  const text = value.toFixed(digits);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", kMinus);
}

export function metres(value: number, digits = 2): string {
  return `${fixed(value, digits)} m`;
}

export function degrees(radians: number, digits = 1): string {
  return `${fixed(radians / kDegree, digits)}\u00b0`;
}

/// A small length in the unit that suits it.
export function smallLength(value: number): string {
  if (!Number.isFinite(value)) return "\u2013";
  return value < 0.1 ? `${fixed(1000 * value, 1)} mm` : metres(value);
}

/// 1:02:03.4
export function duration(seconds: number, digits = 1): string {
  const tenth = 10 ** digits;
  const whole = Math.round(Math.max(0, seconds) * tenth) / tenth;
  const hours = Math.floor(whole / 3600);
  const minutes = Math.floor((whole % 3600) / 60);
  const rest = (whole % 60).toFixed(digits).padStart(digits > 0 ? 3 + digits : 2, "0");
  return hours > 0 ? `${hours}:${String(minutes).padStart(2, "0")}:${rest}` : `${minutes}:${rest}`;
}

export function clock(seconds: number): string {
  return new Date(1000 * seconds).toISOString().replace("T", " ").replace("Z", "");
}

export function count(value: number): string {
  return String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, "\u202f");
}
