// What is shown of space, with its scale.
import { kCoarsest, kFinest, precision, viridis } from "../scene/colours";
import { kLayers, type Layer, type Scene, type View } from "../scene/scene";
import type { Robot } from "../wire/robot";
import { byId, make } from "./dom";

export function layers(robot: Robot, scene: Scene): void {
  const place = byId("layers");
  for (const [name, label] of Object.entries(kLayers) as [Layer, string][]) {
    const box = make("input", { type: "checkbox", id: `layer-${name}` });
    box.checked = scene.shows(name);
    box.addEventListener("change", () => scene.show(name, box.checked));
    place.append(make("label", { class: "check" }, box, label));
  }
  const choice = make("select", { id: "resolution", "aria-label": "Where the rig sees at least so precisely" });
  choice.addEventListener("change", () => scene.showField(choice.value));
  place.append(choice);
  robot.on("/field", (fields) => {
    const names = scene.takeFields(fields);
    choice.replaceChildren(...names.map((name) => make("option", { value: name }, name === "rig" ? "all of the field" : `to ${name} or better`)));
    choice.value = scene.resolution;
  });
  for (const button of document.querySelectorAll<HTMLButtonElement>("[data-view]"))
    button.addEventListener("click", () => scene.look(button.dataset.view as View));
  scale();
}

/** The colours of precision, from fine to coarse, in millimetres. */
function scale(): void {
  const canvas = make("canvas", { width: "120", height: "10", role: "img", "aria-label": "From 2 mm, yellow, to 50 mm, violet" });
  const context = canvas.getContext("2d")!;
  for (let x = 0; x < 120; ++x) {
    const sigma = kFinest * (kCoarsest / kFinest) ** (x / 119);
    context.fillStyle = `rgb(${viridis(precision(sigma)).map((c) => Math.round(255 * c)).join(",")})`;
    context.fillRect(x, 0, 1, 10);
  }
  byId("scale").replaceChildren("σ 2 mm ", canvas, " 50 mm");
}
