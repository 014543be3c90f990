// The floor map under everything.
import type { FloorImage } from "../state/floor_image";
import { floorMesh, lay } from "./floor_picture";

export class Floor {
  readonly object = floorMesh(-0.006);

  show(image: FloorImage): void {
    lay(image, this.object);
    this.object.visible = true;
  }
}
