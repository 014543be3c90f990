// Who has control, how the robot and the link are, and the recorder.
import type { App } from "../state/app";
import type { OperatorStatus } from "../wire/messages";
import { byId, onClick, setPressed, setText } from "../ui/dom";
import { milliseconds, recorded } from "../ui/words";

type Level = "good" | "warn" | "bad" | "off";

function chip(id: string, level: Level, text: string): void {
  byId(id).dataset["level"] = level;
  setText(byId(id), text);
}

const kSafetyLevels: Record<string, Level> = {
  init: "warn", ready: "good", active: "good", degraded: "warn", "safe stop": "bad", fault: "bad",
};

export class TopBar {
  constructor(private readonly app: App) {
    const { link, lease } = app;
    link.on("status", (status) => this.show(status));
    link.robot.watch((robot) => {
      setText(byId("robot"), robot);
      document.title = robot ? `Headway: ${robot}` : "Headway";
    });
    lease.number.watch(() => this.showControl());
    link.role.watch(() => this.showControl());
    this.startControl();
    onClick("record", () => app.commands.switchRecording());
    setInterval(() => this.showLink(), 500);
  }

  private startControl(): void {
    const { lease } = this.app;
    const name = byId<HTMLInputElement>("name");
    name.value = lease.name === "operator" ? "" : lease.name;
    name.addEventListener("change", () => (lease.name = name.value));
    byId("control").addEventListener("submit", (event) => {
      event.preventDefault();
      lease.name = name.value;
      void lease.take();
    });
    onClick("release", () => void lease.release());
  }

  private show(status: OperatorStatus): void {
    chip("safety", kSafetyLevels[status.safety] ?? "off", status.safety);
    byId("safety").title = status.safety_reason;
    byId("simulated").hidden = !status.simulated;
    setText(byId("simulated"), status.speed === 1 ? "simulated" : `simulated × ${status.speed.toFixed(1)}`);
    this.showRecorder(status);
    this.showControl();
  }

  private showRecorder(status: OperatorStatus): void {
    const { recording, record_folder: folder, record_file: file, record_fault: fault } = status;
    const what = "images, CAN frames, poses, map, ways and steps (R)";
    setPressed(byId("record"), recording);
    byId("record").hidden = folder === "";
    byId("record").dataset["failed"] = String(fault !== "");
    byId("record").title = recording ? `Records into ${file}: ${what}` : `${fault ? `${fault}. ` : ""}Records into ${folder}: ${what}`;
    setText(byId("record-text"), recording ? `Recording ${recorded(status)}` : fault ? "Record (failed)" : "Record");
  }

  private showControl(): void {
    const { lease, link } = this.app;
    const viewer = link.role.value === "viewer";
    const holder = link.status?.lease_holder ?? "";
    const foreign = !lease.held && holder !== "";
    setText(byId("holder"), lease.held ? "You have control" : foreign ? `${holder} has control` : viewer ? "You may watch" : "Nobody has control");
    byId("holder").dataset["who"] = lease.held ? "me" : foreign ? "other" : "nobody";
    byId("take").hidden = lease.held || viewer;
    byId<HTMLButtonElement>("take").disabled = foreign;
    byId("release").hidden = !lease.held;
    byId("name").parentElement!.hidden = lease.held || viewer;
    document.body.dataset["control"] = String(lease.held);
    for (const id of ["record", "home", "pause", "resume", "explore", "look-around", "look-there", "mode-look"]) {
      byId<HTMLButtonElement>(id).disabled = !lease.held;
    }
  }

  private showLink(): void {
    const { link } = this.app;
    const { roundTripMs, dropped } = link.quality;
    if (!link.live) return chip("link", "bad", "No link");
    const level = roundTripMs > 150 || dropped > 0.2 ? "warn" : "good";
    chip("link", level, Number.isFinite(roundTripMs) ? `Link ${milliseconds(roundTripMs)}` : "Link");
  }
}
