// SPDX-License-Identifier: Apache-2.0
// node build/e2e/run.js [URL]: all topics against the page at that address, or against a server of its own.
import { startAll } from "./harness.js";

startAll();
await import("./picture.js");
await import("./layers.js");
await import("./moving.js");
await import("./measure.js");
await import("./timeline.js");
await import("./charts.js");
await import("./pose.js");
await import("./closures.js");
await import("./edits.js");
await import("./localize.js");
await import("./theme.js");
await import("./connection.js");
await import("./report.js");
await import("./access.js");
