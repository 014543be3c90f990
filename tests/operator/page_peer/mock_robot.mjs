// The invented robot: turns its head, sees, walks along ways, and says so in the wire's messages.
import { greyPng } from "./mock_picture.mjs";
import { FloorMap, VoxelMap, findWay, hit, nearestFree } from "./mock_room.mjs";

const kSpeed = 0.35; // [m/s]
const kTurn = 1.2; // [rad/s]
const kLimits = { pan_low: -0.785, pan_high: 0.785, tilt_low: -0.524, tilt_high: 0.785 };
const kDown = (10 * Math.PI) / 180;
const kNoise = 0.25 / (574 * 0.144);
const kView = { width: 102, height: 144, focal: 172 };
const near = (v, to, step) => v + Math.max(-step, Math.min(step, to - v));
const wrap = (a) => a - 2 * Math.PI * Math.round(a / (2 * Math.PI));
const kStart = [-2, -0.6];

const multiply = (a, b) => a.map((row) => b[0].map((_, j) => row.reduce((s, v, k) => s + v * b[k][j], 0)));
const apply = (m, v) => m.map((row) => row.reduce((s, x, i) => s + x * v[i], 0));
const about = { y: (a) => [[Math.cos(a), 0, Math.sin(a)], [0, 1, 0], [-Math.sin(a), 0, Math.cos(a)]],
                z: (a) => [[Math.cos(a), -Math.sin(a), 0], [Math.sin(a), Math.cos(a), 0], [0, 0, 1]] };
const kOptical = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]];

function quaternion(m) {
  const w = Math.sqrt(Math.max(0, 1 + m[0][0] + m[1][1] + m[2][2])) / 2;
  const part = (a, b, c) => (Math.sqrt(Math.max(0, 1 + a)) / 2) * Math.sign(b - c || 1);
  return { w, x: part(m[0][0] - m[1][1] - m[2][2], m[2][1], m[1][2]), y: part(-m[0][0] + m[1][1] - m[2][2], m[0][2], m[2][0]),
           z: part(-m[0][0] - m[1][1] + m[2][2], m[1][0], m[0][1]) };
}

const yawed = (yaw) => ({ x: 0, y: 0, z: Math.sin(yaw / 2), w: Math.cos(yaw / 2) });

export class MockRobot {
  now = 0; // seconds of the run
  number = 0;
  state = "wait for goal";
  reason = "";
  next = "It waits for a goal.";
  x = kStart[0];
  y = kStart[1];
  yaw = 0;
  pan = 0;
  tilt = 0.2;
  aim = { pan: 0, tilt: 0.2 };
  looks = [];
  goal = null;
  way = [];
  tour = [];
  paused = false;
  recording = false;
  viewers = [];
  exploring = false;
  plans = 0;
  replans = 0;
  frames = 0;
  lease = { holder: "", number: 0 };
  clients = 0;
  floor = new FloorMap();
  preview = [];
  safety = "Ready";

  constructor({ resolution = 0.05, filled = false } = {}) {
    this.voxels = new VoxelMap(resolution);
    if (filled) this.voxels.fill();
    for (let r = 0; r < 0.8; r += 0.03) {
      for (let a = 0; a < 2 * Math.PI; a += 0.03) this.floor.free(this.x + r * Math.cos(a), this.y + r * Math.sin(a));
    }
    this.lookAround();
  }

  get atRest() {
    return this.state !== "walk";
  }

  lookAround() {
    for (const tilt of [-0.3, 0.13, 0.57]) for (const pan of [0.52, 0, -0.52]) this.looks.push({ pan, tilt });
    this.state = "look around";
    this.next = "It looks in nine directions, then waits for a goal.";
  }

  stop(why = "the operator stopped it") {
    [this.way, this.tour, this.goal, this.looks, this.exploring] = [[], [], null, [], false];
    [this.state, this.reason, this.next, this.paused] = ["stopped", why, "It stands, and waits for a goal.", false];
  }

