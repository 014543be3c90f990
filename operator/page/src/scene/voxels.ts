// Occupied and unseen space as the faces that show, in chunks of 4 x 4 x 4 bricks. Chunks that changed are made anew a few
// milliseconds at a time, so that the page stays answerable while a whole map arrives.
import {
  BackSide, BufferAttribute, BufferGeometry, Color, Group, Mesh, ShaderMaterial, Sphere, Vector3,
} from "three";
import type { Voxels as VoxelsMessage } from "../wire/messages";
import {
  type Brick, Bricks, type Face, type Shown, kEdge, kFaces, kNeighbour, occupiedShown, rectangles, unseenShown,
} from "./bricks";
import { kHeightHigh, kHeightLow, kScaleSteps, kUnseenColor, scaleShader, scaleUniform } from "./colours";

const kChunk = 4; // bricks
const kSpan = kChunk * kEdge; // voxels
const kWorkMs = 6;

type Chunk = { i: number; j: number; k: number; occupied: Mesh | null; unseen: Mesh | null };

const vertex = /* glsl */ `
  attribute vec4 corner;
  uniform float edge;
  uniform vec3 floorColor;
  uniform vec3 steps[${kScaleSteps}];
  varying vec3 shown;
  ${scaleShader}
  void main() {
    vec4 at = modelMatrix * vec4(corner.xyz * edge, 1.0);
    float face = corner.w;
    float shade = face > 4.5 ? 1.0 : face > 3.5 ? 0.55 : face > 2.5 ? 0.72 : face > 1.5 ? 0.82 : face > 0.5 ? 0.66 : 0.9;
    float t = (at.z - ${kHeightLow.toFixed(1)}) / ${(kHeightHigh - kHeightLow).toFixed(1)};
    // The floor is no obstacle: it has no colour of the scale.
    shown = mix(floorColor, scaleColor(t, steps), smoothstep(0.02, 0.12, at.z)) * shade;
    gl_Position = projectionMatrix * viewMatrix * at;
  }`;

const kUnseen = new Color().setStyle(kUnseenColor, "srgb-linear");

function solid(): ShaderMaterial {
  return new ShaderMaterial({
    uniforms: { edge: { value: 0.05 }, steps: { value: scaleUniform("cividis") }, floorColor: { value: new Color() } },
    vertexShader: vertex,
    fragmentShader: "varying vec3 shown; void main() { gl_FragColor = vec4(shown, 1.0); }",
  });
}

function veil(): ShaderMaterial {
  return new ShaderMaterial({
    uniforms: {
      edge: { value: 0.05 },
      steps: { value: Array(kScaleSteps).fill(kUnseen) },
      floorColor: { value: kUnseen },
    },
    vertexShader: vertex,
    fragmentShader: "varying vec3 shown; void main() { gl_FragColor = vec4(shown, 0.3); }",
    transparent: true,
    depthWrite: false,
    // Seen from space that has been seen: nothing hangs before one's eyes.
    side: BackSide,
  });
}

export class Voxels {
  readonly occupied = new Group();
  readonly unseen = new Group();
  private readonly bricks = new Bricks();
  private readonly chunks = new Map<string, Chunk>();
  private readonly stale = new Set<string>();
  private readonly solid = solid();
  private readonly veil = veil();
  private edge = 0.05;

  /** `changed` is called whenever there is something new to draw. */
  constructor(private readonly changed: () => void) {}

  set floorColor(style: string) {
    this.solid.uniforms["floorColor"]!.value.setStyle(style, "srgb-linear");
    this.changed();
  }

  /** Chunks still to be made anew. */
  get waiting(): number {
    return this.stale.size;
  }

  /** Voxels that are occupied. */
  count(): number {
    let count = 0;
    for (const brick of this.bricks.all()) for (const row of brick.occupied) count += bits(row);
    return count;
  }

  take(message: VoxelsMessage): void {
    if (message.whole) this.clear();
    this.resize(message.resolution);
    const { keys } = message;
    for (let n = 0; 3 * n + 2 < keys.length; ++n) {
      const brick = {
        occupied: message.occupied.slice(64 * n, 64 * n + 64),
        unseen: message.unseen.slice(64 * n, 64 * n + 64),
      };
      this.put(keys[3 * n]!, keys[3 * n + 1]!, keys[3 * n + 2]!, brick);
    }
    this.work();
  }

  private put(i: number, j: number, k: number, brick: Brick): void {
    this.bricks.set(i, j, k, brick);
    this.touch(i, j, k);
    for (const [di, dj, dk] of kNeighbour) {
      if (this.bricks.has(i + di, j + dj, k + dk)) this.touch(i + di, j + dj, k + dk);
    }
  }

