// The keyboard. Escape and Space stop, wherever the focus is.
import type { App } from "../state/app";
import type { Preset } from "../scene/presets";
import { byId, el, isTyping, onClick } from "../ui/dom";

export interface KeyActions {
  stop(): void;
  near(): void;
  preset(preset: Preset): void;
  viewpoint(n: number): void;
}

const kHelp: [string, string][] = [
  ["Esc or Space", "STOP, always, also while you type"],
  ["T", "take control, or release it"],
  ["C", "walk the proposed way"],
  ["X", "cancel the proposed way"],
  ["N", "go to the nearest place that can be reached"],
  ["P", "pause, or resume"],
  ["E", "next best view"],
  ["H", "go home"],
  ["R", "begin a recording, or end it"],
  ["1 to 9", "turn the head to a viewpoint"],
  ["B, O, I", "3D from behind the robot, from above, through its eye"],
  ["Tab", "from part to part; Enter presses a button"],
  ["Arrows", "in 3D: turn (Shift: shift); on the map: move the cross; on the pad: turn the head"],
  ["+ and −", "zoom, in 3D and on the map"],
  ["Enter, [ and ]", "on the map: a way to the cross; its heading. Shift and Enter: add to the list"],
  ["?", "this help"],
];

function isStop(event: KeyboardEvent): boolean {
  return event.key === "Escape" || event.key === " " || event.code === "Space";
}

export class Keys {
  private readonly dialog = byId<HTMLDialogElement>("help-dialog");

  constructor(private readonly app: App, private readonly actions: KeyActions) {
    addEventListener("keydown", (event) => this.down(event), { capture: true });
    // Space on a focused button would click it when the key comes up.
    addEventListener("keyup", (event) => event.code === "Space" && event.preventDefault(), { capture: true });
    byId("keys").append(...kHelp.flatMap(([key, what]) => [el("dt", {}, el("kbd", {}, key)), el("dd", {}, what)]));
    // Not modal: STOP is to be within reach.
    onClick("help", () => this.dialog.show());
    onClick("help-close", () => this.dialog.close());
  }

  private down(event: KeyboardEvent): void {
    if (isStop(event)) return this.stop(event);
    if (event.ctrlKey || event.metaKey || event.altKey || isTyping(event.target) || event.repeat) return;
    if (this.letter(event.key.toLowerCase())) event.preventDefault();
  }

  private stop(event: KeyboardEvent): void {
    event.preventDefault();
    event.stopPropagation();
    if (event.repeat) return;
    this.actions.stop();
    if (this.dialog.open) this.dialog.close();
  }

  private letter(key: string): boolean {
    const { lease, mission, commands, link } = this.app;
    const orders: Record<string, () => void> = {
      t: () => void (lease.held ? lease.release() : lease.take()),
      c: () => void mission.confirm(),
      x: () => mission.cancel(),
      n: () => this.actions.near(),
      p: () => void (link.status?.paused ? commands.resume() : commands.pause()),
      e: () => void mission.explore(),
      h: () => void mission.goHome(),
      r: () => commands.switchRecording(),
      b: () => this.actions.preset("behind"),
      o: () => this.actions.preset("top"),
      i: () => this.actions.preset("eye"),
      "?": () => this.dialog.show(),
    };
    const order = orders[key] ?? (/^[1-9]$/.test(key) ? () => this.actions.viewpoint(Number(key)) : undefined);
    order?.();
    return order !== undefined;
  }
}
