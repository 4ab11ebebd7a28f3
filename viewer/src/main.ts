// SPDX-License-Identifier: Apache-2.0
// majakViewer.mount(element): the page in an element. A script element with data-mount="ID" mounts itself.
import { type Viewer, mount } from "./app.js";

export { mount };

const script = document.currentScript;
const id = script instanceof HTMLScriptElement ? script.dataset["mount"] : undefined;
if (id) {
  const start = (): void => {
    const place = document.getElementById(id);
    if (place) void mount(place);
  };
  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", start);
  else start();
}

declare global {
  interface Window {
    majak?: Viewer["hooks"];
  }
}
