// The 3D view: brings what the robot tells into the scene.
import { Vector3 } from "three";
import type { App } from "../state/app";
import { feetOf } from "../state/feet";
import type { FloorImage } from "../state/floor_image";
import type { SweptImage } from "../state/swept_image";
import { Cloud } from "../scene/cloud";
import { kGoalColor, kPlanColor, kPreviewColor } from "../scene/colours";
import { Ellipsoids, kLarger } from "../scene/ellipsoids";
import { Feet } from "../scene/feet";
import { Field } from "../scene/field";
import { Floor } from "../scene/floor";
import { GoalFlag } from "../scene/goal_flag";
import { startSceneKeys } from "../scene/keys";
import { type Choice, Layers } from "../scene/layers";
import { showLegends } from "../scene/legends";
import { type Preset, Presets } from "../scene/presets";
import { RobotBody } from "../scene/robot_body";
import { Stage } from "../scene/stage";
import { Swept } from "../scene/swept";
import { Transforms } from "../scene/transforms";
import { Voxels } from "../scene/voxels";
import { type Place, Way, placesOf } from "../scene/ways";
import { byId, setPressed } from "../ui/dom";
import { theme, themeColor } from "../ui/theme";
import { millimetres } from "../ui/words";

const kPickWithin = 14; // pixels of the style sheet

export class ScenePanel {
  readonly stage: Stage;
  readonly voxels: Voxels;
  readonly cloud = new Cloud();
  private readonly transforms = new Transforms();
  private readonly robot = new RobotBody();
  private readonly ellipsoids = new Ellipsoids();
  private readonly field = new Field();
  private readonly floor = new Floor();
  private readonly body = new Swept();
  private readonly feet = new Feet();
  private readonly plan = new Way(kPlanColor, 0.045, 0.006);
  private readonly preview = new Way(kPreviewColor, 0.06, 0.01, 0.12);
  private readonly goal = new GoalFlag(kGoalColor);
  private readonly pointed = new GoalFlag(kPreviewColor);
  private readonly presets: Presets;
  private readonly layers: Layers;
  private placed = false;
  private shownPose = "";
  private proposed: Place[] = [];
  private shownBody: SweptImage | null = null;

  constructor(private readonly app: App, private readonly floorImage: FloorImage) {
    this.stage = new Stage(byId<HTMLCanvasElement>("scene-canvas"));
    this.voxels = new Voxels(this.stage.drawSoon);
    this.presets = new Presets(this.stage, this.transforms, () => this.showPreset());
    this.fill();
    this.layers = new Layers(byId("layers"), (choice) => this.show(choice));
    this.listen();
    this.startInput();
    showLegends();
    theme.watch(() => (this.voxels.floorColor = themeColor("floor-voxels")));
  }

  floorChanged(): void {
    this.floor.show(this.floorImage);
    this.show(this.layers.choice);
  }

  private fill(): void {
    this.stage.add(
      this.floor.object, this.body.object, this.plan.object, this.preview.object, this.feet.object, this.goal.object, this.pointed.object,
      this.robot.object, this.voxels.occupied, this.cloud.object, this.ellipsoids.sampled, this.ellipsoids.picked,
      this.voxels.unseen, this.field.now.object, this.field.ghost.object,
    );
    this.robot.object.visible = false;
    this.stage.beforeDraw(() => {
      this.cloud.pixels = this.stage.canvas.height;
      this.preview.show(this.app.showsProposal ? this.proposed : []);
      this.showBody();
      this.place();
    });
  }

  private listen(): void {
    const { link, mission, whatIf } = this.app;
    const drawn = <T>(take: (message: T) => void) => (message: T) => {
      take(message);
      this.stage.drawSoon();
    };
    link.on("tf", (message) => this.transforms.take(message, link.status));
    link.on("status", () => {
      if (this.moved()) this.stage.drawSoon();
    });
    link.on("points", drawn((message) => {
      this.cloud.take(message);
      this.ellipsoids.forget();
      byId("pick").hidden = true;
      if (this.ellipsoids.sampled.visible) this.ellipsoids.sample(this.cloud, this.eye());
    }));
    link.on("voxels", (message) => this.voxels.take(message));
    link.on("field", drawn((message) => this.takeField(message)));
    link.on("plan", drawn((message) => this.plan.show(placesOf(message))));
    link.on("preview", drawn((message) => (this.proposed = placesOf(message))));
    link.on("planBody", drawn(() => (this.shownBody = null)));
    link.on("previewBody", drawn(() => (this.shownBody = null)));
    mission.state.watch(drawn(() => undefined));
    link.on("footsteps", drawn((message) => this.feet.show(feetOf(message))));
    mission.pointed.watch(drawn((goal) => this.pointed.show(goal)));
    whatIf.watch(() => this.stage.draw());
  }

  private showBody(): void {
    const { body, showsBody } = this.app;
    this.body.object.visible = showsBody.value && body.area > 0;
    if (body !== this.shownBody) this.body.show(body);
    this.shownBody = body;
  }

