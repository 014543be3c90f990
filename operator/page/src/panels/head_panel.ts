// The head: where it looks, turning it, and what a look elsewhere would see.
import type { App, HeadPose } from "../state/app";
import type { OperatorStatus } from "../wire/messages";
import { byId, fitCanvas, onClick, setPressed, setText } from "../ui/dom";
import { beforeNextFrame } from "../ui/frame";
import { theme, themeColor } from "../ui/theme";
import { degrees } from "../ui/words";
import { PadScale, clampPose, paintPad, viewpoints } from "./pad_paint";

const kStep = (2 * Math.PI) / 180;
const kDegree = Math.PI / 180;

export class HeadPanel {
  private readonly pad = byId<HTMLCanvasElement>("pad");
  private readonly pan = byId<HTMLInputElement>("pan");
  private readonly tilt = byId<HTMLInputElement>("tilt");
  private trying = false;
  /** Where it was told to look, until it looks there. */
  private aim: HeadPose | null = null;
  private dragging = false;
  private sliding = false;
  private shownPose = "";

  constructor(private readonly app: App) {
    app.link.on("status", (status) => this.show(status));
    app.whatIf.watch(() => this.draw());
    app.mission.state.watch((state) => {
      if (state.kind === "proposed" && state.proposal.view) this.tryOut(state.proposal.view);
    });
    onClick("mode-look", () => this.setMode(false));
    onClick("mode-try", () => this.setMode(true));
    onClick("look-there", () => this.lookThere());
    onClick("look-around", () => void app.commands.lookAround());
    this.startPad();
    this.startSliders();
    this.setMode(false);
    theme.watch(this.draw);
    new ResizeObserver(this.draw).observe(this.pad);
  }

  /** One of nine, from 1. */
  viewpoint(n: number): void {
    const { status } = this.app.link;
    const pose = status && viewpoints(status)[n - 1];
    if (pose) this.turnTo(pose);
  }

  readonly draw = (): void => beforeNextFrame(this.paint);

  private setMode(trying: boolean): void {
    this.trying = trying;
    setPressed(byId("mode-look"), !trying);
    setPressed(byId("mode-try"), trying);
    byId("look-there").hidden = !trying;
    byId("look-around").hidden = trying;
    const { status } = this.app.link;
    this.app.whatIf.set(trying && status ? { pan: status.pan, tilt: status.tilt } : null);
    this.aim = null;
  }

  private tryOut(pose: HeadPose): void {
    this.setMode(true);
    this.app.whatIf.set({ pan: pose.pan, tilt: pose.tilt });
  }

  private lookThere(): void {
    const pose = this.app.whatIf.value;
    this.setMode(false);
    if (pose) this.turnTo(pose);
  }

  /** Turns the head, or shows what it would see. */
  private turnTo(wanted: HeadPose, final = true): void {
    const { status } = this.app.link;
    if (!status) return;
    const pose = clampPose(wanted, status);
    if (this.trying) return this.app.whatIf.set(pose);
    this.aim = pose;
    if (final) void this.app.commands.look(pose.pan, pose.tilt);
    this.draw();
  }

  private startPad(): void {
    const { pad } = this;
    const turn = (event: PointerEvent, final: boolean): void => {
      const { status } = this.app.link;
      if (status) this.turnTo(new PadScale(status, pad.clientWidth, pad.clientHeight).pose(event.offsetX, event.offsetY), final);
    };
    pad.addEventListener("pointerdown", (event) => {
      this.dragging = true;
      pad.setPointerCapture(event.pointerId);
      turn(event, false);
    });
    pad.addEventListener("pointermove", (event) => this.dragging && turn(event, false));
    pad.addEventListener("pointerup", (event) => {
      if (this.dragging) turn(event, true);
      this.dragging = false;
    });
    pad.addEventListener("pointercancel", () => (this.dragging = false));
    pad.addEventListener("keydown", (event) => this.key(event));
  }

  private key(event: KeyboardEvent): void {
    const steps: Record<string, [number, number]> = {
      ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1],
    };
    const step = steps[event.key];
    const from = this.app.whatIf.value ?? this.aim ?? this.app.link.status;
    if (!step || !from) return;
    event.preventDefault();
    this.turnTo({ pan: from.pan + step[0] * kStep, tilt: from.tilt + step[1] * kStep });
  }

  private startSliders(): void {
    const pose = (): HeadPose => ({ pan: this.pan.valueAsNumber * kDegree, tilt: this.tilt.valueAsNumber * kDegree });
    for (const slider of [this.pan, this.tilt]) {
      slider.addEventListener("input", () => {
        this.sliding = true;
        this.turnTo(pose(), false);
        this.showOutputs(pose());
      });
      slider.addEventListener("change", () => {
        this.sliding = false;
        this.turnTo(pose());
      });
    }
  }

  private show(status: OperatorStatus): void {
    setText(byId("head-angles"), `pan ${degrees(status.pan)}, tilt ${degrees(status.tilt)}`);
    const arrived = this.aim && Math.hypot(this.aim.pan - status.pan, this.aim.tilt - status.tilt) < 0.02;
    if (arrived && !this.dragging && !this.sliding) this.aim = null;
    this.showSliders(status);
    const pose = `${status.pan.toFixed(3)},${status.tilt.toFixed(3)},${this.aim !== null}`;
    if (pose !== this.shownPose) this.draw();
    this.shownPose = pose;
  }

  private showSliders(status: OperatorStatus): void {
    const pose = this.app.whatIf.value ?? this.aim ?? status;
    const set = (slider: HTMLInputElement, low: number, high: number, value: number): void => {
      slider.min = (low / kDegree).toFixed(1);
      slider.max = (high / kDegree).toFixed(1);
      if (!this.sliding) slider.value = (value / kDegree).toFixed(1);
    };
    set(this.pan, status.pan_low, status.pan_high, pose.pan);
    set(this.tilt, status.tilt_low, status.tilt_high, pose.tilt);
    if (!this.sliding) this.showOutputs(pose);
  }

  private showOutputs({ pan, tilt }: HeadPose): void {
    setText(byId("pan-out"), degrees(pan));
    setText(byId("tilt-out"), degrees(tilt));
  }

  private readonly paint = (): void => {
    const { pad } = this;
    const { status } = this.app.link;
    if (!status || pad.clientWidth === 0) return;
    fitCanvas(pad);
    const context = pad.getContext("2d");
    if (!context) return;
    const ratio = pad.width / pad.clientWidth;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const tried = this.app.whatIf.value;
    paintPad(context, pad.clientWidth, pad.clientHeight, status, status, tried ?? this.aim, themeColor(tried ? "ghost" : "field"));
  };
}
