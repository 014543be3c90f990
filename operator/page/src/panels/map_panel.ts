// The map of the floor: where the robot is, goes and may go; a click asks for a way.
import type { App } from "../state/app";
import { feetOf } from "../state/feet";
import type { FloorImage } from "../state/floor_image";
import type { Goal } from "../state/mission";
import type { SweptImage } from "../state/swept_image";
import type { OperatorStatus } from "../wire/messages";
import { byId, el, fitCanvas, onClick, setPressed, setText } from "../ui/dom";
import { beforeNextFrame } from "../ui/frame";
import { theme } from "../ui/theme";
import { degrees, place } from "../ui/words";
import { MapInput } from "./map_input";
import { type MapContents, paintMap } from "./map_paint";
import { MapView, type Spot } from "./map_view";

export class MapPanel {
  private readonly canvas = byId<HTMLCanvasElement>("map-canvas");
  private readonly view = new MapView();
  private readonly contents: MapContents;
  /** Until the operator moves the map it shows all that is known. */
  private fitted = true;
  /** A click adds to the list of goals, without Shift: fingers have none. */
  private listing = false;
  private shownPose = "";

  constructor(private readonly app: App, floor: FloorImage) {
    this.contents = { body: null, floor, status: undefined, plan: [], preview: [], feet: [], pointed: null, tour: [], cross: null };
    this.listen();
    new MapInput(this.canvas, this.view, () => this.robot(), {
      point: (goal) => this.update({ pointed: goal ?? app.mission.pointed.value }),
      choose: (goal, add) => this.choose(goal, add),
      cross: (cross) => this.showCross(cross),
      hover: (at) => this.showPlace(at),
      moved: () => this.moved(),
    });
    onClick("map-in", () => this.zoom(1.3));
    onClick("map-out", () => this.zoom(1 / 1.3));
    onClick("map-fit", () => this.refit());
    onClick("map-list", () => this.listGoals(!this.listing));
    theme.watch(this.draw);
    new ResizeObserver(this.draw).observe(this.canvas);
  }

  readonly draw = (): void => beforeNextFrame(this.paint);

  /** Where a place of the floor shows, in pixels from the map's corner. */
  screenOf(x: number, y: number): Spot {
    return this.view.toScreen({ x, y });
  }

  private listen(): void {
    const { link, mission } = this.app;
    link.on("status", (status) => this.takeStatus(status));
    link.on("plan", ({ poses }) => this.update({ plan: poses.map(({ pose }) => pose.position) }));
    link.on("preview", ({ poses }) => this.update({ preview: poses.map(({ pose }) => pose.position) }));
    link.on("footsteps", (message) => this.update({ feet: feetOf(message) }));
    for (const name of ["planBody", "previewBody"] as const) link.on(name, this.draw);
    this.app.showsBody.watch(this.draw);
    mission.pointed.watch((pointed) => this.update({ pointed }));
    mission.state.watch(() => this.draw());
    mission.tour.watch((tour) => this.showTour(tour));
  }

  /** What stands still is not drawn again. */
  private takeStatus(status: OperatorStatus): void {
    const { x, y, yaw, pan, has_goal, goal_x, goal_y, goal_yaw } = status;
    const pose = [x, y, yaw, pan, goal_x, goal_y, goal_yaw].map((v) => v.toFixed(3)).join() + String(has_goal);
    this.contents.status = status;
    if (pose !== this.shownPose) this.draw();
    this.shownPose = pose;
  }

  private update(news: Partial<MapContents>): void {
    Object.assign(this.contents, news);
    this.draw();
  }

  private readonly paint = (): void => {
    const { canvas, view } = this;
    if (canvas.clientWidth === 0) return;
    fitCanvas(canvas);
    view.width = canvas.clientWidth;
    view.height = canvas.clientHeight;
    const { floor } = this.contents;
    if (this.fitted && floor.known) view.fit(floor.x, floor.y, floor.width, floor.height);
    const context = canvas.getContext("2d");
    if (!context) return;
    const ratio = canvas.width / canvas.clientWidth;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const preview = this.app.showsProposal ? this.contents.preview : [];
    paintMap(context, view, { ...this.contents, preview, body: this.shownBody() });
  };

  private shownBody(): SweptImage | null {
    const { body, showsBody } = this.app;
    const shown = showsBody.value && body.area > 0 ? body : null;
    byId("body-legend").hidden = !shown;
    if (shown) setText(byId("body-area"), `swept by the body: ${shown.area.toFixed(1)} m², cells of ${(100 * shown.cell).toFixed(0)} cm`);
    return shown;
  }

  private robot(): Spot {
    const { status } = this.app.link;
    return status ? { x: status.x, y: status.y } : { x: 0, y: 0 };
  }

  private choose(goal: Goal, add: boolean): void {
    if (!this.app.lease.held) {
      this.app.lease.notice.set("Take control first: then a click on the map asks for a way.");
      this.update({ pointed: this.app.mission.pointed.value });
    } else if (add || this.listing) {
      this.update({ pointed: null });
      void this.app.mission.addToTour(goal);
    } else void this.app.mission.preview(goal);
  }

  private showCross(cross: Goal | null): void {
    this.update({ cross });
    this.showPlace(cross);
  }

  private showPlace(at: Goal | null): void {
    const cursor = byId("map-cursor");
    cursor.hidden = at === null;
    if (!at) return;
    const what = this.contents.floor.at(at.x, at.y) ?? "unseen";
    const heading = at.yaw === undefined ? "" : `, ${degrees(at.yaw)}`;
    cursor.textContent = `${place(at.x, at.y)}${heading}: ${what}`;
  }

  private moved(): void {
    this.fitted = false;
    this.draw();
  }

  private zoom(factor: number): void {
    this.view.zoom(factor);
    this.moved();
  }

  private refit(): void {
    this.fitted = true;
    this.draw();
  }

  private listGoals(on: boolean): void {
    this.listing = on;
    setPressed(byId("map-list"), on);
  }

  private showTour(tour: readonly Goal[]): void {
    this.update({ tour });
    if (tour.length === 0) this.listGoals(false);
    const list = byId("tour");
    list.hidden = tour.length === 0;
    const clear = el("button", { type: "button", class: "quiet" }, "Clear list");
    clear.addEventListener("click", () => this.app.mission.clearTour());
    list.replaceChildren(...tour.map(({ x, y }) => el("li", {}, place(x, y))), el("li", { class: "clear" }, clear));
  }
}
