// How the parts of the robot are, and what was counted.
import type { App } from "../state/app";
import type { OperatorStatus } from "../wire/messages";
import { byId, el, setText } from "../ui/dom";
import { recorded } from "../ui/words";

const kBad = /fault|lost|gone|degraded|stop|dead|not homed|error|late/i;

export class Facts {
  private readonly values = new Map<string, HTMLElement>();

  constructor(app: App) {
    app.link.on("status", (status) => this.show(status));
  }

  private show(status: OperatorStatus): void {
    this.set("Safety", status.safety_reason ? `${status.safety}: ${status.safety_reason}` : status.safety, status.safety);
    this.set("Head", status.head);
    this.set("Legs", status.control_computer);
    this.set("Frames", `${status.frames} · ${status.frame_level}`, status.frame_level);
    this.set("Lost", `${status.frames_lost} · ${status.frames_late} late`, "");
    this.set("Unusable", `${status.frames_unusable} · ${status.frames_no_pose} no pose`, "");
    this.set("Plans", `${status.plans} · ${status.replans} changed`);
    this.set("Pages open", `${status.clients}`);
    this.showRecording(status);
    byId("reset").hidden = !/^(fault|safe ?stop)$/i.test(status.safety);
  }

  private showRecording(status: OperatorStatus): void {
    const { record_file: file, record_fault: fault } = status;
    const name = file.slice(file.lastIndexOf("/") + 1);
    const written = name ? `${name} · ${recorded(status)}` : "";
    const is = status.recording ? "on" : status.record_folder ? "off" : "not here";
    this.set("Recording", fault || [is, written].filter(Boolean).join(" · "), fault ? "fault" : "");
  }

  private set(name: string, text: string, judged = text): void {
    let value = this.values.get(name);
    if (!value) {
      value = el("dd");
      this.values.set(name, value);
      byId("facts").append(el("dt", {}, name), value);
    }
    setText(value, text);
    value.classList.toggle("bad", kBad.test(judged));
  }
}
