// The messages of the wire, field by field as operator/messages.h and ROS 2's common_interfaces define them.
import {
  type Message, bool, bytes, float32, float64, int32, int32s, int64, int8s, list, string, struct, uint32, uint64, uint8,
} from "./cdr";

const time = struct({ sec: int32, nanosec: uint32 });
const header = struct({ stamp: time, frame_id: string });
const point = struct({ x: float64, y: float64, z: float64 });
const quaternion = struct({ x: float64, y: float64, z: float64, w: float64 });
const pose = struct({ position: point, orientation: quaternion });
const color = struct({ r: float32, g: float32, b: float32, a: float32 });

export const compressedImage = struct({ header, format: string, data: bytes });

const pointField = struct({ name: string, offset: uint32, datatype: uint8, count: uint32 });
export const pointCloud2 = struct({
  header, height: uint32, width: uint32, fields: list(pointField), is_bigendian: bool, point_step: uint32,
  row_step: uint32, data: bytes, is_dense: bool,
});

const mapMetaData = struct({ map_load_time: time, resolution: float32, width: uint32, height: uint32, origin: pose });
export const occupancyGrid = struct({ header, info: mapMetaData, data: int8s });

export const path = struct({ header, poses: list(struct({ header, pose })) });

const transform = struct({ translation: point, rotation: quaternion });
export const tfMessage = struct({
  transforms: list(struct({ header, child_frame_id: string, transform })),
});

const marker = struct({
  header, ns: string, id: int32, type: int32, action: int32, pose, scale: point, color,
  lifetime: struct({ sec: int32, nanosec: uint32 }), frame_locked: bool, points: list(point), colors: list(color),
  texture_resource: string, texture: compressedImage, uv_coordinates: list(struct({ u: float32, v: float32 })),
  text: string, mesh_resource: string, mesh_file: struct({ filename: string, data: bytes }),
  mesh_use_embedded_materials: bool,
});
export const markerArray = struct({ markers: list(marker) });

export const voxels = struct({ resolution: float64, whole: bool, keys: int32s, occupied: bytes, unseen: bytes });

const viewerStatus = struct({
  number: uint32, name: string, role: string, address: string, has_control: bool, sent: uint64, missed: uint64,
});

export const operatorStatus = struct({
  stamp_ns: int64, number: uint32, state: string, reason: string, safety: string, safety_reason: string,
  x: float64, y: float64, yaw: float64, pan: float64, tilt: float64,
  pan_low: float64, pan_high: float64, tilt_low: float64, tilt_high: float64,
  at_rest: bool, has_goal: bool, goal_x: float64, goal_y: float64, goal_has_yaw: bool, goal_yaw: float64,
  paused: bool, next: string, head: string, control_computer: string, frame_level: string,
  frames: uint64, frames_lost: uint64, frames_no_pose: uint64, frames_unusable: uint64, frames_late: uint64,
  see_ms: float64, map_ms: float64, floor_ms: float64, plan_ms: float64, frame_age_ms: float64,
  bus_cycles: uint64, bus_missed: uint64, bus_wake_max_us: float64, bus_load: float64,
  plans: uint32, replans: uint32, recording: bool, lease_holder: string, lease: uint32,
  simulated: bool, speed: float64, clients: uint32, tour_left: uint32, exploring: bool,
  viewers: list(viewerStatus),
  record_folder: string, record_file: string, record_mib: float64, record_dropped: uint64, record_fault: string,
  recording_name: string, played_at: float64, played_from: float64, played_to: float64, played_speed: float64, played_paused: bool,
});

export type Header = Message<typeof header>;
export type Pose = Message<typeof pose>;
export type CompressedImage = Message<typeof compressedImage>;
export type PointCloud2 = Message<typeof pointCloud2>;
export type OccupancyGrid = Message<typeof occupancyGrid>;
export type Path = Message<typeof path>;
export type TfMessage = Message<typeof tfMessage>;
export type Marker = Message<typeof marker>;
export type MarkerArray = Message<typeof markerArray>;
export type Voxels = Message<typeof voxels>;
export type ViewerStatus = Message<typeof viewerStatus>;
export type OperatorStatus = Message<typeof operatorStatus>;

export const markerType = { cube: 1, triangleList: 11 } as const;
export const markerAction = { add: 0, delete: 2, deleteAll: 3 } as const;
