// SPDX-License-Identifier: Apache-2.0
// deck.gl: one ScatterplotLayer with binary attributes.
import { Deck, OrthographicView } from "@deck.gl/core";
import { ScatterplotLayer } from "@deck.gl/layers";
import { measure, points } from "./points.js";

const xy = points();

const layer = new ScatterplotLayer({
  id: "points",
  data: { length: xy.length / 2, attributes: { getPosition: { value: xy, size: 2 } } },
  getRadius: 1, radiusUnits: "pixels", getFillColor: [26, 51, 128], antialiasing: false,
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
