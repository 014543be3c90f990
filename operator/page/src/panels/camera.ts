// What the left camera sees.
import type { Robot } from "../wire/robot";
import { byId } from "./dom";

export function camera(robot: Robot): void {
  const picture = byId<HTMLImageElement>("picture");
  let last = "";
  robot.on("/camera/left", ({ format, data }) => {
    const next = URL.createObjectURL(new Blob([data.slice()], { type: `image/${format}` }));
    picture.src = next;
    if (last) URL.revokeObjectURL(last);
    last = next;
  });
}
