// SPDX-License-Identifier: Apache-2.0
// Puts the page together: stream -> model -> map, timeline, panels; one loop draws what changed.
import { element, setAttribute } from "./dom.js";
import { makeHooks, type Hooks } from "./hooks.js";
import { appKeys } from "./app_keys.js";
import { Charts } from "./panels/charts.js";
import { Head } from "./panels/head.js";
import { helpDialog, listen } from "./panels/keys.js";
import { LayerList } from "./panels/layer_list.js";
import { MapTools } from "./panels/map_tools.js";
import { Side } from "./panels/side.js";
import { Timeline } from "./panels/timeline.js";
import { Session } from "./session.js";
import { Commands } from "./stream/commands.js";
import { McapReader } from "./stream/mcap.js";
import { type Source, connect, decodeEmbedded } from "./stream/source.js";
import { rememberedNight, rememberNight } from "./theme.js";
import { MapView } from "./view/map_view.js";

export interface Viewer {
  hooks: Hooks;
}

const kWordsEvery = 100; // ms
const kNarrow = 760; // px; as in style.css

/// The page in `place`, which gives the size. Without data in the document it connects to the server it came from.
export async function mount(place: HTMLElement): Promise<Viewer | undefined> {
  try {
    return await assemble(place);
  } catch (error) {
    const why = error instanceof Error ? error.message : String(error);
    place.append(element("p", { class: "majak-sorry", role: "alert" }, `The map cannot be shown here: ${why}. It needs WebGL and a browser of 2023 or later.`));
    return undefined;
  }
}

async function assemble(place: HTMLElement): Promise<Viewer> {
  let source: Source | undefined;
  const commands = new Commands((text) => source?.send(text) ?? false, (command) => {
    head.tell(command);
    session.touch();
  });
  const session = new Session(commands);
  session.night = rememberedNight();
  const map = await MapView.create(session);
  const timeline = new Timeline(session);
  const layers = new LayerList(session, map.layers);
  const tools = new MapTools(session, map);
  const charts = new Charts(session);
  const side = new Side(session, map);
  const theme = (): void => {
    session.night = !session.night;
    rememberNight(session.night);
    session.touch();
  };
  const show = (part: HTMLElement, which: HTMLButtonElement) => (): void => {
    part.hidden = !part.hidden;
    setAttribute(which, "aria-pressed", String(!part.hidden));
    session.touch();
  };
  const head: Head = new Head(session, { theme, charts: () => showCharts(), side: () => showSide(), help: () => help.showModal(), retry: () => source?.retry() });
  const showCharts = show(charts.element, head.charts);
  const showSide = show(side.element, head.side);
  const keys = appKeys({ session, map, tools, side, theme, showCharts, showSide, help: () => help.showModal() });
  const help = helpDialog(keys);

  const root = element("div", { class: "majak", role: "region", "aria-label": "Map viewer" });
  map.element.append(layers.element, tools.element, tools.hint);
  root.append(head.element, head.banner, map.element, element("div", { class: "foot" }, charts.element, timeline.element), side.element, help);
  place.append(root);
  if (place.clientWidth < kNarrow) showSide();
  listen(root, place.parentElement === document.body && document.body.classList.contains("majak-page"), keys);

  const newReader = (): McapReader => new McapReader((message) => session.model.apply(message));
  let reader = newReader();
  const data = document.getElementById("majak-data");
  if (data) {
    reader.feed(await decodeEmbedded(data.textContent ?? ""));
    session.time = session.model.estimates.time[session.model.estimates.size - 1] ?? 0;
  } else {
    session.live = true;
    source = connect(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/stream${location.search}`, {
      bytes: (bytes) => {
        try {
          reader.feed(bytes);
        } catch (error) {
          head.say(`The stream cannot be read: ${error instanceof Error ? error.message : String(error)}.`, true);
        }
      },
      text: (text) => commands.answer(text),
      restart: () => {
        session.model.forget();
        reader = newReader();
      },
      link: (link, retryAt) => {
        session.link = link;
        if (link !== "connecting") session.retryAt = retryAt;
        if (link === "lost") commands.linkLost();
        session.touch();
      },
    });
  }

  const hooks = makeHooks(session, map, () => {
    side.show(0);
    charts.zoom(undefined);
  });
  let last = performance.now();
  let wordsAt = 0;
  const loop = (now: number): void => {
    requestAnimationFrame(loop); // first: whatever goes wrong in one frame, there is a next
    session.advance(Math.min(0.5, (now - last) / 1000));
    last = now;
    setAttribute(root, "data-theme", session.night ? "night" : "day");
    const painted = map.frame();
    timeline.follow();
    charts.follow();
    // Words are laid out and painted anew: ten times a second while time runs, at once when a person does something.
    if (now - wordsAt > kWordsEvery || !(session.playing || session.live)) {
      wordsAt = now;
      for (const part of [head, tools, layers, timeline, charts, side]) part.frame();
    }
    hooks.frame(now, painted);
  };
  requestAnimationFrame(loop);
  window.majak = hooks;
  return { hooks };
}
