// The floor seen from above: click for a way, drag to choose how the robot shall face, shift-click for a list.
import { css } from "../scene/colours";
import { yawOf, type Path } from "../wire/messages";
import type { Robot } from "../wire/robot";
import { byId } from "./dom";
import type { Go } from "./go";

const kDrag = 12; // a drag shorter than this is a click [px]
const kStep = 0.1; // of an arrow key [m]

export type FloorView = { at: (x: number, y: number) => [number, number] };

/** Returns where on the canvas a place of the map lies. */
export function map(robot: Robot, go: Go): FloorView {
  const canvas = byId<HTMLCanvasElement>("map");
  const context = canvas.getContext("2d")!;
  let floor: HTMLCanvasElement | undefined;
  let centre = { x: 0, y: 0 };
  let scale = 60; // [px/m]
  let fitted = false;
  let asked = false;
  let from: { x: number; y: number; px: number; py: number } | undefined;
  let to: { px: number; py: number } | undefined;
  let cursor: { x: number; y: number } | undefined;

  const ratio = (): number => Math.min(devicePixelRatio, 2);
  const px = (x: number, y: number): [number, number] =>
    [canvas.clientWidth / 2 + (x - centre.x) * scale, canvas.clientHeight / 2 - (y - centre.y) * scale];
  const at = (event: MouseEvent): { x: number; y: number; px: number; py: number } => {
    const area = canvas.getBoundingClientRect();
    const [left, top] = [event.clientX - area.left, event.clientY - area.top];
    return { px: left, py: top, x: centre.x + (left - canvas.clientWidth / 2) / scale,
      y: centre.y - (top - canvas.clientHeight / 2) / scale };
  };

  /** The cells as a picture: what is free, blocked, unseen. */
  const paint = (): void => {
    const grid = robot.get("/map");
    if (!grid) return;
    const { width, height } = grid.info;
    floor ??= document.createElement("canvas");
    floor.width = width;
    floor.height = height;
    const picture = new ImageData(width, height);
    const tones = [["--free", 0], ["--blocked", 100], ["--unseen", -1]].map(([name, value]) => [rgb(css(String(name))), value] as const);
    for (let y = 0; y < height; ++y)
      for (let x = 0; x < width; ++x) {
        const cell = grid.data[y * width + x]!;
        const tone = cell < 0 ? tones[2]![0] : cell >= 50 ? tones[1]![0] : tones[0]![0];
        picture.data.set([...tone, 255], 4 * ((height - 1 - y) * width + x));
      }
    floor.getContext("2d")!.putImageData(picture, 0, 0);
  };

  /** So that all that was seen can be seen. */
  const fit = (): void => {
    const grid = robot.get("/map");
    if (!grid || canvas.clientWidth === 0) return;
    const { width, height, resolution, origin } = grid.info;
    let [west, east, south, north] = [width, 0, height, 0];
    for (let y = 0; y < height; ++y)
      for (let x = 0; x < width; ++x)
        if (grid.data[y * width + x]! >= 0) {
          west = Math.min(west, x);
          east = Math.max(east, x);
          south = Math.min(south, y);
          north = Math.max(north, y);
        }
    if (east < west) return;
    centre = { x: origin.position.x + ((west + east + 1) / 2) * resolution, y: origin.position.y + ((south + north + 1) / 2) * resolution };
    scale = 0.92 * Math.min(canvas.clientWidth / ((east - west + 1) * resolution), canvas.clientHeight / ((north - south + 1) * resolution));
    fitted = true;
  };

  const line = (path: Path | undefined, tone: string, dashed: boolean): void => {
    if (!path || path.poses.length < 2) return;
    context.beginPath();
    for (const { pose } of path.poses) context.lineTo(...px(pose.position.x, pose.position.y));
    context.setLineDash(dashed ? [6, 5] : []);
    context.strokeStyle = css(tone);
    context.lineWidth = 2.5;
    context.stroke();
    context.setLineDash([]);
  };
  const turned = (x: number, y: number, yaw: number, what: () => void): void => {
    context.save();
    context.translate(...px(x, y));
    context.rotate(-yaw);
    what();
    context.restore();
  };

  const draw = (): void => {
    asked = false;
    const grid = robot.get("/map");
    const { clientWidth: width, clientHeight: height } = canvas;
    canvas.width = width * ratio();
    canvas.height = height * ratio();
    context.setTransform(ratio(), 0, 0, ratio(), 0, 0);
    context.fillStyle = css("--unseen");
    context.fillRect(0, 0, width, height);
    if (grid && floor) {
      const { resolution, origin } = grid.info;
      const [left, bottom] = px(origin.position.x, origin.position.y);
      context.imageSmoothingEnabled = false;
      const [w, h] = [floor.width * resolution * scale, floor.height * resolution * scale];
      context.drawImage(floor, left, bottom - h, w, h);
    }
    line(robot.get("/plan"), "--way", false);
    line(robot.get("/preview"), "--shown", true);
    for (const foot of robot.get("/footsteps")?.markers ?? []) {
      if (foot.action !== 0) continue;
      turned(foot.pose.position.x, foot.pose.position.y, yawOf(foot.pose.orientation), () => {
        const [length, breadth] = [foot.scale.x * scale, foot.scale.y * scale];
        const tone = css(foot.color.b > foot.color.r ? "--left" : "--right");
        context.beginPath();
        context.roundRect(-length / 2, -breadth / 2, length, breadth, breadth / 3);
        context.fillStyle = context.strokeStyle = tone;
        if (foot.ns === "committed") context.fill();
        else context.stroke();
      });
    }
    const now = robot.status();
    if (now?.has_goal) cross(now.goal_x, now.goal_y, css("--way"));
    for (const [x, y] of go.goals) cross(x, y, css("--shown"));
    if (now)
      turned(now.x, now.y, now.yaw, () => {
        context.beginPath();
        context.moveTo(0.24 * scale, 0);
        context.lineTo(-0.14 * scale, 0.17 * scale);
        context.lineTo(-0.07 * scale, 0);
        context.lineTo(-0.14 * scale, -0.17 * scale);
        context.closePath();
        context.fillStyle = css("--robot");
        context.strokeStyle = css("--scene");
        context.lineWidth = 1.5;
        context.fill();
        context.stroke();
      });
    if (from) {
      cross(from.x, from.y, css("--shown"));
      if (to && Math.hypot(to.px - from.px, to.py - from.py) > kDrag) {
        context.beginPath();
        context.moveTo(from.px, from.py);
        context.lineTo(to.px, to.py);
        context.strokeStyle = css("--shown");
        context.lineWidth = 2.5;
        context.stroke();
      }
    }
    if (cursor && document.activeElement === canvas) cross(cursor.x, cursor.y, css("--accent"));
    ruler(width, height);
  };
  const cross = (x: number, y: number, tone: string): void => {
    const [left, top] = px(x, y);
    context.beginPath();
    context.arc(left, top, 7, 0, 2 * Math.PI);
    context.moveTo(left - 11, top);
    context.lineTo(left + 11, top);
    context.moveTo(left, top - 11);
    context.lineTo(left, top + 11);
    context.strokeStyle = tone;
    context.lineWidth = 2;
    context.stroke();
  };
  const ruler = (width: number, height: number): void => {
    context.fillStyle = context.strokeStyle = css("--text");
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(width - 14 - scale, height - 16);
    context.lineTo(width - 14, height - 16);
    context.stroke();
    context.font = "12px system-ui, sans-serif";
    context.textAlign = "right";
    context.fillText("1 m", width - 14, height - 22);
  };
  const redraw = (): void => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(draw);
  };

  robot.on("/map", () => { paint(); if (!fitted || robot.status()?.state === "look around") fit(); redraw(); });
  for (const topic of ["/plan", "/preview", "/footsteps", "/headway/status"] as const) robot.on(topic, redraw);
  new ResizeObserver(() => { fit(); redraw(); }).observe(canvas);
  window.addEventListener("theme", () => { paint(); redraw(); });
  byId("fit").addEventListener("click", () => { fit(); redraw(); });

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    from = at(event);
    to = undefined;
    redraw();
  });
  canvas.addEventListener("pointermove", (event) => { if (from) { to = at(event); redraw(); } });
  canvas.addEventListener("pointerup", (event) => {
    if (!from) return;
    const end = at(event);
    const begun = from;
    from = undefined;
    if (event.shiftKey) void go.add(begun.x, begun.y);
    else if (Math.hypot(end.px - begun.px, end.py - begun.py) > kDrag)
      void go.preview(begun.x, begun.y, Math.atan2(end.y - begun.y, end.x - begun.x));
    else void go.preview(begun.x, begun.y);
    redraw();
  });
  canvas.addEventListener("pointercancel", () => { from = undefined; redraw(); });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const before = at(event);
    scale = Math.min(Math.max(scale * Math.exp(-event.deltaY / 500), 8), 600);
    const after = at(event);
    centre = { x: centre.x + before.x - after.x, y: centre.y + before.y - after.y };
    redraw();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const now = robot.status();
    if (!now) return;
    cursor ??= { x: now.x + Math.cos(now.yaw), y: now.y + Math.sin(now.yaw) };
    const move = { ArrowLeft: [-kStep, 0], ArrowRight: [kStep, 0], ArrowUp: [0, kStep], ArrowDown: [0, -kStep] }[event.key];
    if (move) cursor = { x: cursor.x + move[0]!, y: cursor.y + move[1]! };
    else if (event.key === "Enter") void go.preview(cursor.x, cursor.y);
    else return;
    event.preventDefault();
    redraw();
  });
  return { at: px };
}

function rgb(text: string): [number, number, number] {
  const value = parseInt(text.slice(1), 16);
  return [value >> 16 & 255, value >> 8 & 255, value & 255];
}
