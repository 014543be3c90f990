// The floor that the body sweeps along a way, over the floor map.
import { CanvasTexture, LinearFilter, Mesh, MeshBasicMaterial, NearestFilter, PlaneGeometry, SRGBColorSpace } from "three";
import type { SweptImage } from "../state/swept_image";
import { onFloor } from "./on_floor";

export class Swept {
  readonly object = new Mesh(new PlaneGeometry(1, 1), new MeshBasicMaterial({ transparent: true, depthWrite: false, ...onFloor }));

  constructor() {
    this.object.visible = false;
    this.object.position.z = 0.003;
  }

  show(image: SweptImage): void {
    const material = this.object.material;
    material.map?.dispose();
    material.map = new CanvasTexture(image.canvas);
    material.map.colorSpace = SRGBColorSpace;
    material.map.magFilter = NearestFilter;
    material.map.minFilter = LinearFilter;
    material.map.generateMipmaps = false;
    material.needsUpdate = true;
    this.object.scale.set(image.width, image.height, 1);
    this.object.position.setX(image.x + image.width / 2).setY(image.y + image.height / 2);
  }
}
