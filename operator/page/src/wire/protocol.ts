// The Foxglove WebSocket protocol, as far as this page needs it: channels in ROS 2's CDR, services in JSON.
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";

export type Message = Record<string, unknown>;
export type Answer = { ok: boolean; error?: string } & Record<string, unknown>;

type Channel = { id: number; topic: string; schema: string };
type Service = { id: number; name: string };

const kSubprotocol = "foxglove.websocket.v1";
const kMessage = 1;
const kResponse = 3;
const kCall = 2;
const kPatience = 3000; // with an answer [ms]

export type Handlers = {
  open: (robot: string, role: string) => void;
  message: (topic: string, message: Message, bytes: number) => void;
  note: (text: string, level: number) => void;
  closed: () => void;
};

/** One connection, from its opening to its end. */
export class Connection {
  private socket: WebSocket;
  private readers = new Map<number, { topic: string; reader: MessageReader }>();
  private services = new Map<string, number>();
  private waiting = new Map<number, (answer: Answer) => void>();
  private lastCall = 0;

  constructor(url: string, private topics: readonly string[], private on: Handlers) {
    this.socket = new WebSocket(url, [kSubprotocol]);
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = (event) => {
      if (typeof event.data === "string") this.hear(JSON.parse(event.data));
      else this.take(new DataView(event.data as ArrayBuffer));
    };
    this.socket.onclose = () => {
      for (const done of this.waiting.values()) done({ ok: false, error: "the link broke" });
      this.waiting.clear();
      this.on.closed();
    };
  }

  close(): void {
    this.socket.close();
  }

  call(name: string, body: object): Promise<Answer> {
    const service = this.services.get(name);
    if (service === undefined || this.socket.readyState !== WebSocket.OPEN)
      return Promise.resolve({ ok: false, error: "not connected" });
    const id = ++this.lastCall;
    const text = new TextEncoder().encode(JSON.stringify(body));
    const out = new DataView(new ArrayBuffer(17 + text.length));
    out.setUint8(0, kCall);
    out.setUint32(1, service, true);
    out.setUint32(5, id, true);
    out.setUint32(9, 4, true);
    new Uint8Array(out.buffer).set(new TextEncoder().encode("json"), 13);
    new Uint8Array(out.buffer).set(text, 17);
    this.socket.send(out.buffer);
    return new Promise((done) => {
      this.waiting.set(id, done);
      setTimeout(() => this.answer(id, { ok: false, error: "no answer came" }), kPatience);
    });
  }

  private answer(id: number, answer: Answer): void {
    const done = this.waiting.get(id);
    this.waiting.delete(id);
    done?.(answer);
  }

  private hear(said: Record<string, unknown>): void {
    if (said.op === "serverInfo") {
      const role = (said.metadata as { role?: string } | undefined)?.role ?? "viewer";
      this.on.open(String(said.name), role);
    } else if (said.op === "advertise") {
      this.subscribe(said.channels as Channel[]);
    } else if (said.op === "advertiseServices") {
      for (const service of said.services as Service[]) this.services.set(service.name, service.id);
    } else if (said.op === "status") {
      this.on.note(String(said.message), Number(said.level));
    } else if (said.op === "serviceCallFailure") {
      this.answer(Number(said.callId), { ok: false, error: String(said.message) });
    }
  }

  private subscribe(channels: Channel[]): void {
    const subscriptions = [];
    for (const channel of channels) {
      if (!this.topics.includes(channel.topic)) continue;
      const reader = new MessageReader(parse(channel.schema, { ros2: true }));
      this.readers.set(channel.id, { topic: channel.topic, reader });
      subscriptions.push({ id: channel.id, channelId: channel.id });
    }
    this.socket.send(JSON.stringify({ op: "subscribe", subscriptions }));
  }

  private take(data: DataView): void {
    const kind = data.getUint8(0);
    if (kind === kMessage) {
      const known = this.readers.get(data.getUint32(1, true));
      if (!known) return;
      const bytes = new Uint8Array(data.buffer, 13);
      this.on.message(known.topic, known.reader.readMessage(bytes) as Message, bytes.length);
    } else if (kind === kResponse) {
      const encoding = data.getUint32(9, true);
      const text = new TextDecoder().decode(new Uint8Array(data.buffer, 13 + encoding));
      this.answer(data.getUint32(5, true), JSON.parse(text) as Answer);
    }
  }
}
