// One WebSocket to the robot: subscribes to all that the page knows, and calls services. It lives until it closes once.
import { decode } from "./cdr";
import { callFrame, readFrame } from "./frames";
import { type TopicMessage, type TopicName, topicNames, topics } from "./topics";

export type Answer = { ok: boolean; error?: string; [key: string]: unknown };
export type MessageHandler = <N extends TopicName>(name: N, message: TopicMessage<N>, bytes: number) => void;

export interface ConnectionEvents {
  /** Services can be called from now on. `viewer`: the number by which the robot knows this page. */
  opened(robot: string, role: string, viewer: number): void;
  message: MessageHandler;
  /** The robot's program sends something this page cannot read. */
  unreadable(why: string): void;
  closed(): void;
}

const kAnswerWithinMs = 5000;

type ServerText = {
  op?: string;
  name?: string;
  metadata?: Record<string, string>;
  channels?: { id: number; topic: string }[];
  services?: { id: number; name: string }[];
  callId?: number;
  message?: string;
};

export class Connection {
  private readonly socket: WebSocket;
  private readonly services = new Map<string, number>();
  private readonly calls = new Map<number, (answer: Answer) => void>();
  private nextCall = 1;
  private robot = "";
  private role = "viewer";
  private viewer = 0;

  constructor(url: string, private readonly events: ConnectionEvents) {
    this.socket = new WebSocket(url, ["foxglove.sdk.v1", "foxglove.websocket.v1"]);
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => this.take(event.data);
    this.socket.onclose = () => this.end();
  }

  close(): void {
    this.socket.close();
  }

  /** Always answers: with what the robot says, or with ok false and why there is no answer. */
  call(service: string, request: object): Promise<Answer> {
    const id = this.services.get(service);
    if (this.socket.readyState !== WebSocket.OPEN) return Promise.resolve({ ok: false, error: "no link to the robot" });
    if (id === undefined) return Promise.resolve({ ok: false, error: `the robot does not offer '${service}'` });
    const call = this.nextCall++;
    this.socket.send(callFrame(id, call, request));
    return new Promise((resolve) => {
      const timer = setTimeout(() => this.settle(call, { ok: false, error: "the robot did not answer" }), kAnswerWithinMs);
      this.calls.set(call, (answer) => {
        clearTimeout(timer);
        resolve(answer);
      });
    });
  }

  private settle(call: number, answer: Answer): void {
    const resolve = this.calls.get(call);
    this.calls.delete(call);
    resolve?.(answer);
  }

  private end(): void {
    for (const call of [...this.calls.keys()]) this.settle(call, { ok: false, error: "the link was lost" });
    this.events.closed();
  }

  private take(data: string | ArrayBuffer): void {
    try {
      if (typeof data === "string") this.takeText(JSON.parse(data) as ServerText);
      else this.takeBinary(data);
    } catch (error) {
      this.events.unreadable(error instanceof Error ? error.message : String(error));
    }
  }

  private takeText(text: ServerText): void {
    if (text.op === "serverInfo") {
      this.robot = text.name ?? "";
      this.role = text.metadata?.["role"] ?? "viewer";
      this.viewer = Number(text.metadata?.["viewer"] ?? 0);
    }
    if (text.op === "advertise") this.subscribe(text.channels ?? []);
    if (text.op === "advertiseServices") {
      for (const { id, name } of text.services ?? []) this.services.set(name.slice(name.lastIndexOf("/") + 1), id);
      this.events.opened(this.robot, this.role, this.viewer);
    }
    if (text.op === "serviceCallFailure" && text.callId !== undefined) {
      this.settle(text.callId, { ok: false, error: text.message ?? "the call failed" });
    }
  }

  /** Subscription ids are the places of the topics in the page's own list. */
  private subscribe(channels: { id: number; topic: string }[]): void {
    const subscriptions = channels.flatMap((channel) => {
      const id = topicNames.findIndex((name) => topics[name].topic === channel.topic);
      return id < 0 ? [] : [{ id, channelId: channel.id }];
    });
    this.socket.send(JSON.stringify({ op: "subscribe", subscriptions }));
  }

  private takeBinary(buffer: ArrayBuffer): void {
    const frame = readFrame(buffer);
    if (frame.kind === "message") this.deliver(topicNames[frame.subscription], frame.payload);
    if (frame.kind === "answer") this.settle(frame.call, JSON.parse(frame.text) as Answer);
  }

  private deliver<N extends TopicName>(name: N | undefined, payload: DataView): void {
    if (!name) return;
    const message = decode<unknown>(topics[name].codec, payload) as TopicMessage<N>;
    this.events.message(name, message, payload.byteLength);
  }
}
