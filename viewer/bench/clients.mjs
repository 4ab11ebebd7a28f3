// SPDX-License-Identifier: Apache-2.0
// node bench/clients.mjs MAJAK LOG CLIENTS [STALLED]: how long mapping a log takes while so many pages look on, of which some take
// nothing; seconds from the first scan to the finished map.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { WebSocket } from "ws";

const [majak, log, clients = "0", stalled = "0"] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "majak-clients-"));
const program = spawn(majak, ["map", log, "-o", folder, "--threads", "1", "--view"], { stdio: ["ignore", "pipe", "inherit"] });
let begun, text = "", bytes = 0;
program.stdout.on("data", (data) => {
  text += data;
  const url = /view: +(http:\/\/\S+)/.exec(text)?.[1];
  if (url && begun === undefined) {
    begun = performance.now();
    for (let i = 0; i < +clients; ++i) {
      const socket = new WebSocket(url.replace("http", "ws") + "stream", { origin: new URL(url).origin });
      socket.on("message", (message) => (bytes += message.length));
      socket.on("error", () => {});
      if (i < +stalled) socket.on("open", () => socket._socket.pause());
    }
  }
  if (!text.includes("scans placed")) return;
  console.log(`${clients} clients, ${stalled} stalled: ${((performance.now() - begun) / 1000).toFixed(2)} s, ${(bytes / 1e6).toFixed(0)} MB to them`);
  program.kill("SIGKILL");
  rmSync(folder, { recursive: true, force: true });
  process.exit(0);
});
