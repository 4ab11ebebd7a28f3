// SPDX-License-Identifier: Apache-2.0
// Which part of the map the view shows. Pixels are those of the page, y down; metres have y up.

export const kSmallestScale = 0.2; // px/m
export const kLargestScale = 4000;

export class Camera {
  x = 0; ///< m, in the middle of the view
  y = 0;
  scale = 20; ///< px/m
  rotation = 0; ///< rad: how far the map is turned to the left
  width = 1; ///< px
  height = 1;

  toPixels(x: number, y: number): [number, number] {
    const c = Math.cos(this.rotation) * this.scale;
    const s = Math.sin(this.rotation) * this.scale;
    const dx = x - this.x;
    const dy = y - this.y;
    return [this.width / 2 + c * dx - s * dy, this.height / 2 - (s * dx + c * dy)];
  }

  toMetres(px: number, py: number): [number, number] {
    const c = Math.cos(this.rotation) / this.scale;
    const s = Math.sin(this.rotation) / this.scale;
    const dx = px - this.width / 2;
    const dy = this.height / 2 - py;
    return [this.x + c * dx + s * dy, this.y - s * dx + c * dy];
  }

  /// Metres -> -1 ... 1, column by column.
  clipMatrix(): number[] {
    const cx = (2 * Math.cos(this.rotation) * this.scale) / this.width;
    const sx = (2 * Math.sin(this.rotation) * this.scale) / this.width;
    const cy = (2 * Math.cos(this.rotation) * this.scale) / this.height;
    const sy = (2 * Math.sin(this.rotation) * this.scale) / this.height;
    return [cx, sy, 0, -sx, cy, 0, -cx * this.x + sx * this.y, -sy * this.x - cy * this.y, 1];
  }

  pan(dx: number, dy: number): void {
    const [x0, y0] = this.toMetres(0, 0);
    const [x1, y1] = this.toMetres(dx, dy);
    this.x -= x1 - x0;
    this.y -= y1 - y0;
  }

  /// What lies under that pixel stays there.
  zoom(factor: number, px = this.width / 2, py = this.height / 2): void {
    const [x, y] = this.toMetres(px, py);
    this.scale = Math.min(kLargestScale, Math.max(kSmallestScale, this.scale * factor));
    this.hold(x, y, px, py);
  }

  rotate(angle: number, px = this.width / 2, py = this.height / 2): void {
    const [x, y] = this.toMetres(px, py);
    this.rotation = Math.atan2(Math.sin(this.rotation + angle), Math.cos(this.rotation + angle));
    this.hold(x, y, px, py);
  }

  /// All of a box in m, clear of the view's edges by so many pixels: left, right, above and below.
  fit(x0: number, y0: number, x1: number, y1: number, left = 40, right = 40, high = 40): void {
    const c = Math.abs(Math.cos(this.rotation));
    const s = Math.abs(Math.sin(this.rotation));
    const wide = c * (x1 - x0) + s * (y1 - y0);
    const tall = s * (x1 - x0) + c * (y1 - y0);
    this.x = (x0 + x1) / 2;
    this.y = (y0 + y1) / 2;
    const scale = Math.min(Math.max(40, this.width - left - right) / Math.max(wide, 0.5), Math.max(40, this.height - 2 * high) / Math.max(tall, 0.5));
    this.scale = Math.min(kLargestScale, Math.max(kSmallestScale, scale));
    this.pan((left - right) / 2, 0);
  }

  private hold(x: number, y: number, px: number, py: number): void {
    const [nowX, nowY] = this.toMetres(px, py);
    this.x += x - nowX;
    this.y += y - nowY;
  }
}

/// A round length (1, 2, 5 x 10^n m) of at least so many pixels.
export function roundLength(scale: number, pixels: number): number {
  const raw = pixels / scale;
  const power = 10 ** Math.floor(Math.log10(raw));
  const lead = raw / power;
  return power * (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 5 ? 5 : 10);
}