  private takeField(message: Parameters<Field["take"]>[0]): void {
    this.field.take(message);
    this.layers.offerFields(this.field.names);
  }

  /** Robot, fields and view follow what the robot tells of itself. */
  private place(): void {
    const { status } = this.app.link;
    if (!status || !this.transforms.known) return;
    const { base, chest, camera } = this.transforms;
    this.robot.place(base, chest, status);
    this.field.now.place(camera);
    const tried = this.app.whatIf.value;
    this.field.ghost.object.visible = tried !== null;
    if (tried) this.field.ghost.place(this.transforms.cameraAt(tried));
    this.goal.show(status.has_goal ? { x: status.goal_x, y: status.goal_y, ...(status.goal_has_yaw ? { yaw: status.goal_yaw } : {}) } : null);
    if (!this.placed) this.first();
    this.presets.follow();
  }

  /** What stands still is not drawn again. */
  private moved(): boolean {
    const { status } = this.app.link;
    const { camera, chest } = this.transforms;
    const goal = status?.has_goal ? [status.goal_x, status.goal_y, status.goal_yaw] : [];
    const pose = [...camera.elements, ...chest.elements, ...goal].map((v) => v.toFixed(4)).join();
    const moved = pose !== this.shownPose;
    this.shownPose = pose;
    return moved;
  }

  private first(): void {
    this.placed = true;
    this.presets.choose("behind");
    this.show(this.layers.choice);
  }

  private show({ layers, field, colour }: Choice): void {
    this.cloud.object.visible = layers["cloud"] ?? true;
    this.cloud.asPictured = colour === "picture";
    this.voxels.occupied.visible = layers["occupied"] ?? true;
    this.voxels.unseen.visible = layers["unseen"] ?? false;
    this.floor.object.visible = (layers["floor"] ?? true) && this.floorImage.known;
    for (const part of [this.plan, this.preview, this.feet]) part.object.visible = layers["steps"] ?? true;
    this.app.showsBody.set(layers["body"] ?? true);
    this.ellipsoids.sampled.visible = layers["ellipsoids"] ?? false;
    if (this.ellipsoids.sampled.visible) this.ellipsoids.sample(this.cloud, this.eye());
    this.field.choose(field || "rig");
    this.field.now.object.visible = field !== "" && this.placed;
    this.showRobot(layers["robot"] ?? true);
    byId("sigma-legend").hidden = colour === "picture" || !this.cloud.object.visible;
    byId("height-legend").hidden = !this.voxels.occupied.visible;
    this.stage.draw();
  }

  /** Nobody sees the robot's head through its own eyes. */
  private showRobot(wanted = this.layers.choice.layers["robot"] ?? true): void {
    this.robot.object.visible = wanted && this.placed && this.presets.current !== "eye";
  }

  private showPreset(): void {
    for (const button of document.querySelectorAll<HTMLElement>("[data-preset]")) {
      setPressed(button, button.dataset["preset"] === this.presets.current);
    }
    if (this.placed) this.showRobot();
    this.stage.draw();
  }

  choosePreset(preset: Preset): void {
    this.presets.choose(preset);
  }

  private startInput(): void {
    for (const button of document.querySelectorAll<HTMLElement>("[data-preset]")) {
      button.addEventListener("click", () => this.choosePreset(button.dataset["preset"] as Preset));
    }
    startSceneKeys(this.stage, () => this.presets.free());
    const { canvas } = this.stage;
    let down: PointerEvent | null = null;
    canvas.addEventListener("pointerdown", (event) => (down = event));
    canvas.addEventListener("pointerup", (event) => {
      const still = down && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) < 5;
      if (still) this.pick(event.offsetX, event.offsetY);
    });
  }

  private eye(): Vector3 {
    return new Vector3().setFromMatrixPosition(this.transforms.camera);
  }

  /** The point that is drawn nearest to where was clicked. */
  private pick(x: number, y: number): void {
    const index = this.cloud.object.visible ? this.nearest(x, y) : -1;
    byId("pick").hidden = index < 0;
    if (index < 0) this.ellipsoids.forget();
    else {
      const { sigma, distance } = this.ellipsoids.pick(this.cloud, index, this.eye());
      byId("pick").textContent = `Point at ${distance.toFixed(2)} m: σ ${millimetres(sigma)} along the ray. The ellipsoid that holds it with 95 % is drawn ${kLarger} × as large.`;
    }
    this.stage.draw();
  }

  private nearest(x: number, y: number): number {
    const { clientWidth, clientHeight } = this.stage.canvas;
    const at = new Vector3();
    let [best, score] = [-1, Infinity];
    for (let i = 0; i < this.cloud.count; ++i) {
      at.fromArray(this.cloud.position, 3 * i).project(this.stage.camera);
      if (at.z > 1) continue;
      const off = Math.hypot(((at.x + 1) / 2) * clientWidth - x, ((1 - at.y) / 2) * clientHeight - y);
      // Of points that lie together on the screen, the one in front.
      if (off < kPickWithin && off + at.z < score) [best, score] = [i, off + at.z];
    }
    return best;
  }
}
