// How wrong points may be: the region that holds each with 95 %. Along the ray it is what the robot says; across, a pair
// of eyes a baseline apart knows a point at distance z better by baseline over z.
import { InstancedMesh, type Mesh, Matrix4, MeshLambertMaterial, Quaternion, SphereGeometry, Vector3 } from "three";
import type { Cloud } from "./cloud";

const kBaseline = 0.144; // [m], HRP-2's lower pair
const k95 = 2.796; // standard deviations that hold 95 % in three dimensions
const kSampled = 250;
/** Drawn larger than they are, or nobody would see them. */
export const kLarger = 5;
const kZ = new Vector3(0, 0, 1);

export type Picked = { index: number; sigma: number; distance: number };

export class Ellipsoids {
  private readonly shapes = new SphereGeometry(1, 12, 8);
  readonly sampled: InstancedMesh;
  readonly picked: Mesh & InstancedMesh;

  constructor() {
    const soft = new MeshLambertMaterial({ color: "#d0743c", transparent: true, opacity: 0.75, depthWrite: false });
    this.sampled = new InstancedMesh(this.shapes, soft, kSampled);
    this.sampled.count = 0;
    this.sampled.visible = false;
    this.sampled.frustumCulled = false;
    const clear = new MeshLambertMaterial({ color: "#ff5e3a", transparent: true, opacity: 0.8 });
    this.picked = new InstancedMesh(this.shapes, clear, 1) as Mesh & InstancedMesh;
    this.picked.visible = false;
    this.picked.frustumCulled = false;
  }

  /** Some of the points, evenly chosen. */
  sample(cloud: Cloud, eye: Vector3): void {
    const every = Math.max(1, Math.floor(cloud.count / kSampled));
    this.sampled.count = Math.min(kSampled, Math.floor(cloud.count / every));
    for (let i = 0; i < this.sampled.count; ++i) this.sampled.setMatrixAt(i, shape(cloud, i * every, eye));
    this.sampled.instanceMatrix.needsUpdate = true;
  }

  pick(cloud: Cloud, index: number, eye: Vector3): Picked {
    this.picked.setMatrixAt(0, shape(cloud, index, eye));
    this.picked.instanceMatrix.needsUpdate = true;
    this.picked.visible = true;
    return { index, sigma: cloud.sigma[index] ?? 0, distance: pointOf(cloud, index).distanceTo(eye) };
  }

  forget(): void {
    this.picked.visible = false;
  }
}

function pointOf(cloud: Cloud, index: number): Vector3 {
  return new Vector3().fromArray(cloud.position, 3 * index);
}

function shape(cloud: Cloud, index: number, eye: Vector3): Matrix4 {
  const point = pointOf(cloud, index);
  const ray = point.clone().sub(eye);
  const along = kLarger * k95 * (cloud.sigma[index] ?? 0);
  const across = along * Math.min(1, kBaseline / Math.max(kBaseline, ray.length()));
  const turn = new Quaternion().setFromUnitVectors(kZ, ray.normalize());
  return new Matrix4().compose(point, turn, new Vector3(across, across, along));
}
