// On a small screen one view shows at a time.
import { byId } from "../ui/dom";

export function startTabs(): void {
  const buttons = [...document.querySelectorAll<HTMLButtonElement>(".tabs button")];
  const choose = (tab: string): void => {
    document.body.dataset["tab"] = tab;
    for (const button of buttons) button.setAttribute("aria-pressed", String(button.dataset["tab"] === tab));
  };
  for (const button of buttons) button.addEventListener("click", () => choose(button.dataset["tab"] ?? "scene"));
  const wide = matchMedia("(min-width: 1200px)");
  const layers = byId<HTMLDetailsElement>("layers");
  layers.open = wide.matches;
  // A tablet shows the scene beside these.
  choose(matchMedia("(min-width: 760px) and (max-width: 1199px)").matches ? "camera" : "scene");
}
