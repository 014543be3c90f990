// Draws the map of the floor with all that moves on it.
import { type Foot, cornersOf } from "../state/feet";
import type { FloorImage } from "../state/floor_image";
import type { Goal } from "../state/mission";
import type { SweptImage } from "../state/swept_image";
import type { OperatorStatus } from "../wire/messages";
import { themeColor } from "../ui/theme";
import type { MapView, Spot } from "./map_view";

export type MapContents = {
  floor: FloorImage;
  body: SweptImage | null;
  status: OperatorStatus | undefined;
  plan: readonly Spot[];
  preview: readonly Spot[];
  feet: readonly Foot[];
  pointed: Goal | null;
  tour: readonly Goal[];
  cross: Goal | null;
};

const kBody = { halfDepth: 0.2, halfWidth: 0.31 }; // [m], as the planner takes it

export function paintMap(context: CanvasRenderingContext2D, view: MapView, contents: MapContents): void {
  context.fillStyle = themeColor("map-unseen");
  context.fillRect(0, 0, view.width, view.height);
  if (contents.floor.known) paintFloor(context, view, contents.floor);
  if (contents.body) paintFloor(context, view, contents.body);
  paintGrid(context, view);
  paintWay(context, view, contents.plan, themeColor("plan"), 3);
  context.setLineDash([7, 5]);
  paintWay(context, view, contents.preview, themeColor("preview"), 4);
  context.setLineDash([]);
  for (const foot of contents.feet) paintFoot(context, view, foot);
  paintGoals(context, view, contents);
  if (contents.status) paintRobot(context, view, contents.status);
  if (contents.cross) paintCross(context, view, contents.cross);
  paintRule(context, view);
}

function paintFloor(context: CanvasRenderingContext2D, view: MapView, floor: FloorImage | SweptImage): void {
  const corner = view.toScreen({ x: floor.x, y: floor.y + floor.height });
  context.imageSmoothingEnabled = false;
  context.drawImage(floor.canvas, corner.x, corner.y, floor.width * view.scale, floor.height * view.scale);
}

function paintGrid(context: CanvasRenderingContext2D, view: MapView): void {
  const low = view.toFloor({ x: 0, y: view.height });
  const high = view.toFloor({ x: view.width, y: 0 });
  context.strokeStyle = themeColor("map-grid");
  context.lineWidth = 1;
  context.beginPath();
  for (let x = Math.ceil(low.x); x <= high.x; ++x) line(context, view.toScreen({ x, y: low.y }), view.toScreen({ x, y: high.y }));
  for (let y = Math.ceil(low.y); y <= high.y; ++y) line(context, view.toScreen({ x: low.x, y }), view.toScreen({ x: high.x, y }));
  context.stroke();
}

function line(context: CanvasRenderingContext2D, a: Spot, b: Spot): void {
  context.moveTo(Math.round(a.x) + 0.5, Math.round(a.y) + 0.5);
  context.lineTo(Math.round(b.x) + 0.5, Math.round(b.y) + 0.5);
}

function paintWay(context: CanvasRenderingContext2D, view: MapView, way: readonly Spot[], color: string, width: number): void {
  context.strokeStyle = color;
  context.lineWidth = width;
  context.lineJoin = "round";
  context.beginPath();
  for (const place of way) {
    const { x, y } = view.toScreen(place);
    context.lineTo(x, y);
  }
  context.stroke();
}

function paintFoot(context: CanvasRenderingContext2D, view: MapView, foot: Foot): void {
  const color = themeColor(foot.left ? "foot-left" : "foot-right");
  context.beginPath();
  for (const [x, y] of cornersOf(foot)) {
    const at = view.toScreen({ x, y });
    context.lineTo(at.x, at.y);
  }
  context.closePath();
  context.strokeStyle = context.fillStyle = color;
  context.lineWidth = 1.5;
  if (foot.committed) context.fill();
  context.stroke();
}

function paintGoals(context: CanvasRenderingContext2D, view: MapView, { status, pointed, tour }: MapContents): void {
  if (status?.has_goal) {
    const yaw = status.goal_has_yaw ? { yaw: status.goal_yaw } : {};
    paintGoal(context, view, { x: status.goal_x, y: status.goal_y, ...yaw }, themeColor("goal"));
  }
  if (pointed) paintGoal(context, view, pointed, themeColor("preview"));
  tour.forEach((goal, i) => paintNumber(context, view, goal, String(i + 1)));
}