  walk(way, goal) {
    [this.way, this.goal, this.paused, this.looks] = [way.slice(1), goal, false, []];
    [this.state, this.reason, this.safety] = ["walk", "", "Active"];
    this.plans++;
  }

  step(dt, held) {
    this.now += dt;
    this.pan = near(this.pan, this.aim.pan, kTurn * dt);
    this.tilt = near(this.tilt, this.aim.tilt, kTurn * dt);
    const looks = Math.hypot(this.pan - this.aim.pan, this.tilt - this.aim.tilt) < 0.01;
    if (this.looks.length && looks && this.now > (this.lookUntil ?? 0)) this.nextLook();
    if (this.state === "walk" && !this.paused && !held) this.advance(dt);
  }

  nextLook() {
    this.aim = this.looks.shift();
    this.lookUntil = this.now + 0.5;
    if (this.looks.length) return;
    [this.state, this.next] = ["wait for goal", "It waits for a goal."];
  }

  advance(dt) {
    const to = this.way[0];
    if (!to) return this.arrive();
    const [dx, dy] = [to[0] - this.x, to[1] - this.y];
    const left = Math.hypot(dx, dy);
    if (left < 0.02) return void this.way.shift();
    const turn = wrap(Math.atan2(dy, dx) - this.yaw);
    this.yaw = wrap(this.yaw + near(0, turn, kTurn * dt));
    if (Math.abs(turn) > 0.3) return;
    this.x += (dx / left) * Math.min(left, kSpeed * dt);
    this.y += (dy / left) * Math.min(left, kSpeed * dt);
    const steps = Math.ceil(this.remaining() / 0.2);
    this.next = `It takes ${steps} more steps to ${this.goal.x.toFixed(2)}, ${this.goal.y.toFixed(2)} m, watching the way ahead.`;
  }

  remaining() {
    return [[this.x, this.y], ...this.way].reduce((sum, p, i, all) => (i ? sum + Math.hypot(p[0] - all[i - 1][0], p[1] - all[i - 1][1]) : 0), 0);
  }

  arrive() {
    if (this.goal?.yaw !== undefined) this.yaw = this.goal.yaw;
    const next = this.tour.shift();
    const way = next && findWay([this.x, this.y], next);
    if (way) return this.walk(way, { x: next[0], y: next[1] });
    [this.state, this.next, this.goal, this.safety] = ["arrived", "It stands at its goal, and waits for another.", null, "Ready"];
  }

  /** A plan, or why there is none. */
  plan(to) {
    const way = findWay([this.x, this.y], to);
    if (!way) return { ok: false, error: "the goal lies in an obstacle or too near to one", nearest: nearestFree(to) };
    const metres = way.reduce((sum, p, i) => (i ? sum + Math.hypot(p[0] - way[i - 1][0], p[1] - way[i - 1][1]) : 0), 0);
    return { ok: true, metres, seconds: metres / kSpeed + way.length, steps: Math.ceil(metres / 0.2) + 2,
             way: way.map(([x, y]) => [x, y, 0]) };
  }

  rotation() {
    return multiply(multiply(about.z(this.yaw + this.pan), about.y(this.tilt + kDown)), kOptical);
  }

  eye() {
    const head = apply(multiply(about.z(this.yaw + this.pan), about.y(this.tilt)), [0.035, 0.072, 0.045]);
    return [this.x + head[0], this.y + head[1], 1.36 + head[2] + this.bob()];
  }

  bob() {
    return this.atRest || this.paused ? 0 : 0.008 * Math.sin(this.now * 8);
  }

