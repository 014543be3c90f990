// Small helpers to build and find elements; all texts go in as text, never as markup.
export function byId<T extends HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`#${id} is missing`);
  return found as T;
}

type Props = Record<string, string | boolean | (() => void)>;

export function make<K extends keyof HTMLElementTagNameMap>(tag: K, props: Props = {}, ...inside: (Node | string)[]):
  HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(props)) {
    if (typeof value === "function") element.addEventListener(key, value);
    else if (typeof value === "boolean") element.toggleAttribute(key, value);
    else if (key === "class") element.className = value;
    else element.setAttribute(key, value);
  }
  element.append(...inside);
  return element;
}

/** Changes a text only where it is another, so that screen readers say it once. */
export function say(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

export function metres(value: number): string {
  return value.toFixed(2);
}
export function degrees(radians: number): string {
  return `${((radians * 180) / Math.PI).toFixed(0)}°`;
}
