// Which things the 3D view shows; kept by the browser.
import { setPressed } from "../ui/dom";

const kKey = "headway.layers";

export type Choice = {
  layers: Record<string, boolean>;
  field: string;
  colour: string;
};

const kFirst: Choice = {
  layers: { cloud: true, ellipsoids: false, occupied: true, unseen: false, floor: true, body: true, steps: true, robot: true },
  field: "rig",
  colour: "sigma",
};

function kept(): Choice {
  try {
    const value = JSON.parse(localStorage.getItem(kKey) ?? "{}") as Partial<Choice>;
    return { ...kFirst, ...value, layers: { ...kFirst.layers, ...value.layers } };
  } catch {
    return kFirst;
  }
}

export class Layers {
  readonly choice = kept();

  constructor(private readonly panel: HTMLElement, private readonly changed: (choice: Choice) => void) {
    panel.addEventListener("click", (event) => this.click(event.target));
    this.show();
  }

  /** Another precision may be chosen. */
  offerFields(names: readonly string[]): void {
    const group = this.panel.querySelector("#field-choice")!;
    for (const name of names) {
      if (group.querySelector(`[data-field="${CSS.escape(name)}"]`)) continue;
      const button = document.createElement("button");
      button.type = "button";
      button.dataset["field"] = name;
      button.textContent = name;
      group.append(button);
    }
    this.show();
  }

  private click(target: EventTarget | null): void {
    const button = target instanceof Element ? target.closest("button") : null;
    const { layer, field, colour } = button?.dataset ?? {};
    if (layer !== undefined) this.choice.layers[layer] = !this.choice.layers[layer];
    if (field !== undefined) this.choice.field = field;
    if (colour !== undefined) this.choice.colour = colour;
    localStorage.setItem(kKey, JSON.stringify(this.choice));
    this.show();
  }

  private show(): void {
    for (const button of this.panel.querySelectorAll("button")) {
      const { layer, field, colour } = button.dataset;
      if (layer !== undefined) setPressed(button, this.choice.layers[layer] ?? false);
      if (field !== undefined) setPressed(button, field === this.choice.field);
      if (colour !== undefined) setPressed(button, colour === this.choice.colour);
    }
    this.changed(this.choice);
  }
}
