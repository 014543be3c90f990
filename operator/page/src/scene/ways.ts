// Ways over the floor: the one that is walked and the one that is proposed, as ribbons, for lines are thin on every screen.
import { BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshBasicMaterial } from "three";
import type { Path } from "../wire/messages";
import { onFloor } from "./on_floor";

export type Place = { x: number; y: number };

export function placesOf(path: Path): Place[] {
  return path.poses.map(({ pose }) => pose.position);
}

export class Way {
  readonly object: Mesh;

  constructor(color: string, private readonly width: number, private readonly height: number, private readonly dash = 0) {
    this.object = new Mesh(new BufferGeometry(), new MeshBasicMaterial({ color, side: DoubleSide, ...onFloor }));
    this.object.frustumCulled = false;
  }

  show(places: readonly Place[]): void {
    const corners: number[] = [];
    let walked = 0;
    for (let i = 1; i < places.length; ++i) walked = this.piece(corners, places[i - 1]!, places[i]!, walked);
    this.object.geometry.dispose();
    this.object.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(corners), 3));
  }

  /** From a to b, `walked` metres from the begin; in dashes where there are to be any. */
  private piece(corners: number[], a: Place, b: Place, walked: number): number {
    const length = Math.hypot(b.x - a.x, b.y - a.y);
    if (length < 1e-6) return walked;
    const step = this.dash || length;
    for (let from = 0; from < length; ) {
      const left = step - ((walked + from) % step);
      const to = Math.min(length, from + (this.dash ? left : length));
      const drawn = !this.dash || Math.floor((walked + from) / step + 1e-6) % 2 === 0;
      if (drawn) strip(corners, along(a, b, from / length), along(a, b, to / length), this.width, this.height);
      from = Math.max(to, from + 1e-4);
    }
    return walked + length;
  }
}

/** Two triangles from a to b. */
export function strip(corners: number[], a: Place, b: Place, width: number, z: number): void {
  const length = Math.hypot(b.x - a.x, b.y - a.y) || 1;
  const [sx, sy] = [(-(b.y - a.y) / length) * (width / 2), ((b.x - a.x) / length) * (width / 2)];
  corners.push(a.x + sx, a.y + sy, z, a.x - sx, a.y - sy, z, b.x - sx, b.y - sy, z);
  corners.push(a.x + sx, a.y + sy, z, b.x - sx, b.y - sy, z, b.x + sx, b.y + sy, z);
}

function along(a: Place, b: Place, share: number): Place {
  return { x: a.x + share * (b.x - a.x), y: a.y + share * (b.y - a.y) };
}
