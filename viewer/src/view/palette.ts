// SPDX-License-Identifier: Apache-2.0
// The colours of the map by day and by night; those of the panels stand in style.css.

export interface Palette {
  background: string;
  free: string;
  occupied: string;
  raster: string;
  points: string;
  pointsMany: string;
  scan: string;
  match: string;
  trail: string;
  degraded: string;
  lost: string;
  odometry: string;
  frontEnd: string;
  truth: string;
  graph: string;
  closure: string;
  closureOff: string;
  landmark: string;
  covariance: string;
  particle: string;
  segment: string;
  erase: string;
  wall: string;
  forbidden: string;
  crop: string;
  robot: string;
  measure: string;
}

export const kDay: Palette = {
  background: "#eceae4",
  free: "#ffffff",
  occupied: "#1d242c",
  raster: "#5b6673",
  points: "#3a87b5",
  pointsMany: "#0a2d44",
  scan: "#d9432a",
  match: "#b0208a",
  trail: "#2b68d8",
  degraded: "#d28a00",
  lost: "#d12c3f",
  odometry: "#a3855a",
  frontEnd: "#8457cf",
  truth: "#1f9360",
  graph: "#7d8fa3",
  closure: "#e08a00",
  closureOff: "#c23b4e",
  landmark: "#087f8c",
  covariance: "#2b68d8",
  particle: "#b0208a",
  segment: "#0a7c70",
  erase: "#c23b4e",
  wall: "#1d242c",
  forbidden: "#c23b4e",
  crop: "#2b68d8",
  robot: "#123f8f",
  measure: "#b3236b",
};

export const kNight: Palette = {
  background: "#12161b",
  free: "#1f262e",
  occupied: "#d9e0e8",
  raster: "#8896a5",
  points: "#4fa9cf",
  pointsMany: "#d6f3ff",
  scan: "#ff7a59",
  match: "#f078cf",
  trail: "#6aa2ff",
  degraded: "#f3b63f",
  lost: "#ff6b78",
  odometry: "#c9a878",
  frontEnd: "#b795f5",
  truth: "#4fd39a",
  graph: "#7f93a8",
  closure: "#f5b041",
  closureOff: "#ff7f8e",
  landmark: "#4cc9d6",
  covariance: "#6aa2ff",
  particle: "#f078cf",
  segment: "#3fcdbb",
  erase: "#ff7f8e",
  wall: "#f2f5f8",
  forbidden: "#ff7f8e",
  crop: "#6aa2ff",
  robot: "#bcd6ff",
  measure: "#ff8cc0",
};
