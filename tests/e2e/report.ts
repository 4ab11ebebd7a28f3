// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { roomsStream } from "../../viewer/test/stream.js";
import { address, count, open, openTab, picture, shots } from "./harness.js";

const kReport = (css: string, js: string, data: string): string => `<!doctype html><html lang="en"><head><meta charset="utf-8"><title>report</title><style>${css}</style></head>
<body><h1>Report</h1><div id="here" style="height:560px"></div><h2>Below</h2><p>text</p>
<script type="application/octet-stream;base64" id="majak-data">${data}</script>
<script>${js}</script><script>majakViewer.mount(document.getElementById("here"))</script></body></html>`;

if (!address)
  test("a report from a file shows its run and connects to nobody", async () => {
    const file = join(shots, "report.html");
    const data = gzipSync(roomsStream()).toString("base64");
    writeFileSync(file, kReport(readFileSync("dist/viewer.css", "utf8"), readFileSync("dist/viewer.js", "utf8").replaceAll("</script", "<\\/script"), data));
    const asked: string[] = [];
    const page = await open({
      url: `file://${file}`,
      watch: (one) => one.on("request", (request) => asked.push(request.url())).on("websocket", (socket) => asked.push(socket.url())),
    });
    const bytes = (await picture(page)).length;
    assert.ok(bytes > 3000, `a picture of ${bytes} bytes`);
    assert.ok((await count(page, "scans")) > 400);
    assert.ok(asked.some((url) => url.startsWith("file:")));
    assert.deepEqual(asked.filter((url) => !url.startsWith("file:") && !url.startsWith("data:")), []);
    assert.equal(await page.locator(".pill").textContent(), "report");
    await openTab(page, "Edit");
    assert.ok(await page.getByRole("button", { name: "Erase a box" }).isDisabled());
    // The keys of the page belong to the viewer only while it has the focus.
    await page.keyboard.press("Escape");
    await page.evaluate(() => (document.activeElement as HTMLElement).blur());
    const was = await page.evaluate(() => window.majak!.session.night);
    await page.keyboard.press("n");
    assert.equal(await page.evaluate(() => window.majak!.session.night), was);
    await page.close();
  });
