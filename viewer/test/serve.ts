// SPDX-License-Identifier: Apache-2.0
// node build/test/serve.js [stream.mcap] [port]: the page on a stream of a file, or on the made-up rooms.
import { readFileSync } from "node:fs";
import { startServer } from "./server.js";
import { roomsStream } from "./stream.js";

const file = process.argv[2];
const server = await startServer(file ? new Uint8Array(readFileSync(file)) : roomsStream(), "dist", Number(process.argv[3] ?? 8070));
console.log(server.url);
