// HRP-2 as a figure of boxes: enough to see where it stands, and where it looks.
import * as THREE from "three";

const kBody = 0xd8dee6;
const kDark = 0x4b5a6b;

function box(size: [number, number, number], at: [number, number, number], colour: number): THREE.Mesh {
  const mesh = new THREE.Mesh(new THREE.BoxGeometry(...size), new THREE.MeshLambertMaterial({ color: colour }));
  mesh.position.set(...at);
  return mesh;
}

export class Figure {
  readonly body = new THREE.Group();
  private head = new THREE.Group();

  constructor() {
    for (const side of [1, -1]) {
      this.body.add(box([0.23, 0.12, 0.08], [0.03, 0.095 * side, 0.04], kDark));
      this.body.add(box([0.1, 0.1, 0.3], [0, 0.095 * side, 0.23], kBody));
      this.body.add(box([0.13, 0.12, 0.32], [0, 0.095 * side, 0.53], kBody));
      this.body.add(box([0.1, 0.1, 0.3], [0.02, 0.29 * side, 1.02], kBody));
      this.body.add(box([0.09, 0.09, 0.28], [0.06, 0.31 * side, 0.75], kBody));
      this.body.add(box([0.12, 0.08, 0.1], [0.08, 0.31 * side, 0.57], kDark));
      this.body.add(box([0.14, 0.12, 0.14], [0, 0.26 * side, 1.2], kDark));
    }
    this.body.add(box([0.2, 0.3, 0.16], [0, 0, 0.76], kDark));
    this.body.add(box([0.22, 0.36, 0.4], [0, 0, 1.08], kBody));
    this.body.add(box([0.16, 0.3, 0.34], [-0.16, 0, 1.08], kDark));
    this.head.position.set(0, 0, 1.36);
    this.head.add(box([0.2, 0.18, 0.22], [0.02, 0, 0.13], kBody));
    this.head.add(box([0.03, 0.16, 0.06], [0.125, 0, 0.15], 0x14222f));
    this.body.add(this.head);
  }

  stand(x: number, y: number, yaw: number): void {
    this.body.position.set(x, y, 0);
    this.body.rotation.z = yaw;
  }
  /** Tilt is positive downward. */
  look(pan: number, tilt: number): void {
    this.head.rotation.set(0, tilt, pan, "ZYX");
  }
}
