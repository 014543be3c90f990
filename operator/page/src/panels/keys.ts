// Which keys do what.
import { byId, make } from "./dom";

const kKeys = [
  ["Esc, Space", "stop, always"],
  ["T", "take control, or hand it back"],
  ["M", "to the floor map; arrow keys move the cross, Enter shows the way"],
  ["Enter", "walk the way that is shown"],
  ["H", "to the head; arrow keys aim, Enter looks"],
  ["N", "next best view"],
  ["P", "pause, or go on"],
  ["1 2 3", "the scene from behind, from the top, as the eye"],
  ["?", "these keys"],
] as const;

export function keys(): void {
  const dialog = byId<HTMLDialogElement>("keys");
  const close = make("button", { type: "button", click: () => dialog.close() }, "Close");
  dialog.append(make("h2", { id: "keys-title" }, "Keys"),
    make("dl", { class: "facts" }, ...kKeys.flatMap(([key, what]) => [make("dt", {}, make("kbd", {}, key)), make("dd", {}, what)])), close);
  byId("help").addEventListener("click", () => dialog.showModal());
  const press = (id: string): void => document.getElementById(id)?.click();
  window.addEventListener("keydown", (event) => {
    if (event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement || event.ctrlKey || event.metaKey || event.altKey) return;
    const view = { "1": "behind", "2": "top", "3": "eye" }[event.key];
    if (view) document.querySelector<HTMLElement>(`[data-view=${view}]`)?.click();
    else if (event.key === "?") dialog.showModal();
    else if (event.key === "t") press(document.getElementById("take") ? "take" : "release");
    else if (event.key === "m") byId("map").focus();
    else if (event.key === "h") byId("head-pad").focus();
    else if (event.key === "n") press("explore");
    else if (event.key === "p") press(byId("pause").hidden ? "resume" : "pause");
  });
}
