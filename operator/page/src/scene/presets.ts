// Where the 3D view is seen from.
import { type Matrix4, Vector3 } from "three";
import type { Stage } from "./stage";
import type { Transforms } from "./transforms";

export type Preset = "behind" | "top" | "eye" | "free";

export class Presets {
  /** Once the operator turns the view it is free. */
  current: Preset = "free";
  private lastBase: Vector3 | null = null;

  constructor(private readonly stage: Stage, private readonly transforms: Transforms, private readonly changed: () => void) {
    stage.controls.addEventListener("start", () => this.free());
  }

  free(): void {
    this.lens(45);
    this.stage.camera.up.set(0, 0, 1);
    this.current = "free";
    this.changed();
  }

  choose(preset: Preset): void {
    this.free();
    this.current = preset;
    this.lastBase = null;
    const base = new Vector3().setFromMatrixPosition(this.transforms.base);
    const ahead = direction(this.transforms.base);
    if (preset === "behind") this.look(base.clone().addScaledVector(ahead, -3.1).setZ(2.5), base.clone().addScaledVector(ahead, 1.1).setZ(0.55));
    if (preset === "top") this.look(base.clone().add(new Vector3(0, -0.02, 9)), base);
    if (preset === "eye") this.throughEye();
    this.changed();
  }

  /** The robot has moved: the view goes along. */
  follow(): void {
    if (this.current === "eye") return this.throughEye();
    const base = new Vector3().setFromMatrixPosition(this.transforms.base);
    if (this.lastBase && this.current !== "free") {
      const moved = base.clone().sub(this.lastBase);
      this.stage.camera.position.add(moved);
      this.stage.controls.target.add(moved);
      this.stage.controls.update();
    }
    this.lastBase = base;
  }

  private look(from: Vector3, to: Vector3): void {
    this.stage.camera.position.copy(from);
    this.stage.controls.target.copy(to);
    this.stage.controls.update();
  }

  /** As the left camera looks: z forward, y down. */
  private throughEye(): void {
    const at = new Vector3().setFromMatrixPosition(this.transforms.camera);
    const ahead = new Vector3(0, 0, 1).transformDirection(this.transforms.camera);
    this.lens(60);
    this.look(at, at.clone().addScaledVector(ahead, 2));
  }

  private lens(degrees: number): void {
    const { camera } = this.stage;
    if (camera.fov === degrees) return;
    camera.fov = degrees;
    camera.updateProjectionMatrix();
  }
}

function direction(base: Matrix4): Vector3 {
  return new Vector3(1, 0, 0).transformDirection(base);
}
