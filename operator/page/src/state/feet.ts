// Footsteps as both views draw them.
import type { MarkerArray } from "../wire/messages";
import { markerAction } from "../wire/messages";

export type Foot = { x: number; y: number; yaw: number; length: number; width: number; committed: boolean; left: boolean };

export function yawOf({ x, y, z, w }: { x: number; y: number; z: number; w: number }): number {
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

/** A foot's side shows in its colour: left is bluer than green. */
export function feetOf(message: MarkerArray): Foot[] {
  return message.markers
    .filter((marker) => marker.action === markerAction.add)
    .map(({ ns, pose, scale, color }) => ({
      x: pose.position.x, y: pose.position.y, yaw: yawOf(pose.orientation), length: scale.x, width: scale.y,
      committed: ns === "committed", left: color.b >= color.g,
    }));
}

/** The corners of a sole [m]. */
export function cornersOf(foot: Foot): [number, number][] {
  const [c, s] = [Math.cos(foot.yaw), Math.sin(foot.yaw)];
  const [l, w] = [foot.length / 2, foot.width / 2];
  const at = (u: number, v: number): [number, number] => [foot.x + c * u - s * v, foot.y + s * u + c * v];
  return [at(l, w), at(-l, w), at(-l, -w), at(l, -w)];
}
