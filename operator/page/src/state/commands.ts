// What the robot is told at once, and what it answered last.
import { Signal } from "../ui/signal";
import type { Link } from "./link";

const kStopAgainMs = 200;
const kLookAgainMs = 250;

export type Outcome = { text: string; failed: boolean };

export class Commands {
  readonly outcome = new Signal<Outcome>({ text: "", failed: false });

  private stopOwed = false;
  private stopping = false;
  private looking = false;
  private nextLook: { pan: number; tilt: number } | null = null;

  constructor(private readonly link: Link) {
    link.state.watch((state) => {
      if (state === "open") this.payStop();
    });
    setInterval(() => this.payStop(), kStopAgainMs);
  }

  /** Allowed to everybody, always. One that was not taken is told again and again until it is. */
  async stop(): Promise<void> {
    this.stopOwed = true;
    this.stopping = true;
    const taken = await this.tell("Stop", "stop");
    this.stopping = false;
    if (taken) this.stopOwed = false;
    else this.outcome.set({ text: `${this.outcome.value.text}. It is told again as soon as the robot can be reached.`, failed: true });
  }

  private payStop(): void {
    if (this.stopOwed && !this.stopping && this.link.state.value === "open") void this.stop();
  }

  pause(): Promise<boolean> {
    return this.tell("Pause", "pause");
  }

  resume(): Promise<boolean> {
    return this.tell("Resume", "resume");
  }

  /** The newest of many, as often as the robot takes one with its frames. */
  async look(pan: number, tilt: number): Promise<boolean> {
    if (this.looking) {
      this.nextLook = { pan, tilt };
      return true;
    }
    this.looking = true;
    const taken = await this.tell("Look", "look", { pan, tilt });
    setTimeout(() => {
      this.looking = false;
      const next = this.nextLook;
      this.nextLook = null;
      if (next) void this.look(next.pan, next.tilt);
    }, kLookAgainMs);
    return taken;
  }

  lookAround(): Promise<boolean> {
    return this.tell("Look around", "look_around");
  }

  record(on: boolean): Promise<boolean> {
    return this.tell(on ? "Recording" : "End of recording", "record", { on });
  }

  /** On where it is off, and off where it is on. */
  switchRecording(): void {
    const { status } = this.link;
    if (status && status.record_folder !== "") void this.record(!status.recording);
  }

  reset(): Promise<boolean> {
    return this.tell("Reset", "reset");
  }

  /** True: the robot took it. */
  private async tell(what: string, service: string, request: object = {}): Promise<boolean> {
    this.outcome.set({ text: `${what}: sent…`, failed: false });
    const begin = performance.now();
    const answer = await this.link.call(service, request);
    const took = Math.round(performance.now() - begin);
    const text = answer.ok ? `${what}: taken after ${took} ms` : `${what} was NOT taken: ${answer.error ?? "refused"}`;
    this.outcome.set({ text, failed: !answer.ok });
    return answer.ok;
  }
}
