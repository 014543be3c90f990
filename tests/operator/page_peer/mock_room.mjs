// An invented robot in an invented room of 6 x 6 m: rays against boxes, a map that grows with what is seen, ways around
// what stands there. Plausible, not true.

export const kRoom = 3; // half an edge [m]
const kHigh = 2.4;
const boxes = [
  [[-3.06, -3.06, 0], [3.06, -3, 2.4], 120], [[-3.06, 3, 0], [3.06, 3.06, 2.4], 120],
  [[-3.06, -3, 0], [-3, 3, 2.4], 135], [[3, -3, 0], [3.06, 3, 2.4], 135],
  [[0.2, -1.6, 0], [0.9, -0.5, 0.75], 90], [[0.35, -1.3, 0.75], [0.7, -0.9, 1.1], 190],
  [[-0.3, 1.1, 0], [0.5, 1.9, 1.7], 165], [[1.9, 1.7, 0], [2.9, 2.8, 0.72], 105],
  [[1.9, -2.9, 0], [2.2, -2.2, 1.3], 150], [[-2.6, 2.0, 0], [-1.9, 2.6, 0.5], 175],
].map(([low, high, grey]) => ({ low, high, grey }));
export const obstacles = boxes.slice(4);

/** What a ray from `from` along `ray` hits first: its length in `ray`s, and how bright it is. */
export function hit(from, ray) {
  let [t, grey, face] = [Infinity, 0, 2];
  if (ray[2] < 0) [t, grey] = [-from[2] / ray[2], 70];
  for (const box of boxes) {
    const [at, axis] = enter(box, from, ray);
    if (at > 0.01 && at < t) [t, grey, face] = [at, box.grey, axis];
  }
  return { t, grey: grey * [0.8, 0.95, 1.1][face], point: from.map((v, i) => v + t * ray[i]) };
}

function enter({ low, high }, from, ray) {
  let [near, far, axis] = [-Infinity, Infinity, 0];
  for (let i = 0; i < 3; ++i) {
    let a = (low[i] - from[i]) / ray[i];
    let b = (high[i] - from[i]) / ray[i];
    if (a > b) [a, b] = [b, a];
    if (a > near) [near, axis] = [a, i];
    far = Math.min(far, b);
  }
  return near <= far ? [near, axis] : [-1, 0];
}

/** Voxels in bricks of 8 x 8 x 8; what no ray has met is unseen. */
export class VoxelMap {
  bricks = new Map();
  changed = new Set();
  last = {};

  constructor(resolution) {
    this.resolution = resolution;
  }

  mark(x, y, z, occupied) {
    const [i, j, k] = [x >> 3, y >> 3, z >> 3];
    const { last } = this;
    if (i !== last.i || j !== last.j || k !== last.k) this.last = this.brick(i, j, k);
    const { brick, key } = this.last;
    const row = 8 * (z & 7) + (y & 7);
    const bit = 1 << (x & 7);
    if (!(brick.unseen[row] & bit) && !(occupied && !(brick.occupied[row] & bit))) return;
    brick.unseen[row] &= ~bit;
    if (occupied) brick.occupied[row] |= bit;
    this.changed.add(key);
  }

  brick(i, j, k) {
    const key = `${i},${j},${k}`;
    let brick = this.bricks.get(key);
    if (!brick) this.bricks.set(key, (brick = { occupied: new Uint8Array(64), unseen: new Uint8Array(64).fill(255) }));
    return { i, j, k, key, brick };
  }

  see(from, ray, t, solid) {
    const r = this.resolution;
    const steps = Math.max(1, Math.ceil((Math.hypot(...ray) * t) / (r * 0.9)));
    const [dx, dy, dz] = ray.map((v) => (v * t) / steps);
    for (let n = 0; n < steps; ++n) {
      this.mark(Math.floor((from[0] + n * dx) / r), Math.floor((from[1] + n * dy) / r), Math.floor((from[2] + n * dz) / r), false);
    }
    const beyond = t + 0.02 / Math.hypot(...ray);
    if (solid) this.mark(...from.map((v, i) => Math.floor((v + beyond * ray[i]) / r)), true);
  }

  /** All that stands in the room, as if all had been seen. */
  fill() {
    const n = Math.floor(kRoom / this.resolution);
    const high = Math.floor(kHigh / this.resolution);
    for (let x = -n; x < n; ++x) {
      for (let y = -n; y < n; ++y) for (let z = 0; z < high; ++z) this.mark(x, y, z, false);
    }
    for (let x = -n; x < n; ++x) for (let y = -n; y < n; ++y) this.mark(x, y, -1, true);
    for (const box of boxes) this.shell(box);
  }

