// A picture that lies flat on the floor, each of its pixels a cell of the map.
import { CanvasTexture, LinearFilter, Mesh, MeshBasicMaterial, NearestFilter, PlaneGeometry, SRGBColorSpace } from "three";
import type { MeshBasicMaterialParameters } from "three";

/** Metres, in the map; the canvas covers all of it. */
type FloorPicture = { canvas: HTMLCanvasElement; x: number; y: number; width: number; height: number };

/** Not seen before the first picture. */
export function floorMesh(z: number, material: MeshBasicMaterialParameters = {}): Mesh<PlaneGeometry, MeshBasicMaterial> {
  const mesh = new Mesh(new PlaneGeometry(1, 1), new MeshBasicMaterial(material));
  mesh.visible = false;
  mesh.position.z = z;
  return mesh;
}

export function lay(picture: FloorPicture, mesh: Mesh<PlaneGeometry, MeshBasicMaterial>): void {
  const material = mesh.material;
  material.map?.dispose();
  material.map = new CanvasTexture(picture.canvas);
  material.map.colorSpace = SRGBColorSpace;
  material.map.magFilter = NearestFilter;
  material.map.minFilter = LinearFilter;
  material.map.generateMipmaps = false;
  material.needsUpdate = true;
  mesh.scale.set(picture.width, picture.height, 1);
  mesh.position.setX(picture.x + picture.width / 2).setY(picture.y + picture.height / 2);
}
