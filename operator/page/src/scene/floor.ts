// The floor map under everything.
import { CanvasTexture, LinearFilter, Mesh, MeshBasicMaterial, NearestFilter, PlaneGeometry, SRGBColorSpace } from "three";
import type { FloorImage } from "../state/floor_image";

export class Floor {
  readonly object = new Mesh(new PlaneGeometry(1, 1), new MeshBasicMaterial());

  constructor() {
    this.object.visible = false;
    this.object.position.z = -0.006;
  }

  show(image: FloorImage): void {
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
    this.object.visible = true;
  }
}
