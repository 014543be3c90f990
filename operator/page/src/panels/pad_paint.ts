// Draws the head's pad: its limits, nine viewpoints, where it looks, and where it would.
import type { HeadPose } from "../state/app";
import type { OperatorStatus } from "../wire/messages";
import { themeColor } from "../ui/theme";

export type Limits = Pick<OperatorStatus, "pan_low" | "pan_high" | "tilt_low" | "tilt_high">;
const kMargin = 16;

/** Left on the pad is left for the robot: pan grows to the left, tilt grows downwards. */
export class PadScale {
  constructor(private readonly limits: Limits, private readonly width: number, private readonly height: number) {}

  x(pan: number): number {
    const { pan_low, pan_high } = this.limits;
    return kMargin + ((pan_high - pan) / (pan_high - pan_low)) * (this.width - 2 * kMargin);
  }

  y(tilt: number): number {
    const { tilt_low, tilt_high } = this.limits;
    return kMargin + ((tilt - tilt_low) / (tilt_high - tilt_low)) * (this.height - 2 * kMargin);
  }

  pose(x: number, y: number): HeadPose {
    const { pan_low, pan_high, tilt_low, tilt_high } = this.limits;
    const u = (x - kMargin) / (this.width - 2 * kMargin);
    const v = (y - kMargin) / (this.height - 2 * kMargin);
    return clampPose({ pan: pan_high - u * (pan_high - pan_low), tilt: tilt_low + v * (tilt_high - tilt_low) }, this.limits);
  }
}

export function clampPose({ pan, tilt }: HeadPose, limits: Limits): HeadPose {
  const clamp = (value: number, low: number, high: number) => Math.min(high, Math.max(low, value));
  return { pan: clamp(pan, limits.pan_low, limits.pan_high), tilt: clamp(tilt, limits.tilt_low, limits.tilt_high) };
}

/** The middles of nine equal parts of all directions, from upper left to lower right. */
export function viewpoints({ pan_low, pan_high, tilt_low, tilt_high }: Limits): HeadPose[] {
  return Array.from({ length: 9 }, (_, n) => ({
    pan: pan_high - ((n % 3) + 0.5) * ((pan_high - pan_low) / 3),
    tilt: tilt_low + (Math.floor(n / 3) + 0.5) * ((tilt_high - tilt_low) / 3),
  }));
}

export function paintPad(
  context: CanvasRenderingContext2D, width: number, height: number, limits: Limits, now: HeadPose, aim: HeadPose | null,
  aimColor: string,
): void {
  const scale = new PadScale(limits, width, height);
  context.clearRect(0, 0, width, height);
  paintFrame(context, scale, limits);
  viewpoints(limits).forEach((pose, n) => paintViewpoint(context, scale, pose, String(n + 1)));
  if (aim) paintAim(context, scale, now, aim, aimColor);
  context.fillStyle = themeColor("field");
  dot(context, scale.x(now.pan), scale.y(now.tilt), 7);
}

function paintFrame(context: CanvasRenderingContext2D, scale: PadScale, limits: Limits): void {
  const [left, right, top, bottom] = [scale.x(limits.pan_high), scale.x(limits.pan_low), scale.y(limits.tilt_low), scale.y(limits.tilt_high)];
  context.lineWidth = 1;
  context.strokeStyle = themeColor("line-strong");
  context.strokeRect(left, top, right - left, bottom - top);
  context.strokeStyle = themeColor("line");
  context.beginPath();
  context.moveTo(scale.x(0), top);
  context.lineTo(scale.x(0), bottom);
  context.moveTo(left, scale.y(0));
  context.lineTo(right, scale.y(0));
  context.stroke();
}

function paintViewpoint(context: CanvasRenderingContext2D, scale: PadScale, pose: HeadPose, text: string): void {
  context.font = "12px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillStyle = themeColor("muted");
  context.strokeStyle = themeColor("line-strong");
  context.beginPath();
  context.arc(scale.x(pose.pan), scale.y(pose.tilt), 11, 0, 2 * Math.PI);
  context.stroke();
  context.fillText(text, scale.x(pose.pan), scale.y(pose.tilt) + 0.5);
}

function paintAim(context: CanvasRenderingContext2D, scale: PadScale, now: HeadPose, aim: HeadPose, color: string): void {
  const [x, y] = [scale.x(aim.pan), scale.y(aim.tilt)];
  context.strokeStyle = color;
  context.lineWidth = 2;
  context.setLineDash([4, 4]);
  context.beginPath();
  context.moveTo(scale.x(now.pan), scale.y(now.tilt));
  context.lineTo(x, y);
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  context.arc(x, y, 9, 0, 2 * Math.PI);
  context.stroke();
}

function dot(context: CanvasRenderingContext2D, x: number, y: number, radius: number): void {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
}