  private touch(i: number, j: number, k: number): void {
    const [ci, cj, ck] = [Math.floor(i / kChunk), Math.floor(j / kChunk), Math.floor(k / kChunk)];
    const name = `${ci},${cj},${ck}`;
    if (!this.chunks.has(name)) this.chunks.set(name, { i: ci, j: cj, k: ck, occupied: null, unseen: null });
    this.stale.add(name);
  }

  private clear(): void {
    this.bricks.clear();
    for (const name of this.chunks.keys()) this.stale.add(name);
  }

  private resize(edge: number): void {
    this.edge = edge;
    for (const material of [this.solid, this.veil]) material.uniforms["edge"]!.value = edge;
  }

  private readonly work = (): void => {
    const until = performance.now() + kWorkMs;
    for (const name of this.stale) {
      this.stale.delete(name);
      this.remake(this.chunks.get(name)!);
      if (performance.now() > until) break;
    }
    this.changed();
    if (this.stale.size) setTimeout(this.work, 0);
  };

  private remake(chunk: Chunk): void {
    chunk.occupied = this.replace(chunk, chunk.occupied, this.occupied, this.solid, occupiedShown);
    chunk.unseen = this.replace(chunk, chunk.unseen, this.unseen, this.veil, unseenShown);
  }

  private replace(chunk: Chunk, old: Mesh | null, group: Group, material: ShaderMaterial, shown: Shown) {
    if (old) {
      group.remove(old);
      old.geometry.dispose();
    }
    const geometry = this.faces(chunk, shown);
    if (!geometry) return null;
    const mesh = new Mesh(geometry, material);
    mesh.position.set(chunk.i, chunk.j, chunk.k).multiplyScalar(kSpan * this.edge);
    group.add(mesh);
    return mesh;
  }

  private faces(chunk: Chunk, shown: Shown): BufferGeometry | null {
    const corners: number[] = [];
    for (let n = 0; n < kChunk ** 3; ++n) {
      const [x, y, z] = [n % kChunk, Math.floor(n / kChunk) % kChunk, Math.floor(n / kChunk ** 2)] as const;
      const [i, j, k] = [chunk.i * kChunk + x, chunk.j * kChunk + y, chunk.k * kChunk + z] as const;
      if (this.bricks.has(i, j, k)) this.brickFaces([i, j, k], [x * kEdge, y * kEdge, z * kEdge], shown, corners);
    }
    return corners.length ? quads(corners, this.edge) : null;
  }

  private brickFaces(key: Triple, from: Triple, shown: Shown, corners: number[]): void {
    const beside = kNeighbour.map(([di, dj, dk]) => this.bricks.at(key[0] + di, key[1] + dj, key[2] + dk));
    const place = { brick: this.bricks.at(...key), beside };
    for (const face of kFaces) {
      if (!shown(place, face, found)) continue;
      rectangles(found, face, (depth, u, v, width, height) => quad(corners, from, face, depth, u, v, width, height));
    }
  }
}

type Triple = readonly [number, number, number];
const found = new Uint8Array(64);

/** Four corners, counter-clockwise seen from outside; the fourth number of each is the direction of the face. */
function quad(
  corners: number[], from: Triple, face: Face, depth: number, u: number, v: number, width: number, height: number,
): void {
  const axis = face >> 1;
  const outward = face & 1;
  const at = (a: number, b: number): void => {
    const place: [number, number, number] = axis === 0 ? [depth + outward, a, b] : axis === 1 ? [a, depth + outward, b] : [a, b, depth + outward];
    corners.push(from[0] + place[0], from[1] + place[1], from[2] + place[2], face);
  };
  at(u, v);
  const turned = (axis === 1) === (outward === 1);
  if (turned) {
    at(u, v + height);
    at(u + width, v + height);
    at(u + width, v);
  } else {
    at(u + width, v);
    at(u + width, v + height);
    at(u, v + height);
  }
}

function quads(corners: number[], edge: number): BufferGeometry {
  const count = corners.length / 16;
  const index = new Uint32Array(6 * count);
  for (let n = 0; n < count; ++n) index.set([4 * n, 4 * n + 1, 4 * n + 2, 4 * n, 4 * n + 2, 4 * n + 3], 6 * n);
  const geometry = new BufferGeometry();
  geometry.setAttribute("corner", new BufferAttribute(new Uint8Array(corners), 4));
  geometry.setIndex(new BufferAttribute(index, 1));
  const half = (kSpan * edge) / 2;
  geometry.boundingSphere = new Sphere(new Vector3(half, half, half), half * Math.sqrt(3));
  return geometry;
}

function bits(byte: number): number {
  let count = 0;
  for (let rest = byte; rest; rest &= rest - 1) ++count;
  return count;
}
