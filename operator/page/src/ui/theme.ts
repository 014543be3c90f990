// Dark or light: as the system has it, until the operator chooses.
import { byId } from "./dom";
import { Signal } from "./signal";

export type Theme = "dark" | "light";
const kKey = "headway.theme";
const system = matchMedia("(prefers-color-scheme: light)");

function wanted(): Theme {
  const kept = localStorage.getItem(kKey);
  if (kept === "dark" || kept === "light") return kept;
  return system.matches ? "light" : "dark";
}

export const theme = new Signal<Theme>(wanted());

const colors = new Map<string, string>();

/** A colour of the style sheet, for what is painted on a canvas. Asked for often: the browser is asked once. */
export function themeColor(name: string): string {
  let color = colors.get(name);
  if (color === undefined) {
    color = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
    colors.set(name, color);
  }
  return color;
}

export function startTheme(): void {
  theme.watch((value) => {
    document.documentElement.setAttribute("data-theme", value);
    colors.clear();
  });
  system.addEventListener("change", () => theme.set(wanted()));
  byId("theme").addEventListener("click", () => {
    const next = theme.value === "dark" ? "light" : "dark";
    localStorage.setItem(kKey, next);
    theme.set(next);
  });
}
