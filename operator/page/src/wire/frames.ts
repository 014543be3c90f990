// The binary frames of the Foxglove WebSocket protocol, version 1.

const utf8 = { encode: new TextEncoder(), decode: new TextDecoder() };

export type ServerFrame =
  | { kind: "message"; subscription: number; payload: DataView }
  | { kind: "answer"; call: number; text: string }
  | { kind: "other" };

export function readFrame(buffer: ArrayBuffer): ServerFrame {
  const view = new DataView(buffer);
  if (buffer.byteLength >= 13 && view.getUint8(0) === 1) {
    return { kind: "message", subscription: view.getUint32(1, true), payload: new DataView(buffer, 13) };
  }
  if (buffer.byteLength >= 13 && view.getUint8(0) === 3) return readAnswer(view, buffer);
  return { kind: "other" };
}

function readAnswer(view: DataView, buffer: ArrayBuffer): ServerFrame {
  const body = 13 + view.getUint32(9, true);
  if (body > buffer.byteLength) return { kind: "other" };
  return { kind: "answer", call: view.getUint32(5, true), text: utf8.decode.decode(new Uint8Array(buffer, body)) };
}

export function callFrame(service: number, call: number, request: unknown): ArrayBuffer {
  const encoding = utf8.encode.encode("json");
  const body = utf8.encode.encode(JSON.stringify(request));
  const frame = new Uint8Array(13 + encoding.length + body.length);
  const view = new DataView(frame.buffer);
  view.setUint8(0, 2);
  view.setUint32(1, service, true);
  view.setUint32(5, call, true);
  view.setUint32(9, encoding.length, true);
  frame.set(encoding, 13);
  frame.set(body, 13 + encoding.length);
  return frame.buffer;
}
