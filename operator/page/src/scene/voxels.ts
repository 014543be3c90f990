// Occupied voxels, and where seen space borders on unseen, as the faces that can be seen: in chunks, so that a change
// costs only what is near it.
import * as THREE from "three";
import type { Voxels } from "../wire/messages";
import { viridis } from "./colours";

const kEdge = 8; // of a brick [voxels]
const kChunk = 4; // of a chunk [bricks]
const kTop = 1.8; // the colour's end [m]
const kBudget = 12; // of meshing, each time [ms]

type Brick = { occupied: Uint8Array; unseen: Uint8Array };
type Chunk = { full?: THREE.Mesh; border?: THREE.Mesh };

// Axis, direction, and the two axes of the face such that it turns outward.
const kFaces = [
  [0, 1, 1, 2], [0, -1, 2, 1], [1, 1, 2, 0], [1, -1, 0, 2], [2, 1, 0, 1], [2, -1, 1, 0],
] as const;

class Faces {
  positions: number[] = [];
  colours: number[] = [];
  index: number[] = [];

  add(x: number, y: number, z: number, face: (typeof kFaces)[number], edge: number, colour: readonly number[]): void {
    const [axis, direction, u, v] = face;
    const first = this.positions.length / 3;
    for (const [du, dv] of [[0, 0], [1, 0], [1, 1], [0, 1]] as const) {
      const corner = [x, y, z];
      corner[axis]! += direction > 0 ? 1 : 0;
      corner[u]! += du;
      corner[v]! += dv;
      this.positions.push(corner[0]! * edge, corner[1]! * edge, corner[2]! * edge);
      this.colours.push(colour[0]!, colour[1]!, colour[2]!);
    }
    this.index.push(first, first + 1, first + 2, first, first + 2, first + 3);
  }

  mesh(material: THREE.Material): THREE.Mesh | undefined {
    if (this.index.length === 0) return undefined;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(this.positions, 3));
    geometry.setAttribute("color", new THREE.Float32BufferAttribute(this.colours, 3));
    geometry.setIndex(this.index);
    const mesh = new THREE.Mesh(geometry, material);
    mesh.matrixAutoUpdate = false;
    return mesh;
  }
}

export class VoxelLayer {
  readonly full = new THREE.Group();
  readonly border = new THREE.Group();
  occupied = 0;
  private bricks = new Map<string, Brick>();
  private chunks = new Map<string, Chunk>();
  private dirty = new Set<string>();
  private edge = 0.05;
  private fullMaterial = new THREE.MeshBasicMaterial({ vertexColors: true });
  private borderMaterial = new THREE.MeshBasicMaterial({
    vertexColors: true, transparent: true, opacity: 0.16, depthWrite: false, side: THREE.DoubleSide,
  });

  take(news: Voxels): void {
    this.edge = news.resolution;
    if (news.whole) this.forget();
    for (let i = 0; i < news.keys.length / 3; ++i) {
      const [x, y, z] = [news.keys[3 * i]!, news.keys[3 * i + 1]!, news.keys[3 * i + 2]!];
      const key = `${x},${y},${z}`;
      const old = this.bricks.get(key);
      const brick = {
        occupied: news.occupied.slice(64 * i, 64 * i + 64),
        unseen: news.unseen.slice(64 * i, 64 * i + 64),
      };
      this.bricks.set(key, brick);
      this.occupied += count(brick.occupied) - (old ? count(old.occupied) : 0);
      this.mark(x, y, z);
    }
  }

  /** Meshes some of what has changed; true while there is more. */
  work(): boolean {
    const begun = performance.now();
    for (const key of this.dirty) {
      this.dirty.delete(key);
      this.mesh(key);
      if (performance.now() - begun > kBudget) break;
    }
    return this.dirty.size > 0;
  }

  private forget(): void {
    this.bricks.clear();
    this.occupied = 0;
    for (const key of this.chunks.keys()) this.dirty.add(key);
  }