  shell({ low, high }) {
    const [a, b] = [low, high].map((corner) => corner.map((v) => Math.floor(v / this.resolution + 1e-6)));
    for (let x = a[0]; x < b[0]; ++x) {
      for (let y = a[1]; y < b[1]; ++y) for (let z = a[2]; z < b[2]; ++z) this.mark(x, y, z, true);
    }
  }

  message(keys, whole) {
    const bricks = keys.map((key) => this.bricks.get(key));
    const joined = (name) => Uint8Array.from({ length: 64 * bricks.length }, (_, i) => bricks[i >> 6][name][i & 63]);
    return {
      resolution: this.resolution, whole, keys: Int32Array.from(keys.flatMap((key) => key.split(",").map(Number))),
      occupied: joined("occupied"), unseen: joined("unseen"),
    };
  }
}

/** The floor map: -1 unseen, 0 free, 100 blocked. */
export class FloorMap {
  size = 132;
  cell = 0.05;
  origin = -3.3;
  data = new Int8Array(132 * 132).fill(-1);

  set(x, y, value) {
    const [i, j] = [x, y].map((v) => Math.floor((v - this.origin) / this.cell));
    if (i >= 0 && j >= 0 && i < this.size && j < this.size) this.data[j * this.size + i] = value;
  }

  see(from, { point }, low) {
    const steps = Math.ceil(Math.hypot(point[0] - from[0], point[1] - from[1]) / this.cell);
    for (let n = 8; n < steps; ++n) {
      const share = n / steps;
      if (from[2] + share * (point[2] - from[2]) < 0.4) {
        this.free(from[0] + share * (point[0] - from[0]), from[1] + share * (point[1] - from[1]));
      }
    }
    if (low) this.free(point[0], point[1]);
    else this.set(point[0] + 0.01 * Math.sign(point[0] - from[0]), point[1] + 0.01 * Math.sign(point[1] - from[1]), 100);
  }

  free(x, y) {
    const [i, j] = [x, y].map((v) => Math.floor((v - this.origin) / this.cell));
    const at = j * this.size + i;
    if (this.data[at] === -1) this.data[at] = 0;
  }
}

export function blocked(x, y, margin = 0.4) {
  if (Math.max(Math.abs(x), Math.abs(y)) > kRoom - margin) return true;
  return obstacles.some(({ low, high }) =>
    x > low[0] - margin && x < high[0] + margin && y > low[1] - margin && y < high[1] + margin);
}

/** Cells of 0.1 m, eight neighbours, breadth first from the goal; then shortened. Null: there is no way. */
export function findWay(from, to) {
  if (blocked(...to)) return null;
  const cell = ([x, y]) => Math.round(x * 10) * 1000 + Math.round(y * 10);
  const before = new Map([[cell(to), null]]);
  const queue = [to.map((v) => Math.round(v * 10) / 10)];
  while (queue.length && !before.has(cell(from))) {
    const at = queue.shift();
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [1, -1], [-1, 1], [-1, -1]]) {
      const next = [at[0] + dx / 10, at[1] + dy / 10];
      if (before.has(cell(next)) || blocked(...next)) continue;
      before.set(cell(next), at);
      queue.push(next);
    }
  }
  if (!before.has(cell(from))) return null;
  const way = [from];
  for (let at = before.get(cell(from)); at; at = before.get(cell(at))) way.push(at);
  return shorten([...way.slice(0, -1), to]);
}

const clear = (a, b) => {
  for (let s = 0; s <= 1; s += 0.02) if (blocked(a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), 0.38)) return false;
  return true;
};

function shorten(way) {
  const kept = [way[0]];
  for (let i = 0; i < way.length - 1; ) {
    let j = way.length - 1;
    while (j > i + 1 && !clear(way[i], way[j])) --j;
    kept.push(way[(i = j)]);
  }
  return kept;
}

export function nearestFree(to) {
  for (let r = 0.05; r < 3; r += 0.05) {
    for (let n = 0; n < 32; ++n) {
      const at = [to[0] + r * Math.cos((n * Math.PI) / 16), to[1] + r * Math.sin((n * Math.PI) / 16)];
      if (!blocked(...at, 0.41)) return at;
    }
  }
  return [0, 0];
}
