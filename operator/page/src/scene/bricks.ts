// The voxels that the robot has told, in bricks of 8 x 8 x 8, and the faces between what differs. A row of eight voxels
// is a byte, so a face of eight is found with one operation.

export type Brick = { occupied: Uint8Array; unseen: Uint8Array };
export const kEdge = 8;
const kUnseen: Brick = { occupied: new Uint8Array(64), unseen: new Uint8Array(64).fill(255) };

const keyOf = (i: number, j: number, k: number): string => `${i},${j},${k}`;

export class Bricks {
  private readonly known = new Map<string, Brick>();

  clear(): void {
    this.known.clear();
  }

  set(i: number, j: number, k: number, brick: Brick): void {
    this.known.set(keyOf(i, j, k), brick);
  }

  has(i: number, j: number, k: number): boolean {
    return this.known.has(keyOf(i, j, k));
  }

  at(i: number, j: number, k: number): Brick {
    return this.known.get(keyOf(i, j, k)) ?? kUnseen;
  }

  all(): Iterable<Brick> {
    return this.known.values();
  }
}

/** A kind of voxel, as rows of bits. */
type Rows = (brick: Brick, row: number) => number;
const occupied: Rows = (brick, row) => brick.occupied[row] ?? 0;
const unseen: Rows = (brick, row) => brick.unseen[row] ?? 0;
const seenFree: Rows = (brick, row) => ~((brick.occupied[row] ?? 0) | (brick.unseen[row] ?? 0)) & 255;

/** Directions of faces: -x, +x, -y, +y, -z, +z. */
export const kFaces = [0, 1, 2, 3, 4, 5] as const;
export type Face = (typeof kFaces)[number];
export const kNeighbour: readonly [number, number, number][] = [
  [-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1],
];

/** A brick with its neighbours in the order of the faces. */
export type Place = { brick: Brick; beside: readonly Brick[] };
/** Writes which voxels of a brick show a face in a direction; false: none. */
export type Shown = (place: Place, face: Face, out: Uint8Array) => boolean;

/** Where seen space ends at space that has not been seen. */
export const unseenShown: Shown = (place, face, out) => write(out, (row) => seenFree(place.brick, row) && exposed(place, face, row, seenFree, unseen));

/** Surfaces as they have been seen: towards seen space. So rooms have no outside that hides what is in them. A voxel that
 *  stands alone in what is unseen shows all its sides, for it is there all the same. */
export const occupiedShown: Shown = (place, face, out) =>
  write(out, (row) => {
    if (!occupied(place.brick, row)) return 0;
    const hidden = exposed(place, face, row, occupied, unseen);
    return exposed(place, face, row, occupied, seenFree) | (hidden && hidden & ~accompanied(place, row));
  });

function write(out: Uint8Array, faces: (row: number) => number): boolean {
  let any = 0;
  for (let row = 0; row < 64; ++row) any |= out[row] = faces(row);
  return any !== 0;
}

/** Voxels of `of` whose neighbour in a direction is one of `against`. */
function exposed({ brick, beside }: Place, face: Face, row: number, of: Rows, against: Rows): number {
  return of(brick, row) & neighbours(brick, beside[face]!, face, row, against);
}

/** Occupied voxels beside which there is anything but unseen space. */
function accompanied(place: Place, row: number): number {
  return kFaces.reduce<number>((bits, face) => bits | (occupied(place.brick, row) & ~exposed(place, face, row, occupied, unseen)), 0);
}

/** Row `row` of what lies one voxel further in a direction. */
function neighbours(brick: Brick, beside: Brick, face: Face, row: number, kind: Rows): number {
  const y = row & 7;
  switch (face) {
    case 0: return ((kind(brick, row) << 1) | (kind(beside, row) >> 7)) & 255;
    case 1: return (kind(brick, row) >> 1) | ((kind(beside, row) << 7) & 255);
    case 2: return y > 0 ? kind(brick, row - 1) : kind(beside, row + 7);
    case 3: return y < 7 ? kind(brick, row + 1) : kind(beside, row - 7);
    case 4: return row >= 8 ? kind(brick, row - 8) : kind(beside, row + 56);
    case 5: return row < 56 ? kind(brick, row + 8) : kind(beside, row - 56);
  }
}

/** A rectangle of faces in the plane `depth` of its direction; u and v are the plane's axes in the order x, y, z. */
export type Emit = (depth: number, u: number, v: number, width: number, height: number) => void;

const plane = new Uint8Array(8);

/** Joins faces to as few rectangles as an eager search finds. */
export function rectangles(faces: Uint8Array, face: Face, emit: Emit): void {
  for (let depth = 0; depth < 8; ++depth) {
    let any = 0;
    for (let v = 0; v < 8; ++v) any |= plane[v] = planeRow(faces, face, depth, v);
    if (any) joinPlane(depth, emit);
  }
}

/** Bits along u, of line v: (y, z) for x planes, (x, z) for y planes, (x, y) for z planes. */
function planeRow(faces: Uint8Array, face: Face, depth: number, v: number): number {
  if (face >= 4) return faces[8 * depth + v] ?? 0;
  if (face >= 2) return faces[8 * v + depth] ?? 0;
  let bits = 0;
  for (let y = 0; y < 8; ++y) bits |= (((faces[8 * v + y] ?? 0) >> depth) & 1) << y;
  return bits;
}

function joinPlane(depth: number, emit: Emit): void {
  for (let v = 0; v < 8; ++v) {
    while (plane[v]) {
      const bits = plane[v]!;
      const u = 31 - Math.clz32(bits & -bits);
      let width = 1;
      while (bits & (1 << (u + width))) ++width;
      const run = ((1 << width) - 1) << u;
      let height = 0;
      while (v + height < 8 && (plane[v + height]! & run) === run) plane[v + height++]! &= ~run;
      emit(depth, u, v, width, height);
    }
  }
}
