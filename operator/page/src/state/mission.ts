// From a click to a walk: a way is asked for, shown with what it costs, and walked only when somebody confirms it.
import { Signal } from "../ui/signal";
import type { Answer } from "../wire/connection";
import type { Lease } from "./lease";
import type { Link } from "./link";

export type Goal = { x: number; y: number; yaw?: number };
export type View = { pan: number; tilt: number; gain: number };
export type Proposal = {
  plan: number;
  title: string;
  metres: number;
  seconds: number;
  steps: number;
  view: View | null;
  until: number; // performance.now() when the robot forgets it
};
export type MissionState =
  | { kind: "idle" }
  | { kind: "asking"; title: string }
  | { kind: "proposed"; proposal: Proposal }
  | { kind: "refused"; title: string; reason: string; nearest: [number, number] | null };

const kPlanHoldsMs = 60e3;

export class Mission {
  readonly state = new Signal<MissionState>({ kind: "idle" });
  /** Where the operator pointed, until the robot has it as its goal. */
  readonly pointed = new Signal<Goal | null>(null);
  /** Goals that are walked one after the other. */
  readonly tour = new Signal<readonly Goal[]>([]);
  private asked = 0;

  constructor(private readonly link: Link, lease: Lease) {
    setInterval(() => this.expire(), 500);
    lease.number.watch((held) => {
      if (held === null) this.cancel();
    });
  }

  preview(goal: Goal, near = false): Promise<void> {
    this.pointed.set(goal);
    const yaw = goal.yaw === undefined ? {} : { yaw_deg: (goal.yaw * 180) / Math.PI };
    const title = `${near ? "Near " : "To "}${goal.x.toFixed(2)}, ${goal.y.toFixed(2)} m`;
    return this.ask(title, "plan_preview", { x: goal.x, y: goal.y, ...yaw, ...(near ? { near } : {}) });
  }

  goHome(): Promise<void> {
    return this.ask("To where it started", "go_home", {});
  }

  explore(): Promise<void> {
    return this.ask("Next best view", "explore_preview", {});
  }

  addToTour(goal: Goal): Promise<void> {
    this.tour.set([...this.tour.value, goal]);
    return this.previewTour();
  }

  previewTour(): Promise<void> {
    const goals = this.tour.value.map(({ x, y }) => [x, y]);
    return this.ask(`List of ${goals.length}: first`, "tour", { goals });
  }

  clearTour(): void {
    this.tour.set([]);
    this.cancel();
  }

  async confirm(): Promise<void> {
    const state = this.state.value;
    if (state.kind !== "proposed") return;
    const { plan, title } = state.proposal;
    const answer = await this.link.call("plan_confirm", { plan });
    if (!answer.ok) return this.refuse(title, answer);
    this.state.set({ kind: "idle" });
    this.pointed.set(null);
    this.tour.set([]);
  }

  cancel(): void {
    this.asked++;
    if (this.state.value.kind === "proposed") void this.link.call("forget_plan", {});
    this.pointed.set(null);
    this.state.set({ kind: "idle" });
  }

  private async ask(title: string, service: string, request: object): Promise<void> {
    const number = ++this.asked;
    this.state.set({ kind: "asking", title });
    const answer = await this.link.call(service, request);
    if (number !== this.asked) return;
    if (answer.ok) this.state.set({ kind: "proposed", proposal: proposal(title, answer) });
    else this.refuse(title, answer);
  }

  private refuse(title: string, answer: Answer): void {
    this.state.set({ kind: "refused", title, reason: answer.error ?? "refused", nearest: nearest(answer) });
  }

  private expire(): void {
    const state = this.state.value;
    if (state.kind === "proposed" && performance.now() > state.proposal.until) {
      this.refuse(state.proposal.title, { ok: false, error: "this plan is older than a minute: ask again" });
    }
  }
}

function number(value: unknown): number {
  return typeof value === "number" ? value : 0;
}

function proposal(title: string, answer: Answer): Proposal {
  const note = typeof answer["note"] === "string" ? answer["note"] : "";
  return {
    plan: number(answer["plan"]), title: note ? `${title}: ${note}` : title, metres: number(answer["metres"]), seconds: number(answer["seconds"]),
    steps: number(answer["steps"]), view: view(answer["view"]), until: performance.now() + kPlanHoldsMs,
  };
}

function view(value: unknown): View | null {
  if (typeof value !== "object" || value === null) return null;
  const { pan_deg, tilt_deg, gain } = value as Record<string, unknown>;
  const radians = (degrees: unknown) => (number(degrees) * Math.PI) / 180;
  return { pan: radians(pan_deg), tilt: radians(tilt_deg), gain: number(gain) };
}

function nearest(answer: Answer): [number, number] | null {
  const place = answer["nearest"];
  return Array.isArray(place) && place.length >= 2 ? [number(place[0]), number(place[1])] : null;
}
