// SPDX-License-Identifier: Apache-2.0
// The processes of one browser (found by its profile folder): memory in MB (proportional set size), processor time in ms.
import { readFileSync, readdirSync } from "node:fs";

function family(profile) {
  const parents = new Map();
  const ours = new Set();
  for (const pid of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      parents.set(pid, readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" ")[1]);
      if (readFileSync(`/proc/${pid}/cmdline`, "utf8").includes(profile)) ours.add(pid);
    } catch { /* it ended meanwhile */ }
  }
  for (let size = -1; size !== ours.size; ) {
    size = ours.size;
    for (const [pid, parent] of parents) if (ours.has(parent)) ours.add(pid);
  }
  return [...ours];
}

const sum = (profile, of) => family(profile).reduce((total, pid) => {
  try {
    return total + of(pid);
  } catch {
    return total;
  }
}, 0);

export const memory = (profile) => Math.round(sum(profile, (pid) => Number(/^Pss:\s+(\d+)/m.exec(readFileSync(`/proc/${pid}/smaps_rollup`, "utf8"))[1])) / 1024);

export const processorTime = (profile) => sum(profile, (pid) => {
  const fields = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" ");
  return 10 * (Number(fields[11]) + Number(fields[12])); // ticks of 10 ms
});
