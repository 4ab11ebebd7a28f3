// SPDX-License-Identifier: Apache-2.0
// Small helpers for the page's elements.

type Child = Node | string;

/// An element with properties ("class", "aria-...", "data-..." and the like as attributes) and children.
export function element<K extends keyof HTMLElementTagNameMap>(tag: K, attributes: Record<string, string> = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const out = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) out.setAttribute(name, value);
  out.append(...children);
  return out;
}

export function button(label: string, onClick: () => void, attributes: Record<string, string> = {}): HTMLButtonElement {
  const out = element("button", { type: "button", ...attributes }, label);
  out.addEventListener("click", onClick);
  return out;
}

/// A button that shows only a sign; its name is read out and shown as a hint.
export function iconButton(icon: string, name: string, onClick: () => void, attributes: Record<string, string> = {}): HTMLButtonElement {
  const out = button("", onClick, { "aria-label": name, title: name, class: "icon", ...attributes });
  out.innerHTML = svg(icon);
  return out;
}

/// Sets text only when it is another one: the page is not laid out anew for nothing.
export function setText(node: Element, text: string): void {
  if (node.textContent !== text) node.textContent = text;
}

export function setAttribute(node: Element, name: string, value: string): void {
  if (node.getAttribute(name) !== value) node.setAttribute(name, value);
}

export const kIcons = {
  play: '<path d="M6 4l10 6-10 6z" fill="currentColor" stroke="none"/>',
  pause: '<path d="M6 4h3v12H6zM11 4h3v12h-3z" fill="currentColor" stroke="none"/>',
  back: '<path d="M13 5l-6 5 6 5M5 5v10"/>',
  forward: '<path d="M7 5l6 5-6 5M15 5v10"/>',
  loop: '<path d="M4 9a5 5 0 015-5h5M12 2l2 2-2 2M16 11a5 5 0 01-5 5H6M8 18l-2-2 2-2"/>',
  eye: '<path d="M2 10s3-5 8-5 8 5 8 5-3 5-8 5-8-5-8-5z"/><circle cx="10" cy="10" r="2.2"/>',
  eyeOff: '<path d="M3 11.5C5 14 7.5 15 10 15s5-1 7-3.500M4 4l12 12"/>',
  plus: '<path d="M10 4v12M4 10h12"/>',
  minus: '<path d="M4 10h12"/>',
  fit: '<path d="M4 8V4h4M12 4h4v4M16 12v4h-4M8 16H4v-4"/>',
  north: '<path d="M10 3l4 13-4-3-4 3z"/>',
  follow: '<circle cx="10" cy="10" r="5"/><path d="M10 2v4M10 14v4M2 10h4M14 10h4"/>',
  ruler: '<path d="M3 13L13 3l4 4L7 17zM6 10l2 2M9 7l2 2M12 4l2 2"/>',
  moon: '<path d="M16 12A7 7 0 018 4a7 7 0 108 8z"/>',
  sun: '<circle cx="10" cy="10" r="3.5"/><path d="M10 2v2M10 16v2M2 10h2M16 10h2M4.3 4.300l1.4 1.400M14.3 14.300l1.4 1.400M4.3 15.700l1.4-1.400M14.3 5.700l1.4-1.4"/>',
  help: '<circle cx="10" cy="10" r="7.5"/><path d="M7.8 8a2.3 2.3 0 114 1.700c-.9.8-1.8 1.2-1.8 2.300M10 14.200v.3"/>',
  close: '<path d="M5 5l10 10M15 5L5 15"/>',
  panel: '<rect x="3" y="4" width="14" height="12" rx="1.5"/><path d="M12 4v12"/>',
  chart: '<path d="M3 16h14M4 13l4-5 3 3 5-7"/>',
  layers: '<path d="M10 3l7 4-7 4-7-4zM3 11l7 4 7-4"/>',
  undo: '<path d="M5 8h7a4 4 0 010 8H8M8 4.500L4.5 8 8 11.5"/>',
  redo: '<path d="M15 8H8a4 4 0 000 8h4M12 4.500L15.5 8 12 11.5"/>',
} as const;

export function svg(icon: string): string {
  return `<svg viewBox="0 0 20 20" width="18" height="18" aria-hidden="true" focusable="false" fill="none" stroke="currentColor" stroke-width="1.6" stroke-linecap="round" stroke-linejoin="round">${icon}</svg>`;
}