  /** One look: points for the cloud, and what the maps learn of it. Also the picture, for nothing. */
  see() {
    const [from, turn] = [this.eye(), this.rotation()];
    const { width, height, focal } = kView;
    const pixels = new Uint8Array(width * height);
    const points = [];
    for (let v = 0; v < height; ++v) {
      for (let u = 0; u < width; ++u) {
        const ray = apply(turn, [(u - width / 2) / focal, (v - height / 2) / focal, 1]);
        const found = hit(from, ray);
        const fleck = 0.82 + 0.18 * Math.abs(Math.sin(found.point[0] * 31 + found.point[2] * 17) * Math.sin(found.point[1] * 29));
        pixels[v * width + u] = Math.min(255, found.grey * fleck + 8 * Math.random());
        if (found.t < 6 && found.t > 0.6) points.push(this.point(found, ray, pixels[v * width + u]));
        if (u % 3 === this.frames % 3 && v % 3 === Math.floor(this.frames / 3) % 3) this.learn(from, ray, found);
      }
    }
    this.frames++;
    return { points, picture: greyPng(width, height, pixels) };
  }

  point({ t, point }, ray, grey) {
    const sigma = kNoise * t * t;
    const off = sigma * (Math.random() + Math.random() + Math.random() - 1.5) * 1.4;
    return [...point.map((p, i) => p + off * ray[i]), sigma, grey];
  }

  learn(from, ray, found) {
    const reached = Math.min(found.t, 6);
    this.voxels.see(from, ray, reached, found.t < 6);
    if (found.t < 6) this.floor.see(from, found, found.point[2] < 0.06);
  }

  header(frame_id = "map") {
    return { stamp: { sec: Math.floor(this.now), nanosec: Math.floor((this.now % 1) * 1e9) }, frame_id };
  }

  status() {
    const wave = (low, high, w) => low + (high - low) * (0.5 + 0.5 * Math.sin(this.now * w)) * (0.8 + 0.4 * Math.random());
    const goal = this.goal;
    return {
      stamp_ns: BigInt(Math.round(this.now * 1e9)), number: ++this.number, state: this.state, reason: this.reason,
      safety: this.safety, safety_reason: "", x: this.x, y: this.y, yaw: this.yaw, pan: this.pan, tilt: this.tilt,
      ...kLimits, at_rest: this.atRest, has_goal: goal !== null, goal_x: goal?.x ?? 0, goal_y: goal?.y ?? 0,
      goal_has_yaw: goal?.yaw !== undefined, goal_yaw: goal?.yaw ?? 0, paused: this.paused,
      next: this.paused ? "Nothing: it is paused, and keeps its goal." : this.next, head: "ready", control_computer: "ready",
      frame_level: "all frames", frames: BigInt(this.frames), frames_lost: 2n, frames_no_pose: 1n, frames_unusable: 0n,
      frames_late: 3n, see_ms: wave(31, 42, 0.3), map_ms: wave(9, 14, 0.5), floor_ms: wave(4, 6, 0.7),
      plan_ms: this.atRest ? 0 : wave(12, 25, 0.9), frame_age_ms: 60 + 90 * ((this.now * 7) % 1),
      bus_cycles: BigInt(Math.floor(this.now * 200)), bus_missed: BigInt(Math.floor(this.now / 40)),
      bus_wake_max_us: wave(35, 80, 1.1), bus_load: 0.11, plans: this.plans, replans: this.replans,
      recording: this.recording, lease_holder: this.lease.holder, lease: this.lease.number, simulated: true, speed: 1,
      clients: this.clients, tour_left: this.tour.length, exploring: this.exploring, viewers: this.viewers, record_folder: "/rec",
      record_file: this.recording ? "/rec/recording_0001_00.mcap" : "", record_mib: this.recording ? 12.3 : 0,
      record_dropped: 0n, record_fault: "", recording_name: "", played_at: 0, played_from: 0, played_to: 0, played_speed: 1,
      played_paused: false,
    };
  }

  tf() {
    const to = (child_frame_id, [x, y, z], rotation) =>
      ({ header: this.header(), child_frame_id, transform: { translation: { x, y, z }, rotation } });
    return { transforms: [
      to("base", [this.x, this.y, 0], yawed(this.yaw)), to("chest", [this.x, this.y, 1 + this.bob()], yawed(this.yaw)),
      to("camera_left", this.eye(), quaternion(this.rotation())),
    ] };
  }

