// Control, ways that are shown before they are walked, and what else the robot is told.
import type { Answer } from "../wire/protocol";
import type { Robot } from "../wire/robot";
import { byId, make, metres } from "./dom";

/** Says what came of an order, where it was refused. */
export function tell(answer: Answer): boolean {
  if (!answer.ok) notice(answer.error ?? "refused", true);
  return answer.ok;
}

function notice(text: string, bad = false, ...more: Node[]): void {
  byId("plan").replaceChildren(make("p", { class: bad ? "bad" : "" }, text), ...more);
}

export class Go {
  goals: [number, number][] = []; // of a list that is being made

  constructor(private robot: Robot) {
    byId("explore").addEventListener("click", async () => this.show(await robot.ask("explore_preview")));
    byId("home").addEventListener("click", async () => this.show(await robot.ask("go_home")));
    byId("pause").addEventListener("click", async () => tell(await robot.ask("pause")));
    byId("resume").addEventListener("click", async () => tell(await robot.ask("resume")));
    robot.onChange(() => this.control());
    robot.on("/headway/status", (now) => {
      byId<HTMLButtonElement>("resume").hidden = !now.paused;
      byId<HTMLButtonElement>("pause").hidden = now.paused;
      this.control();
    });
    notice("Click on the floor for a way there; drag to choose how it shall face. Nothing is walked that was not confirmed.");
    this.control();
  }

  async preview(x: number, y: number, yaw?: number, near = false): Promise<void> {
    this.goals = [];
    const body: Record<string, unknown> = { x, y };
    if (yaw !== undefined) body.yaw_deg = (yaw * 180) / Math.PI;
    if (near) body.near = true;
    this.show(await this.robot.ask("plan_preview", body), () => void this.preview(x, y, yaw, true));
  }

  async add(x: number, y: number): Promise<void> {
    this.goals.push([x, y]);
    this.show(await this.robot.ask("tour", { goals: this.goals }));
  }

  private show(way: Answer, asNear?: () => void): void {
    if (!way.ok) {
      const nearest = way.nearest as [number, number] | undefined;
      const more = nearest && asNear
        ? [make("button", { type: "button", click: asNear }, `As near as it gets: (${metres(nearest[0])}, ${metres(nearest[1])})`)] : [];
      notice(way.error ?? "refused", true, ...more);
      return;
    }
    const view = way.view as { pan_deg: number; tilt_deg: number; gain_m3: number } | undefined;
    const walk = Number(way.steps) > 0
      ? `${Number(way.metres).toFixed(1)} m in ${Number(way.seconds).toFixed(0)} s, ${way.steps} steps` : "no walk";
    const text = (this.goals.length > 1 ? `The first of ${this.goals.length} places: ` : "")
      + (view ? `A look (pan ${view.pan_deg}°, tilt ${view.tilt_deg}°) would show ${view.gain_m3} m³ of unseen space; ` : "") + walk
      + (way.note ? `. ${way.note}` : "");
    const confirm = make("button", { type: "button", class: "primary", id: "confirm",
      click: () => void this.confirm(Number(way.plan)) }, view && !Number(way.steps) ? "Look there" : "Walk it");
    const cancel = make("button", { type: "button", id: "cancel", click: () => this.cancel() }, "Cancel");
    notice(text, false, make("div", { class: "buttons" }, confirm, cancel));
    confirm.focus();
  }

  private async confirm(plan: number): Promise<void> {
    this.goals = [];
    if (tell(await this.robot.ask("plan_confirm", { plan }))) notice("It was told. Esc or Space stops it.");
  }
  private cancel(): void {
    this.goals = [];
    void this.robot.ask("forget_plan");
    notice("Nothing is walked.");
  }

  private shown = "";
  private control(): void {
    const robot = this.robot;
    const holder = robot.status()?.lease_holder ?? "";
    const text = !robot.connected ? "" : robot.inControl ? "mine" : robot.role !== "operator" ? "viewer" : holder || "nobody";
    document.body.classList.toggle("in-control", robot.inControl);
    for (const button of document.querySelectorAll<HTMLButtonElement>("[data-control]")) button.disabled = !robot.inControl;
    if (text === this.shown) return;
    this.shown = text;
    const place = byId("control");
    if (text === "mine")
      place.replaceChildren(make("span", { class: "mine" }, "You have control."),
        make("button", { type: "button", id: "release", click: () => void robot.releaseControl() }, "Hand it back"));
    else if (text === "viewer") place.replaceChildren("You look on, and may stop the robot.");
    else if (text === "") place.replaceChildren("Not connected.");
    else
      place.replaceChildren(text === "nobody" ? "Nobody has control." : `${text} has control.`,
        make("button", { type: "button", class: "primary", id: "take",
          click: () => void robot.takeControl("operator").then(tell) }, "Take control"));
  }
}
