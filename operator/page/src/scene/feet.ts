// Footsteps on the floor: those that are committed filled, those that may still change as outlines.
import { BufferAttribute, BufferGeometry, Color, DoubleSide, Mesh, MeshBasicMaterial } from "three";
import { type Foot, cornersOf } from "../state/feet";
import { kLeftFoot, kRightFoot } from "./colours";
import { onFloor } from "./on_floor";
import { strip } from "./ways";

const kHeight = 0.012; // [m]
const kRim = 0.014; // [m]

export class Feet {
  readonly object = new Mesh(new BufferGeometry(), new MeshBasicMaterial({ vertexColors: true, side: DoubleSide, ...onFloor }));

  constructor() {
    this.object.frustumCulled = false;
  }

  show(feet: readonly Foot[]): void {
    const places: number[] = [];
    const colors: number[] = [];
    for (const foot of feet) {
      const begin = places.length;
      sole(places, foot);
      const { r, g, b } = new Color(foot.left ? kLeftFoot : kRightFoot);
      for (let n = begin; n < places.length; n += 3) colors.push(r, g, b);
    }
    this.object.geometry.dispose();
    this.object.geometry = new BufferGeometry();
    this.object.geometry.setAttribute("position", new BufferAttribute(new Float32Array(places), 3));
    this.object.geometry.setAttribute("color", new BufferAttribute(new Float32Array(colors), 3));
  }
}

function sole(places: number[], foot: Foot): void {
  const corners = cornersOf(foot);
  if (foot.committed) for (const i of [0, 1, 2, 0, 2, 3]) places.push(...corners[i]!, kHeight);
  else corners.forEach(([x, y], i) => strip(places, { x, y }, placeOf(corners[(i + 1) % 4]!), kRim, kHeight));
}

function placeOf([x, y]: [number, number]): { x: number; y: number } {
  return { x, y };
}
