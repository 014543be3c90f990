// The floor that the body sweeps along a way, over the floor map.
import type { SweptImage } from "../state/swept_image";
import { floorMesh, lay } from "./floor_picture";
import { onFloor } from "./on_floor";

export class Swept {
  readonly object = floorMesh(0.003, { transparent: true, depthWrite: false, ...onFloor });

  show(image: SweptImage): void {
    lay(image, this.object);
  }
}
