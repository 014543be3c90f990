// The link to the robot: connects, tells when it is lost, and connects again by itself. It only ever brings data back;
// control is taken by people.
import { type Answer, Connection } from "../wire/connection";
import { login, session, tokenFromAddress } from "../wire/session";
import type { Header, OperatorStatus } from "../wire/messages";
import type { TopicMessage, TopicName } from "../wire/topics";
import { Signal } from "../ui/signal";
import { Quality } from "./quality";

export type LinkState = "connecting" | "open" | "lost" | "login";
export type Received<N extends TopicName> = { message: TopicMessage<N>; at: number; olderMs: number };

const kStatusLateMs = 1000;
const kSilentMs = 4000;
const kRetryMs = 700;

type Handlers = { [N in TopicName]?: ((message: TopicMessage<N>) => void)[] };

export class Link {
  readonly state = new Signal<LinkState>("connecting");
  readonly role = new Signal("none");
  readonly robot = new Signal("");
  /** Why the robot let nobody in, or sends what the page cannot read. */
  readonly trouble = new Signal("");
  readonly quality = new Quality();
  /** The number by which the robot knows this page; 0 before it has told. */
  viewer = 0;
  private readonly newest: { [N in TopicName]?: Received<N> } = {};
  private readonly handlers: Handlers = {};
  private connection: Connection | null = null;
  private openedAt = 0;
  /** Of this connection. The first may be one that the robot's program wrote before it hung. */
  private statuses = 0;

  async start(): Promise<void> {
    const token = tokenFromAddress();
    if (token !== null) this.trouble.set((await login(token)) ?? "");
    addEventListener("online", () => this.connection?.close());
    setInterval(() => this.watch(), 200);
    setInterval(() => void this.ping(), 1000);
    await this.connect();
  }

  async enter(token: string): Promise<void> {
    const refused = await login(token);
    this.trouble.set(refused ?? "");
    if (!refused) await this.connect();
  }

  on<N extends TopicName>(name: N, handler: (message: TopicMessage<N>) => void): void {
    const list = (this.handlers[name] ??= []) as ((message: TopicMessage<N>) => void)[];
    list.push(handler);
  }

  call(service: string, request: object = {}): Promise<Answer> {
    return this.connection?.call(service, request) ?? Promise.resolve({ ok: false, error: "no link to the robot" });
  }

  get status(): OperatorStatus | undefined {
    return this.newest.status?.message;
  }

  /** How old the newest message of a kind is [ms]; infinite before the first. */
  ageOf(name: TopicName): number {
    const received = this.newest[name];
    return received ? performance.now() - received.at + received.olderMs : Infinity;
  }

  /** False as soon as what is shown may no longer be true. */
  get live(): boolean {
    return this.state.value === "open" && this.statuses > 1 && this.ageOf("status") < kStatusLateMs;
  }

  private async connect(): Promise<void> {
    const who = await session();
    if (who === null) return this.retry();
    if (who.role === "none" && who.token_needed) return this.state.set("login");
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.openedAt = performance.now();
    this.statuses = 0;
    this.connection = new Connection(`${scheme}://${location.host}/ws`, {
      opened: (robot, role, viewer) => this.opened(robot, role, viewer),
      message: (name, message, bytes) => this.take(name, message, bytes),
      unreadable: (why) => this.trouble.set(`Page and robot do not understand each other (${why}). Load the page again.`),
      closed: () => this.closed(),
    });
  }

  private opened(robot: string, role: string, viewer: number): void {
    this.viewer = viewer;
    this.robot.set(robot.replace(/^Headway: /, ""));
    this.role.set(role);
    this.state.set("open");
  }

  private closed(): void {
    this.connection = null;
    this.retry();
  }

  private retry(): void {
    this.state.set("lost");
    setTimeout(() => void this.connect(), kRetryMs);
  }

  private take<N extends TopicName>(name: N, message: TopicMessage<N>, bytes: number): void {
    this.quality.took(bytes);
    if (name === "status") {
      this.quality.numbered((message as OperatorStatus).number);
      ++this.statuses;
    }
    const received = { message, at: performance.now(), olderMs: this.olderThanStatus(message) };
    (this.newest as Record<TopicName, unknown>)[name] = received;
    for (const handler of this.handlers[name] ?? []) handler(message);
  }

  /** Pictures say when they were taken, in the run's clock, which the status tells [ms]. */
  private olderThanStatus(message: object): number {
    const stamp = (message as { header?: Header }).header?.stamp;
    if (!stamp || !this.status || !("data" in message)) return 0;
    const ms = (this.status.stamp_ns - stamp.sec * 1e9 - stamp.nanosec) / 1e6 / Math.max(0.01, this.status.speed);
    return Math.min(60e3, Math.max(0, ms));
  }

  private watch(): void {
    const silent = Math.min(this.ageOf("status"), performance.now() - this.openedAt);
    if (this.connection && silent > kSilentMs) this.connection.close();
  }

  private async ping(): Promise<void> {
    if (this.state.value !== "open") return this.quality.forget();
    const begin = performance.now();
    const answer = await this.call("ping");
    if (answer.ok) this.quality.answered(performance.now() - begin);
  }
}
