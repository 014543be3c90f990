// Pointing at the floor: with a mouse, with fingers, and with keys.
import type { Goal } from "../state/mission";
import { wrapAngle } from "../ui/words";
import type { MapView, Spot } from "./map_view";

export interface MapActions {
  /** The goal that is being pointed at; null: none is. */
  point(goal: Goal | null): void;
  choose(goal: Goal, add: boolean): void;
  cross(goal: Goal | null): void;
  hover(place: Spot | null): void;
  moved(): void;
}

const kDragPixels = 12;

export class MapInput {
  private readonly pointers = new Map<number, Spot>();
  private down: { at: Spot; goal: Goal; add: boolean } | null = null;
  private crossAt: Goal | null = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly view: MapView,
    private readonly start: () => Spot,
    private readonly actions: MapActions,
  ) {
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    canvas.addEventListener("pointerup", (event) => this.lift(event));
    canvas.addEventListener("pointercancel", (event) => this.drop(event));
    canvas.addEventListener("pointerleave", () => actions.hover(null));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("keydown", (event) => this.key(event));
    canvas.addEventListener("blur", () => this.moveCross(null));
  }

  private press(event: PointerEvent): void {
    const at = spot(event);
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, at);
    // A second finger moves the map, and so does any button but the first.
    const points = this.pointers.size === 1 && event.button === 0;
    this.down = points ? { at, goal: this.view.toFloor(at), add: event.shiftKey } : null;
    this.actions.point(this.down?.goal ?? null);
  }

  private drag(event: PointerEvent): void {
    const at = spot(event);
    const before = this.pointers.get(event.pointerId);
    this.actions.hover(this.view.toFloor(at));
    if (!before) return;
    if (this.down) return this.turn(at);
    this.pan(event.pointerId, before, at);
  }

  private turn(at: Spot): void {
    if (!this.down) return;
    const [dx, dy] = [at.x - this.down.at.x, at.y - this.down.at.y];
    const { x, y } = this.down.goal;
    this.down.goal = Math.hypot(dx, dy) > kDragPixels ? { x, y, yaw: Math.atan2(-dy, dx) } : { x, y };
    this.actions.point(this.down.goal);
  }

  private pan(pointer: number, before: Spot, at: Spot): void {
    const other = [...this.pointers].find(([id]) => id !== pointer)?.[1];
    if (other) {
      const ratio = distance(at, other) / Math.max(1, distance(before, other));
      this.view.zoom(ratio, { x: (at.x + other.x) / 2, y: (at.y + other.y) / 2 });
      this.view.shift((at.x - before.x) / 2, (at.y - before.y) / 2);
    } else this.view.shift(at.x - before.x, at.y - before.y);
    this.pointers.set(pointer, at);
    this.actions.moved();
  }

  private lift(event: PointerEvent): void {
    this.pointers.delete(event.pointerId);
    const down = this.down;
    this.down = null;
    if (down) this.actions.choose(down.goal, down.add);
  }

  private drop(event: PointerEvent): void {
    this.pointers.delete(event.pointerId);
    this.down = null;
    this.actions.point(null);
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    this.view.zoom(Math.exp(-event.deltaY * 0.0015), spot(event));
    this.actions.moved();
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (!this.keyZoom(event.key) && !this.keyCross(event)) return;
    event.preventDefault();
    event.stopPropagation();
  }

  private keyZoom(key: string): boolean {
    const factor = key === "+" || key === "=" ? 1.2 : key === "-" ? 1 / 1.2 : 0;
    if (!factor) return false;
    this.view.zoom(factor);
    this.actions.moved();
    return true;
  }

  private keyCross(event: KeyboardEvent): boolean {
    const cross = this.crossAt ?? { ...this.start() };
    const step = event.shiftKey ? 0.5 : 0.1;
    const moves: Record<string, [number, number]> = {
      ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step],
    };
    const turns: Record<string, number> = { "[": Math.PI / 12, "]": -Math.PI / 12 };
    const [move, turn] = [moves[event.key], turns[event.key]];
    if (move) this.moveCross({ ...cross, x: cross.x + move[0], y: cross.y + move[1] });
    else if (turn) this.moveCross({ ...cross, yaw: wrapAngle((cross.yaw ?? 0) + turn) });
    else if (event.key === "Enter") this.actions.choose(cross, event.shiftKey);
    else return false;
    return true;
  }

  private moveCross(goal: Goal | null): void {
    this.crossAt = goal;
    this.actions.cross(goal);
  }
}

function spot(event: MouseEvent): Spot {
  return { x: event.offsetX, y: event.offsetY };
}

function distance(a: Spot, b: Spot): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}
