// The time line of a recording that is played in place of a robot.
import type { App } from "../state/app";
import type { OperatorStatus } from "../wire/messages";
import { byId, onClick, setText } from "../ui/dom";

export class Player {
  private readonly time = byId<HTMLInputElement>("played-time");
  private readonly speed = byId<HTMLSelectElement>("played-speed");
  private dragged = false;
  private paused = false;

  constructor(app: App) {
    const steer = (request: object) => void app.link.call("play", request);
    onClick("played-pause", () => steer({ play: this.paused }));
    this.time.addEventListener("input", () => { this.dragged = true; });
    this.time.addEventListener("change", () => {
      this.dragged = false;
      steer({ at: Number(this.time.value) });
    });
    this.speed.addEventListener("change", () => steer({ speed: Number(this.speed.value) }));
    app.link.on("status", (status) => this.show(status));
  }

  private show(status: OperatorStatus): void {
    const played = status.recording_name !== "";
    byId("player").hidden = !played;
    byId("moves").hidden = played;
    if (!played) return;
    this.paused = status.played_paused;
    this.time.min = String(status.played_from);
    this.time.max = String(status.played_to);
    if (!this.dragged) this.time.value = String(status.played_at);
    setText(byId("played-pause"), this.paused ? "Play" : "Hold");
    const of = (seconds: number) => (seconds - status.played_from).toFixed(1);
    setText(byId("played-at"), `${of(status.played_at)} of ${of(status.played_to)} s · ${status.recording_name}`);
  }
}
