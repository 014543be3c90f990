// What the pair of cameras sees, and how precisely: bodies in the camera's frame, one for each precision. The same body is
// shown a second time where the head might look.
import {
  BufferAttribute, BufferGeometry, DoubleSide, EdgesGeometry, Group, LineBasicMaterial, LineSegments, type Matrix4, Mesh,
  MeshBasicMaterial,
} from "three";
import type { Marker, MarkerArray } from "../wire/messages";
import { markerAction, markerType } from "../wire/messages";
import { theme, themeColor } from "../ui/theme";

class Body {
  readonly object = new Group();
  private readonly skin: MeshBasicMaterial;
  private readonly rim: LineBasicMaterial;

  constructor(colorName: string, opacity: number) {
    this.skin = new MeshBasicMaterial({ transparent: true, opacity, depthWrite: false, side: DoubleSide });
    this.rim = new LineBasicMaterial();
    theme.watch(() => {
      for (const material of [this.skin, this.rim]) material.color.set(themeColor(colorName));
    });
    this.object.matrixAutoUpdate = false;
    this.object.visible = false;
  }

  show(geometry: BufferGeometry | undefined): void {
    this.object.clear();
    if (!geometry) return;
    this.object.add(new Mesh(geometry, this.skin), new LineSegments(new EdgesGeometry(geometry, 12), this.rim));
  }

  place(at: Matrix4): void {
    this.object.matrix.copy(at);
    this.object.matrixWorldNeedsUpdate = true;
  }
}

export class Field {
  readonly now = new Body("field", 0.1);
  readonly ghost = new Body("ghost", 0.14);
  private readonly shapes = new Map<string, BufferGeometry>();
  private chosen = "rig";

  /** Names of what can be chosen: "rig", "5 mm" and so on. */
  get names(): string[] {
    return [...this.shapes.keys()];
  }

  take(message: MarkerArray): void {
    for (const marker of message.markers) {
      if (marker.action === markerAction.deleteAll) this.shapes.clear();
      else if (marker.type === markerType.triangleList) this.shapes.set(marker.ns, triangles(marker));
    }
    this.choose(this.chosen);
  }

  choose(name: string): void {
    this.chosen = name;
    for (const body of [this.now, this.ghost]) body.show(this.shapes.get(name));
  }
}

function triangles(marker: Marker): BufferGeometry {
  const position = new Float32Array(marker.points.flatMap(({ x, y, z }) => [x, y, z]));
  return new BufferGeometry().setAttribute("position", new BufferAttribute(position, 3));
}