  private mark(x: number, y: number, z: number): void {
    for (const [dx, dy, dz] of [[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]] as const)
      this.dirty.add([x + dx, y + dy, z + dz].map((k) => Math.floor(k / kChunk)).join());
  }

  private mesh(key: string): void {
    const [cx, cy, cz] = key.split(",").map(Number) as [number, number, number];
    const full = new Faces();
    const border = new Faces();
    for (let z = 0; z < kChunk; ++z)
      for (let y = 0; y < kChunk; ++y)
        for (let x = 0; x < kChunk; ++x) this.brickFaces(kChunk * cx + x, kChunk * cy + y, kChunk * cz + z, full, border);
    const old = this.chunks.get(key);
    for (const mesh of [old?.full, old?.border]) {
      mesh?.removeFromParent();
      mesh?.geometry.dispose();
    }
    const chunk = { full: full.mesh(this.fullMaterial), border: border.mesh(this.borderMaterial) };
    if (chunk.full) this.full.add(chunk.full);
    if (chunk.border) this.border.add(chunk.border);
    this.chunks.set(key, chunk);
  }

  private brickFaces(bx: number, by: number, bz: number, full: Faces, border: Faces): void {
    const brick = this.bricks.get(`${bx},${by},${bz}`);
    if (!brick) return;
    const beside = kFaces.map(([axis, direction]) => {
      const at = [bx, by, bz];
      at[axis]! += direction;
      return this.bricks.get(at.join());
    });
    const shades = [0.86, 0.8, 0.92, 0.76, 1, 0.6];
    for (let place = 0; place < 64; ++place) {
      const occupied = brick.occupied[place]!;
      const empty = ~occupied & ~brick.unseen[place]! & 255;
      if (occupied === 0 && empty === 0) continue;
      const y = place & 7;
      const z = place >> 3;
      const [gy, gz] = [kEdge * by + y, kEdge * bz + z];
      const height = viridis(0.12 + 0.88 * ((gz + 0.5) * this.edge) / kTop);
      kFaces.forEach((face, i) => {
        const next = rows(brick, beside[i], y, z, face);
        let bare = occupied & ~next.occupied;
        let open = empty & next.unseen;
        const shade = shades[i]!;
        const colour = height.map((c) => c * shade);
        for (let x = 0; bare; ++x, bare >>= 1)
          if (bare & 1) full.add(kEdge * bx + x, gy, gz, face, this.edge, colour);
        for (let x = 0; open; ++x, open >>= 1)
          if (open & 1) border.add(kEdge * bx + x, gy, gz, face, this.edge, kUnseenColour);
      });
    }
  }
}

const kUnseenColour = [0.66, 0.42, 0.95];

function count(bits: Uint8Array): number {
  let all = 0;
  for (let byte of bits) for (; byte; byte &= byte - 1) ++all;
  return all;
}

/** For each voxel of the row (y, z), its neighbour's bits across the face. */
function rows(brick: Brick, beside: Brick | undefined, y: number, z: number, face: (typeof kFaces)[number]):
  { occupied: number; unseen: number } {
  const [axis, direction] = face;
  if (axis === 0) {
    const place = 8 * z + y;
    const shift = (own: number, other: number): number =>
      direction > 0 ? own >> 1 | (other & 1) << 7 : (own << 1 & 255) | other >> 7;
    return {
      occupied: shift(brick.occupied[place]!, beside?.occupied[place] ?? 0),
      unseen: shift(brick.unseen[place]!, beside?.unseen[place] ?? 255),
    };
  }
  const at = axis === 1 ? y + direction : z + direction;
  const inside = at >= 0 && at < 8;
  const from = inside ? brick : beside;
  const wrapped = at & 7;
  const place = axis === 1 ? 8 * z + wrapped : 8 * wrapped + y;
  return { occupied: from?.occupied[place] ?? 0, unseen: from?.unseen[place] ?? 255 };
}
