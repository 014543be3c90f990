// The wire's messages as ros2msg texts, written from common_interfaces and the contract, not from the program.

const texts = {
  "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
  "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec",
  "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
  "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a",
  "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
  "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
  "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
  "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
  "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
  "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
  "geometry_msgs/TransformStamped": "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform",
  "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
  "nav_msgs/Path": "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses",
  "nav_msgs/MapMetaData": "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\ngeometry_msgs/Pose origin",
  "nav_msgs/OccupancyGrid": "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data",
  "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data",
  "sensor_msgs/PointField": "string name\nuint32 offset\nuint8 datatype\nuint32 count",
  "sensor_msgs/PointCloud2":
    "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n" +
    "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense",
  "visualization_msgs/UVCoordinate": "float32 u\nfloat32 v",
  "visualization_msgs/MeshFile": "string filename\nuint8[] data",
  "visualization_msgs/Marker":
    "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n" +
    "geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\nbool frame_locked\n" +
    "geometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n" +
    "sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n" +
    "string mesh_resource\nvisualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials",
  "visualization_msgs/MarkerArray": "visualization_msgs/Marker[] markers",
  "headway_msgs/Voxels": "float64 resolution\nbool whole\nint32[] keys\nuint8[] occupied\nuint8[] unseen",
  "headway_msgs/ViewerStatus": "uint32 number\nstring name\nstring role\nstring address\nbool has_control\nuint64 sent\nuint64 missed",
  "headway_msgs/OperatorStatus":
    "int64 stamp_ns\nuint32 number\nstring state\nstring reason\nstring safety\nstring safety_reason\nfloat64 x\nfloat64 y\n" +
    "float64 yaw\nfloat64 pan\nfloat64 tilt\nfloat64 pan_low\nfloat64 pan_high\nfloat64 tilt_low\nfloat64 tilt_high\n" +
    "bool at_rest\nbool has_goal\nfloat64 goal_x\nfloat64 goal_y\nbool goal_has_yaw\nfloat64 goal_yaw\nbool paused\n" +
    "string next\nstring head\nstring control_computer\nstring frame_level\nuint64 frames\nuint64 frames_lost\n" +
    "uint64 frames_no_pose\nuint64 frames_unusable\nuint64 frames_late\nfloat64 see_ms\nfloat64 map_ms\nfloat64 floor_ms\n" +
    "float64 plan_ms\nfloat64 frame_age_ms\nuint64 bus_cycles\nuint64 bus_missed\nfloat64 bus_wake_max_us\n" +
    "float64 bus_load\nuint32 plans\nuint32 replans\nbool recording\nstring lease_holder\nuint32 lease\nbool simulated\n" +
    "float64 speed\nuint32 clients\nuint32 tour_left\nbool exploring\nheadway_msgs/ViewerStatus[] viewers\nstring record_folder\nstring record_file\n" +
    "float64 record_mib\nuint64 record_dropped\nstring record_fault\nstring recording_name\nfloat64 played_at\n" +
    "float64 played_from\nfloat64 played_to\nfloat64 played_speed\nbool played_paused",
};

const primitive = /^(bool|u?int\d+|float\d+|string)$/;

function needs(name, found = new Set()) {
  for (const line of texts[name].split("\n")) {
    const type = line.split(" ")[0].replace(/\[.*$/, "");
    if (primitive.test(type) || found.has(type)) continue;
    found.add(type);
    needs(type, found);
  }
  return found;
}

/** The text of a type like "nav_msgs/msg/Path", with all that it needs. */
export function schema(type) {
  const name = type.replace("/msg/", "/");
  const parts = [...needs(name)].map((other) => `${"=".repeat(80)}\nMSG: ${other}\n${texts[other]}\n`);
  return `${texts[name]}\n${parts.join("")}`;
}

export const topics = [
  ["/headway/status", "headway_msgs/msg/OperatorStatus", true],
  ["/camera/left", "sensor_msgs/msg/CompressedImage", false],
  ["/points", "sensor_msgs/msg/PointCloud2", false],
  ["/map", "nav_msgs/msg/OccupancyGrid", true],
  ["/plan", "nav_msgs/msg/Path", true],
  ["/footsteps", "visualization_msgs/msg/MarkerArray", true],
  ["/tf", "tf2_msgs/msg/TFMessage", true],
  ["/field", "visualization_msgs/msg/MarkerArray", true],
  ["/preview", "nav_msgs/msg/Path", true],
  ["/voxels", "headway_msgs/msg/Voxels", true],
];
