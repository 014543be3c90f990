// Reads ROS 2's CDR (XCDR1, little endian). A message is described once, field by field, and its type follows from that.

export class CdrReader {
  private at = 4; // after the encapsulation header, from where alignment counts

  constructor(private readonly view: DataView) {
    if (view.byteLength < 4 || view.getUint8(1) !== 1) throw new Error("not little-endian CDR");
  }

  /** The place of the next `size` bytes, aligned to `align`. */
  take(size: number, align: number): number {
    const begin = this.at + ((align - ((this.at - 4) % align)) % align);
    if (begin + size > this.view.byteLength) throw new Error("a message ends early");
    this.at = begin + size;
    return begin;
  }

  /** An element count; refused where so many cannot follow. */
  count(smallest: number): number {
    const count = uint32(this);
    if (count * smallest > this.view.byteLength - this.at) throw new Error("a message ends early");
    return count;
  }

  get data(): DataView {
    return this.view;
  }

  /** Bytes as they lie in the message, not copied. */
  bytes(count: number): Uint8Array {
    return new Uint8Array(this.view.buffer, this.view.byteOffset + this.take(count, 1), count);
  }
}

export type Codec<T> = (reader: CdrReader) => T;
export type Message<C> = C extends Codec<infer T> ? T : never;

export const bool: Codec<boolean> = (r) => r.data.getUint8(r.take(1, 1)) !== 0;
export const uint8: Codec<number> = (r) => r.data.getUint8(r.take(1, 1));
export const int32: Codec<number> = (r) => r.data.getInt32(r.take(4, 4), true);
export const uint32: Codec<number> = (r) => r.data.getUint32(r.take(4, 4), true);
export const float32: Codec<number> = (r) => r.data.getFloat32(r.take(4, 4), true);
export const float64: Codec<number> = (r) => r.data.getFloat64(r.take(8, 8), true);
// Nanoseconds of a run and counters stay far below 2^53.
export const int64: Codec<number> = (r) => Number(r.data.getBigInt64(r.take(8, 8), true));
export const uint64: Codec<number> = (r) => Number(r.data.getBigUint64(r.take(8, 8), true));

const utf8 = new TextDecoder();
export const string: Codec<string> = (r) => {
  const bytes = r.bytes(r.count(1));
  return utf8.decode(bytes.subarray(0, Math.max(0, bytes.length - 1)));
};

export const bytes: Codec<Uint8Array> = (r) => r.bytes(r.count(1));
export const int8s: Codec<Int8Array> = (r) => {
  const raw = bytes(r);
  return new Int8Array(raw.buffer, raw.byteOffset, raw.length);
};
export const int32s: Codec<Int32Array> = (r) => {
  const count = r.count(4);
  return Int32Array.from({ length: count }, () => int32(r));
};

export function list<T>(element: Codec<T>): Codec<T[]> {
  return (r) => Array.from({ length: r.count(1) }, () => element(r));
}

export function struct<F extends Record<string, Codec<unknown>>>(fields: F): Codec<{ [K in keyof F]: Message<F[K]> }> {
  const entries = Object.entries(fields);
  return (r) => {
    const message: Record<string, unknown> = {};
    for (const [name, codec] of entries) message[name] = codec(r);
    return message as { [K in keyof F]: Message<F[K]> };
  };
}

export function decode<T>(codec: Codec<T>, cdr: DataView): T {
  return codec(new CdrReader(cdr));
}
