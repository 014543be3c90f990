// The 3D view from the keyboard: arrows turn, with Shift they shift, + and - go nearer and further.
import { Spherical, Vector3 } from "three";
import type { Stage } from "./stage";

const kTurn = 0.09; // [rad]
const kArrows: Record<string, [number, number]> = {
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
};

export function startSceneKeys(stage: Stage, moved: () => void): void {
  stage.canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = kArrows[event.key];
    const nearer = event.key === "+" || event.key === "=" ? 0.88 : event.key === "-" ? 1 / 0.88 : 0;
    if (!arrow && !nearer) return;
    event.preventDefault();
    moved();
    if (nearer) dolly(stage, nearer);
    else if (arrow && event.shiftKey) shift(stage, ...arrow);
    else if (arrow) turn(stage, ...arrow);
    stage.controls.update();
    stage.draw();
  });
}

function dolly(stage: Stage, factor: number): void {
  const { camera, controls } = stage;
  camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
}

function turn(stage: Stage, right: number, up: number): void {
  const { camera, controls } = stage;
  const away = camera.position.clone().sub(controls.target);
  const around = new Spherical().setFromVector3(new Vector3(away.x, away.z, -away.y));
  around.theta += right * kTurn;
  around.phi = Math.min(Math.PI - 0.02, Math.max(0.02, around.phi - up * kTurn));
  const turned = new Vector3().setFromSpherical(around);
  camera.position.set(turned.x, -turned.z, turned.y).add(controls.target);
}

function shift(stage: Stage, right: number, up: number): void {
  const { camera, controls } = stage;
  const step = camera.position.distanceTo(controls.target) * 0.05;
  const move = new Vector3(right * step, up * step, 0).applyQuaternion(camera.quaternion);
  camera.position.add(move);
  controls.target.add(move);
}
