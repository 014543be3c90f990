// Where the robot is to go, as a ring on the floor with a pole, and an arrow where a heading is asked for.
import { ConeGeometry, CylinderGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, RingGeometry } from "three";
import { onFloor } from "./on_floor";
import type { Goal } from "../state/mission";

export class GoalFlag {
  readonly object = new Group();
  private readonly arrow: Mesh;

  constructor(color: string) {
    const paint = new MeshBasicMaterial({ color, side: DoubleSide, ...onFloor });
    const ring = new Mesh(new RingGeometry(0.11, 0.15, 32), paint);
    ring.position.z = 0.015;
    const pole = new Mesh(new CylinderGeometry(0.008, 0.008, 0.5, 8), paint);
    pole.rotation.x = Math.PI / 2;
    pole.position.z = 0.25;
    this.arrow = new Mesh(new ConeGeometry(0.06, 0.16, 3), paint);
    this.arrow.rotation.z = -Math.PI / 2;
    this.arrow.position.set(0.25, 0, 0.02);
    this.arrow.scale.z = 0.2;
    this.object.add(ring, pole, this.arrow);
    this.object.visible = false;
  }

  show(goal: Goal | null): void {
    this.object.visible = goal !== null;
    if (!goal) return;
    this.object.position.set(goal.x, goal.y, 0);
    this.object.rotation.z = goal.yaw ?? 0;
    this.arrow.visible = goal.yaw !== undefined;
  }
}
