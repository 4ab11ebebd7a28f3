// SPDX-License-Identifier: Apache-2.0
// Stands in for `majak view` in tests: serves dist and a stream, answers commands as the program would.
//   node build/test/serve.js [stream.mcap] [port]
import { createServer } from "node:http";
import { existsSync, readFileSync } from "node:fs";
import { join, normalize } from "node:path";
import { type WebSocket, WebSocketServer } from "ws";
import { McapReader } from "../src/stream/mcap.js";
import type { Closure, Edit } from "../src/stream/records.js";
import { StreamWriter } from "./stream.js";

export interface TestServer {
  url: string;
  port: number;
  received: Record<string, unknown>[]; ///< commands
  clients(): number;
  send(bytes: Uint8Array): void;
  answerAfter: number; ///< ms; negative: never
  dropAll(): void; ///< breaks all connections
  refuse: string; ///< if any: the error of the next replies
  stop(): Promise<void>;
}

const kTypes: Record<string, string> = { html: "text/html; charset=utf-8", js: "text/javascript", css: "text/css" };
const kFrame = 1 << 18;

interface State {
  closures: Closure[];
  edits: Edit[];
  done: (() => void)[]; ///< how to take it back
  undone: (() => void)[];
  nextId: number;
}

function stateOf(stream: Uint8Array): State {
  const state: State = { closures: [], edits: [], done: [], undone: [], nextId: 1 };
  const reader = new McapReader(({ topic, data }) => {
    if (topic === "/closures") state.closures = JSON.parse(new TextDecoder().decode(data)) as Closure[];
  });
  reader.feed(stream);
  return state;
}

/// What a command does to the state; an error in words, or "".
function obey(state: State, command: Record<string, unknown>): string {
  const change = (forward: () => void, back: () => void): void => {
    forward();
    state.done.push(() => {
      back();
      state.undone.push(() => change(forward, back));
    });
    state.undone = [];
  };
  if (command["do"] === "switch_closure") {
    const closure = state.closures.find((one) => one.from === command["from"] && one.to === command["to"]);
    if (!closure) return "there is no such closure";
    const was = closure.enabled;
    change(() => Object.assign(closure, { enabled: command["on"] === true, by_hand: true }), () => Object.assign(closure, { enabled: was, by_hand: false }));
  } else if (command["do"] === "edit") {
    const edit = { ...(command["edit"] as Edit), id: state.nextId++ };
    change(() => state.edits.push(edit), () => state.edits.splice(state.edits.indexOf(edit), 1));
  } else if (command["do"] === "undo") {
    const back = state.done.pop();
    if (!back) return "there is nothing to undo";
    back();
  } else if (command["do"] === "redo") {
    const undone = state.undone;
    const again = undone.pop();
    if (!again) return "there is nothing to redo";
    again();
    state.undone = undone;
  }
  return "";
}

export async function startServer(stream: Uint8Array, dist: string, port = 0): Promise<TestServer> {
  const state = stateOf(stream);
  const sockets = new Set<WebSocket>();
  const http = createServer((request, response) => {
    const name = normalize((request.url ?? "/").split("?")[0] ?? "/");
    const file = join(dist, name === "/" ? "index.html" : name);
    if (!existsSync(file)) return response.writeHead(404).end();
    response.setHeader("content-type", kTypes[file.split(".").pop() ?? ""] ?? "application/octet-stream");
    // What the program sends as well: the page may not need more.
    response.setHeader("content-security-policy", "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'");
    response.end(readFileSync(file));
  });
  const server: TestServer = {
    url: "", port: 0, received: [], answerAfter: 0, refuse: "",
    clients: () => sockets.size,
    send: (bytes) => sockets.forEach((socket) => socket.send(bytes)),
    dropAll: () => sockets.forEach((socket) => socket.terminate()),
    stop: () => new Promise((done) => {
      sockets.forEach((socket) => socket.terminate());
      http.closeAllConnections();
      http.close(() => done());
    }),
  };
  new WebSocketServer({ server: http, path: "/stream" }).on("connection", (socket) => {
    sockets.add(socket);
    socket.on("close", () => sockets.delete(socket));
    for (let at = 0; at < stream.length; at += kFrame) socket.send(stream.subarray(at, at + kFrame));
    // A new client needs the channels as well.
    const own = new StreamWriter(900);
    const news = (which: StreamWriter): Uint8Array[] => [which.json("/closures", state.closures), which.json("/edits", { edits: state.edits, can_undo: state.done.length > 0, can_redo: state.undone.length > 0, saved: true })];
    for (const bytes of news(own)) socket.send(bytes);
    socket.on("message", (data, binary) => {
      if (binary) return;
      const command = JSON.parse(String(data)) as Record<string, unknown>;
      server.received.push(command);
      if (server.answerAfter < 0) return;
      setTimeout(() => {
        const error = server.refuse || obey(state, command);
        if (error === "") for (const bytes of news(new StreamWriter(900))) server.send(bytes);
        socket.send(JSON.stringify(error === "" ? { id: command["id"], ok: true } : { id: command["id"], ok: false, error }));
      }, server.answerAfter);
    });
  });
  await new Promise<void>((done) => http.listen(port, "127.0.0.1", done));
  const address = http.address();
  server.port = typeof address === "object" && address ? address.port : 0;
  server.url = `http://127.0.0.1:${server.port}/`;
  return server;
}
