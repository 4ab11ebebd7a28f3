// SPDX-License-Identifier: Apache-2.0
// Day or night: what the person chose last here, or else what the system wants.

const kName = "majak.night";

export function rememberedNight(): boolean {
  try {
    const chosen = localStorage.getItem(kName);
    if (chosen !== null) return chosen === "true";
  } catch {
    // Pages from files may have no storage.
  }
  return window.matchMedia("(prefers-color-scheme: dark)").matches;
}

export function rememberNight(night: boolean): void {
  try {
    localStorage.setItem(kName, String(night));
  } catch {
    // Then it holds until the page is closed.
  }
}