  pathOf(way) {
    return { header: this.header(), poses: way.map(([x, y]) =>
      ({ header: this.header(), pose: { position: { x, y, z: 0 }, orientation: yawed(0) } })) };
  }

  map() {
    const { size, cell, origin, data } = this.floor;
    return { header: this.header(), info: { map_load_time: this.header().stamp, resolution: cell, width: size, height: size,
      origin: { position: { x: origin, y: origin, z: 0 }, orientation: yawed(0) } }, data };
  }

  pointCloud(points) {
    const data = Buffer.alloc(20 * points.length);
    points.forEach(([x, y, z, sigma, grey], i) => {
      [x, y, z].forEach((v, k) => data.writeFloatLE(v, 20 * i + 4 * k));
      data.writeUInt32LE((grey << 16) | (grey << 8) | grey, 20 * i + 12);
      data.writeFloatLE(sigma, 20 * i + 16);
    });
    const fields = ["x", "y", "z", "rgb", "sigma"].map((name, i) => ({ name, offset: 4 * i, datatype: 7, count: 1 }));
    return { header: this.header(), height: 1, width: points.length, fields, is_bigendian: false, point_step: 20,
             row_step: data.length, data: new Uint8Array(data), is_dense: true };
  }

  marker(more) {
    return { header: this.header(), ns: "", id: 0, type: 1, action: 0,
      pose: { position: { x: 0, y: 0, z: 0 }, orientation: yawed(0) }, scale: { x: 1, y: 1, z: 1 },
      color: { r: 0, g: 0, b: 1, a: 1 }, lifetime: { sec: 0, nanosec: 0 }, frame_locked: false, points: [], colors: [],
      texture_resource: "", texture: { header: this.header(""), format: "", data: new Uint8Array(0) }, uv_coordinates: [],
      text: "", mesh_resource: "", mesh_file: { filename: "", data: new Uint8Array(0) },
      mesh_use_embedded_materials: false, ...more };
  }

  footsteps() {
    const markers = [this.marker({ action: 3 })];
    let [x, y, left] = [this.x, this.y, this.plans % 2 === 0];
    for (const to of this.way) {
      const yaw = Math.atan2(to[1] - y, to[0] - x);
      while (Math.hypot(to[0] - x, to[1] - y) > 0.12) {
        [x, y] = [x + 0.2 * Math.cos(yaw), y + 0.2 * Math.sin(yaw)];
        markers.push(this.foot(x, y, yaw, (left = !left), markers.length));
      }
    }
    return { markers };
  }

  foot(x, y, yaw, left, id) {
    const side = left ? 0.095 : -0.095;
    return this.marker({ ns: id < 3 ? "committed" : "planned", id, color: left ? { r: 0.1, g: 0.4, b: 0.8, a: 1 } : { r: 0.1, g: 0.6, b: 0.2, a: 1 },
      pose: { position: { x: x - side * Math.sin(yaw), y: y + side * Math.cos(yaw), z: 0 }, orientation: yawed(yaw) },
      scale: { x: 0.217, y: 0.138, z: 0.02 } });
  }

  field() {
    const body = (ns, far) => {
      const corner = (z, i) => ({ x: (i & 1 ? 0.296 : -0.296) * z + (i & 1 ? 0 : 0.144 * 0.6), y: (i & 2 ? 0.41 : -0.41) * z, z });
      const at = (i) => corner(i < 4 ? 0.8 : far, i & 3);
      const faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
      const points = faces.flatMap(([a, b, c, d]) => [a, b, c, a, c, d].map(at));
      return this.marker({ header: this.header("camera_left"), ns, type: 11, points });
    };
    const reach = (sigma) => Math.sqrt(sigma / kNoise);
    return { markers: [this.marker({ action: 3 }), body("rig", 6), ...[5, 10, 20, 50].map((mm) => body(`${mm} mm`, reach(mm / 1000)))] };
  }
}
