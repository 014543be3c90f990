// The messages' fields that this page reads.
export type Vector = { x: number; y: number; z: number };
export type Quaternion = Vector & { w: number };
export type Pose = { position: Vector; orientation: Quaternion };

export type Status = {
  number: number; state: string; reason: string; safety: string; safety_reason: string;
  x: number; y: number; yaw: number; pan: number; tilt: number;
  pan_low: number; pan_high: number; tilt_low: number; tilt_high: number;
  at_rest: boolean; has_goal: boolean; goal_x: number; goal_y: number; goal_has_yaw: boolean; goal_yaw: number;
  paused: boolean; next: string; head: string; control_computer: string; frame_level: string;
  frames: bigint; frames_lost: bigint; frames_no_pose: bigint; frames_unusable: bigint; frames_late: bigint;
  see_ms: number; map_ms: number; floor_ms: number; plan_ms: number; frame_age_ms: number;
  bus_cycles: bigint; bus_missed: bigint; bus_wake_max_us: number; bus_load: number;
  plans: number; replans: number; recording: boolean; lease_holder: string; lease: number;
  simulated: boolean; speed: number; clients: number; tour_left: number; exploring: boolean;
  recording_name: string; played_at: number; played_from: number; played_to: number;
  played_speed: number; played_paused: boolean;
};

export type Grid = {
  info: { resolution: number; width: number; height: number; origin: Pose };
  data: Int8Array;
};
export type Path = { poses: { pose: Pose }[] };
export type Marker = {
  header: { frame_id: string };
  ns: string; id: number; type: number; action: number; pose: Pose; scale: Vector;
  color: { r: number; g: number; b: number; a: number };
  points: Vector[];
};
export type Markers = { markers: Marker[] };
export type Transforms = {
  transforms: { child_frame_id: string; transform: { translation: Vector; rotation: Quaternion } }[];
};
export type Picture = { format: string; data: Uint8Array };
export type Cloud = { width: number; point_step: number; data: Uint8Array };
export type Voxels = {
  resolution: number; whole: boolean; keys: Int32Array; occupied: Uint8Array; unseen: Uint8Array;
};

export const kTopics = ["/headway/status", "/camera/left", "/points", "/map", "/plan", "/footsteps", "/tf", "/field",
  "/preview", "/voxels"] as const;
export type Topic = (typeof kTopics)[number];

export type Messages = {
  "/headway/status": Status; "/camera/left": Picture; "/points": Cloud; "/map": Grid; "/plan": Path;
  "/footsteps": Markers; "/tf": Transforms; "/field": Markers; "/preview": Path; "/voxels": Voxels;
};

export function yawOf(q: Quaternion): number {
  return Math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
}
