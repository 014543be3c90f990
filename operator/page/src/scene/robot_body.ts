// HRP-2 as one knows it: angular white chest, broad shoulders, narrow waist, a helmet with a visor. Measures are about
// right (1.54 m); only where base, chest and head are comes from the robot.
import {
  type BufferGeometry, BoxGeometry, CapsuleGeometry, CylinderGeometry, Group, type Material, Matrix4, Mesh,
  MeshLambertMaterial,
} from "three";
import { chestFromHead } from "./transforms";
import type { HeadPose } from "../state/app";

const white = new MeshLambertMaterial({ color: "#dfe3e8" });
const grey = new MeshLambertMaterial({ color: "#6b7683" });
const dark = new MeshLambertMaterial({ color: "#252c35" });
const blue = new MeshLambertMaterial({ color: "#3f6fb5" });
const visor = new MeshLambertMaterial({ color: "#0f2b33", emissive: "#1c8f86", emissiveIntensity: 0.6 });

type Vec = [number, number, number];

function part(geometry: BufferGeometry, material: Material, at: Vec, turn: Vec = [0, 0, 0]): Mesh {
  const mesh = new Mesh(geometry, material);
  mesh.position.set(...at);
  mesh.rotation.set(...turn);
  return mesh;
}

const box = (size: Vec, material: Material, at: Vec, turn?: Vec) => part(new BoxGeometry(...size), material, at, turn);
const kUpright = Math.PI / 2;
/** A capsule along z, of this whole length. */
const limb = (radius: number, length: number, material: Material, at: Vec) =>
  part(new CapsuleGeometry(radius, length - 2 * radius, 4, 10), material, at, [kUpright, 0, 0]);

function leg(side: number): Mesh[] {
  const y = side * 0.095;
  return [
    box([0.235, 0.135, 0.045], dark, [0.02, y, 0.023]),
    box([0.15, 0.105, 0.05], grey, [0.0, y, 0.07]),
    box([0.115, 0.105, 0.25], white, [-0.005, y, 0.22]),
    limb(0.062, 0.16, grey, [0.012, y, 0.37]),
    box([0.135, 0.12, 0.23], white, [0.005, y, 0.52]),
    box([0.05, 0.085, 0.16], blue, [0.068, y, 0.52]),
    limb(0.07, 0.17, dark, [0, y, 0.66]),
  ];
}

function arm(side: number): Mesh[] {
  const y = side * 0.285;
  return [
    box([0.17, 0.13, 0.16], white, [0, y - side * 0.005, 0.245]),
    box([0.1, 0.02, 0.13], blue, [0, y + side * 0.066, 0.25]),
    limb(0.05, 0.24, grey, [0, y + side * 0.01, 0.1]),
    limb(0.052, 0.12, dark, [0.005, y + side * 0.012, -0.03]),
    box([0.22, 0.085, 0.09], white, [0.11, y + side * 0.01, -0.075], [0, 0.35, 0]),
    box([0.09, 0.07, 0.06], dark, [0.25, y + side * 0.005, -0.125], [0, 0.35, 0]),
  ];
}

function chest(): Mesh[] {
  return [
    box([0.24, 0.36, 0.27], white, [0.0, 0, 0.165]),
    box([0.1, 0.27, 0.17], white, [0.13, 0, 0.19], [0, 0.22, 0]),
    box([0.02, 0.15, 0.06], blue, [0.188, 0, 0.2], [0, 0.22, 0]),
    box([0.12, 0.32, 0.24], grey, [-0.155, 0, 0.17]),
    limb(0.105, 0.24, dark, [0, 0, -0.02]),
    part(new CylinderGeometry(0.05, 0.06, 0.08, 12), dark, [0, 0, 0.32], [kUpright, 0, 0]),
  ];
}

function head(): Mesh[] {
  return [
    box([0.17, 0.15, 0.11], white, [0.005, 0, 0.085]),
    box([0.14, 0.12, 0.05], white, [-0.005, 0, 0.155]),
    box([0.03, 0.136, 0.05], visor, [0.083, 0, 0.1]),
    box([0.1, 0.11, 0.055], grey, [0.02, 0, 0.02]),
    box([0.1, 0.024, 0.075], blue, [-0.01, 0.087, 0.1]),
    box([0.1, 0.024, 0.075], blue, [-0.01, -0.087, 0.1]),
    box([0.07, 0.01, 0.11], white, [-0.045, 0.1, 0.16], [0.12, -0.5, 0]),
    box([0.07, 0.01, 0.11], white, [-0.045, -0.1, 0.16], [-0.12, -0.5, 0]),
    part(new CylinderGeometry(0.014, 0.014, 0.03, 10), dark, [0.04, 0.072, 0.045], [0, 0, kUpright]),
    part(new CylinderGeometry(0.014, 0.014, 0.03, 10), dark, [0.04, -0.072, 0.045], [0, 0, kUpright]),
  ];
}

function fixed(parts: Mesh[]): Group {
  const group = new Group();
  group.add(...parts);
  group.matrixAutoUpdate = false;
  return group;
}

export class RobotBody {
  readonly object = new Group();
  private readonly legs = fixed([
    ...leg(1), ...leg(-1), box([0.2, 0.26, 0.12], white, [-0.01, 0, 0.76]), limb(0.09, 0.24, dark, [0, 0, 0.85]),
  ]);
  private readonly trunk = fixed([...chest(), ...arm(1), ...arm(-1)]);
  private readonly skull = fixed(head());

  constructor() {
    this.object.add(this.legs, this.trunk, this.skull);
  }

  place(base: Matrix4, chestAt: Matrix4, looks: HeadPose): void {
    this.legs.matrix.copy(base);
    this.trunk.matrix.copy(chestAt);
    this.skull.matrix.copy(chestAt).multiply(chestFromHead(looks));
    for (const group of [this.legs, this.trunk, this.skull]) group.matrixWorldNeedsUpdate = true;
  }
}
