// The robot as this page knows it: the newest message of each topic and when it came, what may be asked of it, and
// the lease. Reconnects by itself; takes control never by itself.
import { Connection, type Answer, type Message } from "./protocol";
import { kTopics, type Messages, type Status, type Topic } from "./messages";

const kRenew = 200; // [ms]
const kAgain = 1000; // until the next try to connect [ms]

type Listener<T extends Topic> = (message: Messages[T]) => void;

export class Robot {
  role = "none";
  name = "";
  connected = false;
  roundTrip = 0; // [ms]
  dropped = 0; // statuses that this page was not shown
  lease = 0; // held by this page; 0: none
  came = new Map<Topic, number>(); // performance.now()
  private newest = new Map<Topic, Message>();
  private listeners = new Map<Topic, ((message: never) => void)[]>();
  private changed: (() => void)[] = [];
  private connection?: Connection;
  private renewal?: number;

  start(): void {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.connection = new Connection(`${scheme}://${location.host}/ws`, kTopics, {
      open: (name, role) => {
        this.name = name.replace(/^Headway: /, "");
        this.role = role;
        this.connected = true;
        this.tell();
      },
      message: (topic, message) => this.take(topic as Topic, message),
      note: (text, level) => { if (level > 0) console.warn(text); },
      closed: () => this.broke(),
    });
  }

  on<T extends Topic>(topic: T, listener: Listener<T>): void {
    const all = this.listeners.get(topic) ?? [];
    all.push(listener as (message: never) => void);
    this.listeners.set(topic, all);
  }
  onChange(listener: () => void): void {
    this.changed.push(listener);
  }
  get<T extends Topic>(topic: T): Messages[T] | undefined {
    return this.newest.get(topic) as Messages[T] | undefined;
  }
  status(): Status | undefined {
    return this.get("/headway/status");
  }
  /** Of the newest message of a topic [ms]. */
  age(topic: Topic): number {
    const at = this.came.get(topic);
    return at === undefined ? Infinity : performance.now() - at;
  }
  get inControl(): boolean {
    return this.connected && this.lease !== 0;
  }

  async ask(service: string, body: object = {}): Promise<Answer> {
    const begun = performance.now();
    const answer = await (this.connection?.call(service, body) ?? { ok: false, error: "not connected" });
    this.roundTrip = performance.now() - begun;
    return answer;
  }

  breakLink(): void {
    this.connection?.close();
  }

  async takeControl(name: string): Promise<Answer> {
    const answer = await this.ask("take_control", { name });
    if (answer.ok) this.hold(Number(answer.lease));
    return answer;
  }
  async releaseControl(): Promise<void> {
    await this.ask("release_control");
    this.lose();
  }

  private hold(lease: number): void {
    this.lease = lease;
    window.clearInterval(this.renewal);
    let refused = 0;
    this.renewal = window.setInterval(async () => {
      const answer = await this.ask("renew", { lease, state: this.status()?.number ?? 0 });
      refused = answer.ok ? 0 : refused + 1;
      if (refused > 25 || /do not have control/.test(answer.error ?? "")) this.lose();
    }, kRenew);
    this.tell();
  }
  private lose(): void {
    window.clearInterval(this.renewal);
    this.lease = 0;
    this.tell();
  }
  private broke(): void {
    this.connected = false;
    this.lose();
    setTimeout(() => this.start(), kAgain);
  }

  private take(topic: Topic, message: Message): void {
    if (topic === "/headway/status") {
      const last = this.status()?.number;
      const now = (message as unknown as Status).number;
      if (last !== undefined && now > last + 1) this.dropped += now - last - 1;
    }
    this.came.set(topic, performance.now());
    this.newest.set(topic, message);
    for (const listener of this.listeners.get(topic) ?? []) listener(message as never);
  }
  private tell(): void {
    for (const listener of this.changed) listener();
  }
}
