// SPDX-License-Identifier: Apache-2.0
// deck.gl: one PointCloudLayer with binary attributes.
import { Deck, OrthographicView } from "@deck.gl/core";
import { PointCloudLayer } from "@deck.gl/layers";
import { measure, points } from "./points.js";

const xy = points();
const xyz = new Float32Array(xy.length / 2 * 3).map((_, i) => (i % 3 === 2 ? 0 : xy[Math.floor(i / 3) * 2 + (i % 3)]));
const layer = new PointCloudLayer({
  id: "points",
  data: { length: xy.length / 2, attributes: { getPosition: { value: xyz, size: 3 } } },
  pointSize: 1, sizeUnits: "pixels", getColor: [26, 51, 128], material: false,
});
const state = (v) => ({ target: [v.x, v.y, 0], zoom: Math.log2(v.scale) });
const deck = new Deck({
  parent: document.body,
  width: innerWidth,
  height: innerHeight,
  useDevicePixels: false,
  views: new OrthographicView({ flipY: false }),
  viewState: state({ x: 30, y: 15, scale: 20 }),
  layers: [layer],
  onLoad: () => measure((v) => { deck.setProps({ viewState: state(v) }); deck.redraw("bench"); }),
});
