// What the robot does and will do next, the way that is proposed, and STOP.
import type { App } from "../state/app";
import type { MissionState, Proposal } from "../state/mission";
import type { OperatorStatus } from "../wire/messages";
import { byId, onClick, setText } from "../ui/dom";
import { beforeNextFrame } from "../ui/frame";
import { degrees, metres, seconds } from "../ui/words";

export class CommandBar {
  constructor(private readonly app: App) {
    const { link, mission, commands } = app;
    link.on("status", () => beforeNextFrame(this.showNewest));
    mission.state.watch((state) => this.showProposal(state));
    commands.outcome.watch(({ text, failed }) => {
      setText(byId("outcome"), text);
      byId("outcome").dataset["failed"] = String(failed);
    });
    this.startButtons();
    setInterval(() => this.countDown(), 1000);
  }

  private startButtons(): void {
    const { mission, commands } = this.app;
    // A stop does not wait until the finger is lifted.
    byId("stop").addEventListener("pointerdown", () => this.stop());
    byId("stop").addEventListener("click", (event) => {
      if (event.detail === 0) this.stop(); // from the keyboard, or from an aid
    });
    onClick("confirm", () => void mission.confirm());
    onClick("cancel", () => mission.cancel());
    onClick("nearest", () => this.goNear());
    onClick("home", () => void mission.goHome());
    onClick("explore", () => void mission.explore());
    onClick("pause", () => void commands.pause());
    onClick("resume", () => void commands.resume());
    onClick("reset", () => void commands.reset());
  }

  stop(): void {
    void this.app.commands.stop();
    this.app.mission.cancel();
  }

  goNear(): void {
    const state = this.app.mission.state.value;
    if (state.kind !== "refused" || !state.nearest) return;
    void this.app.mission.preview({ x: state.nearest[0], y: state.nearest[1] }, true);
  }

  private readonly showNewest = (): void => {
    const { status } = this.app.link;
    if (!status) return;
    this.show(status);
    // Only now is it on the screen, which is what a renewal of control vouches for.
    this.app.lease.shown(status.number);
  };

  private show(status: OperatorStatus): void {
    const list = status.tour_left > 0 ? `, ${status.tour_left} more on the list` : "";
    const state = status.state === "stopped" && !status.at_rest ? "stopping" : status.state;
    setText(byId("state"), `${capital(state)}${status.paused ? " (paused)" : ""}${list}`);
    byId("now").dataset["state"] = status.state;
    setText(byId("reason"), status.reason);
    setText(byId("next"), status.next || "Nothing: it waits.");
    byId("pause").hidden = status.paused;
    byId("resume").hidden = !status.paused;
  }

  private showProposal(state: MissionState): void {
    const bar = byId("proposal");
    bar.hidden = state.kind === "idle";
    bar.dataset["kind"] = state.kind;
    byId("confirm").hidden = state.kind !== "proposed";
    byId("nearest").hidden = !(state.kind === "refused" && state.nearest);
    if (state.kind === "asking") this.words(`${state.title}: looking for a way…`, "");
    if (state.kind === "proposed") this.propose(state.proposal);
    if (state.kind === "refused") this.words(`No way: ${state.reason.replace(/^no way( there)?: /, "")}`, state.nearest ? `Nearest place it can reach: ${state.nearest.map((v) => v.toFixed(2)).join(", ")} m` : state.title);
  }

  private propose(proposal: Proposal): void {
    const { title, view } = proposal;
    const look = view ? `, then look ${degrees(view.pan)} / ${degrees(view.tilt)}, showing ${view.gain.toFixed(2)} m³ unseen` : "";
    this.words(`${title}${look}`, this.costs(proposal));
    setText(byId("confirm"), view && proposal.steps === 0 ? "Look" : "Walk");
  }

  private costs({ metres: length, seconds: time, steps, until }: Proposal): string {
    const left = Math.max(0, Math.round((until - performance.now()) / 1000));
    return `${metres(length)} · ${seconds(time)} · ${steps} steps${left < 20 ? ` · valid for ${left} s` : ""}`;
  }

  private countDown(): void {
    const state = this.app.mission.state.value;
    if (state.kind === "proposed") setText(byId("proposal-numbers"), this.costs(state.proposal));
  }

  private words(title: string, numbers: string): void {
    setText(byId("proposal-title"), title);
    setText(byId("proposal-numbers"), numbers);
  }
}

function capital(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