function paintGoal(context: CanvasRenderingContext2D, view: MapView, goal: Goal, color: string): void {
  const { x, y } = view.toScreen(goal);
  context.strokeStyle = context.fillStyle = color;
  context.lineWidth = 3;
  circle(context, x, y, 9);
  context.stroke();
  circle(context, x, y, 2.5);
  context.fill();
  if (goal.yaw !== undefined) paintArrow(context, x, y, goal.yaw, 12, 34);
}

function circle(context: CanvasRenderingContext2D, x: number, y: number, radius: number): void {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
}

function paintArrow(context: CanvasRenderingContext2D, x: number, y: number, yaw: number, from: number, to: number): void {
  context.save();
  context.translate(x, y);
  context.rotate(-yaw);
  context.beginPath();
  context.moveTo(from, 0);
  context.lineTo(to - 6, 0);
  context.stroke();
  context.beginPath();
  context.moveTo(to, 0);
  context.lineTo(to - 10, -6);
  context.lineTo(to - 10, 6);
  context.fill();
  context.restore();
}

function paintNumber(context: CanvasRenderingContext2D, view: MapView, goal: Goal, text: string): void {
  const { x, y } = view.toScreen(goal);
  circle(context, x, y, 10);
  context.fillStyle = themeColor("preview");
  context.fill();
  context.fillStyle = "#1a1205";
  context.font = "600 12px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, x, y + 0.5);
}

/** From above: shoulders, and a wedge to where the head looks. */
function paintRobot(context: CanvasRenderingContext2D, view: MapView, status: OperatorStatus): void {
  const { x, y } = view.toScreen(status);
  context.save();
  context.translate(x, y);
  context.rotate(-status.yaw);
  context.scale(view.scale, view.scale);
  paintGaze(context, status.pan);
  context.beginPath();
  context.roundRect(-kBody.halfDepth, -kBody.halfWidth, 2 * kBody.halfDepth, 2 * kBody.halfWidth, 0.09);
  context.fillStyle = themeColor("robot-fill");
  context.strokeStyle = themeColor("robot");
  context.lineWidth = 2 / view.scale;
  context.fill();
  context.stroke();
  context.beginPath();
  context.moveTo(0.17, 0);
  context.lineTo(-0.08, -0.12);
  context.lineTo(-0.08, 0.12);
  context.fillStyle = themeColor("robot");
  context.fill();
  context.restore();
}

const kHalfField = (16.5 * Math.PI) / 180; // of the pair, as the paper measured it
function paintGaze(context: CanvasRenderingContext2D, pan: number): void {
  const shade = context.createRadialGradient(0, 0, 0.2, 0, 0, 2.4);
  shade.addColorStop(0, themeColor("gaze"));
  shade.addColorStop(1, themeColor("gaze-end"));
  context.beginPath();
  context.moveTo(0, 0);
  context.arc(0, 0, 2.4, -pan - kHalfField, -pan + kHalfField);
  context.fillStyle = shade;
  context.fill();
}

function paintCross(context: CanvasRenderingContext2D, view: MapView, cross: Goal): void {
  const { x, y } = view.toScreen(cross);
  context.strokeStyle = context.fillStyle = themeColor("text");
  context.lineWidth = 1.5;
  context.beginPath();
  line(context, { x: x - 14, y }, { x: x + 14, y });
  line(context, { x, y: y - 14 }, { x, y: y + 14 });
  context.stroke();
  if (cross.yaw !== undefined) paintArrow(context, x, y, cross.yaw, 0, 34);
}

function paintRule(context: CanvasRenderingContext2D, view: MapView): void {
  const y = view.height - 14;
  const right = view.width - 14;
  context.strokeStyle = context.fillStyle = themeColor("map-ink");
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(right - view.scale, y - 4);
  context.lineTo(right - view.scale, y);
  context.lineTo(right, y);
  context.lineTo(right, y - 4);
  context.stroke();
  context.font = "11px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "bottom";
  context.fillText("1 m", right - view.scale / 2, y - 3);
}
