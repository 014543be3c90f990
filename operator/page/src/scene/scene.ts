// Space as the robot knows it, drawn when something has changed.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Cloud, Marker, Markers, Path, Transforms } from "../wire/messages";
import { css, precision, viridis } from "./colours";
import { Figure } from "./figure";
import { VoxelLayer } from "./voxels";

export type View = "behind" | "top" | "eye";
export const kLayers = {
  cloud: "points by precision", voxels: "occupied", unseen: "border of the unseen", field: "what the rig sees",
  ellipsoids: "ellipsoids", feet: "feet and way", robot: "robot",
} as const;
export type Layer = keyof typeof kLayers;

const kSlow = 25; // a picture that takes longer [ms]
const kEllipsoids = 400;
const kMagnified = 3; // standard deviations that an ellipsoid shows

/** A machine that draws by its processor alone: then smooth edges cost more than they are worth. */
function drawsInSoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = gl && info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}
const kSoftware = drawsInSoftware();

function colour(name: string): THREE.Color {
  return new THREE.Color(css(name));
}

export class Scene {
  readonly voxels = new VoxelLayer();
  resolution = "rig"; // which field is shown
  private renderer = new THREE.WebGLRenderer({ antialias: !kSoftware });
  private scene = new THREE.Scene();
  private camera = new THREE.PerspectiveCamera(50, 1, 0.05, 100);
  private controls: OrbitControls;
  private layers = Object.fromEntries(Object.keys(kLayers).map((name) => [name, new THREE.Group()])) as
    Record<Layer, THREE.Group>;
  private figure = new Figure();
  private cloud = new THREE.Points(new THREE.BufferGeometry(),
    new THREE.PointsMaterial({ size: 2.2, sizeAttenuation: false, vertexColors: true }));
  private grid?: THREE.GridHelper;
  private eye = new THREE.Group(); // in the frame camera_left
  private imagined = new THREE.Group(); // the same, where the head might look
  private chest = new THREE.Matrix4();
  private lastCloud?: Cloud;
  private fields: Marker[] = [];
  private asked = false;
  private took = 0; // the newest picture [ms]
  private base = { x: 0, y: 0, yaw: 0 };

  constructor(private place: HTMLElement) {
    THREE.Object3D.DEFAULT_UP.set(0, 0, 1);
    this.camera.up.set(0, 0, 1);
    this.renderer.setPixelRatio(kSoftware ? 0.75 : Math.min(devicePixelRatio, 2));
    this.renderer.domElement.setAttribute("aria-label", "Space around the robot; drag to turn, scroll to come nearer");
    this.renderer.domElement.setAttribute("role", "img");
    this.renderer.domElement.tabIndex = 0;
    place.append(this.renderer.domElement);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.listenToKeyEvents(this.renderer.domElement);
    this.controls.addEventListener("change", () => this.draw());
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x667788, 2.6), ...Object.values(this.layers));
    this.layers.robot.add(this.figure.body);
    this.layers.cloud.add(this.cloud);
    this.layers.voxels.add(this.voxels.full);
    this.layers.unseen.add(this.voxels.border);
    for (const frame of [this.eye, this.imagined]) {
      frame.matrixAutoUpdate = false;
      this.layers.field.add(frame);
    }
    this.imagined.visible = false;
    this.layers.ellipsoids.visible = false;
    new ResizeObserver(() => this.resize()).observe(place);
    this.paint();
    this.look("behind");
  }

  show(layer: Layer, on: boolean): void {
    this.layers[layer].visible = on;
    if (layer === "ellipsoids" && on) this.ellipsoids();
    this.draw();
  }
  shows(layer: Layer): boolean {
    return this.layers[layer].visible;
  }

  /** In the colours of light or dark. */
  paint(): void {
    this.scene.background = colour("--scene");
    this.grid?.removeFromParent();
    this.grid = new THREE.GridHelper(20, 20, colour("--line-strong"), colour("--line"));
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.z = -0.005;
    this.scene.add(this.grid);
    this.draw();
  }

  stand(x: number, y: number, yaw: number, pan: number, tilt: number): void {
    const moved = Math.hypot(x - this.base.x, y - this.base.y);
    this.controls.target.add(new THREE.Vector3(x - this.base.x, y - this.base.y, 0));
    if (moved > 0) this.camera.position.add(new THREE.Vector3(x - this.base.x, y - this.base.y, 0));
    this.base = { x, y, yaw };
    this.figure.stand(x, y, yaw);
    this.figure.look(pan, tilt);
    this.draw();
  }

  look(from: View): void {
    const { x, y, yaw } = this.base;
    const ahead = new THREE.Vector3(Math.cos(yaw), Math.sin(yaw), 0);
    const here = new THREE.Vector3(x, y, 0.8);
    if (from === "top") this.camera.position.copy(here).add(new THREE.Vector3(-0.01, 0, 7));
    if (from === "behind") this.camera.position.copy(here).addScaledVector(ahead, -3.6).add(new THREE.Vector3(0, 0, 2.1));
    if (from === "eye") this.camera.position.copy(here).addScaledVector(ahead, 0.15).setZ(1.5);
    this.controls.target.copy(here).addScaledVector(ahead, from === "top" ? 0.6 : from === "eye" ? 2 : 0.6);
    this.controls.update();
    this.draw();
  }

  takeTransforms(tf: Transforms): void {
    for (const { child_frame_id: frame, transform } of tf.transforms) {
      const q = transform.rotation;
      const t = transform.translation;
      const matrix = new THREE.Matrix4().compose(new THREE.Vector3(t.x, t.y, t.z),
        new THREE.Quaternion(q.x, q.y, q.z, q.w), new THREE.Vector3(1, 1, 1));
      if (frame === "camera_left") this.eye.matrix.copy(matrix);
      if (frame === "chest") this.chest.copy(matrix);
    }
    this.eye.matrixWorldNeedsUpdate = true;
    this.draw();
  }

  /** Where the left camera would be with the head so, turned about the neck as it is now. */
  imagine(pan: number, tilt: number, nowPan: number, nowTilt: number, on: boolean): void {
    this.imagined.visible = on;
    const neck = new THREE.Matrix4().makeTranslation(this.base.x, this.base.y, 1.36);
    const turn = (p: number, t: number): THREE.Matrix4 => new THREE.Matrix4()
      .makeRotationZ(this.base.yaw + p).multiply(new THREE.Matrix4().makeRotationY(t));
    const back = neck.clone().multiply(turn(nowPan, nowTilt)).invert();
    this.imagined.matrix.copy(neck.multiply(turn(pan, tilt)).multiply(back).multiply(this.eye.matrix));
    this.imagined.matrixWorldNeedsUpdate = true;
    this.draw();
  }

  takeCloud(cloud: Cloud): void {
    this.lastCloud = cloud;
    const view = new DataView(cloud.data.buffer, cloud.data.byteOffset, cloud.data.byteLength);
    const positions = new Float32Array(3 * cloud.width);
    const colours = new Float32Array(3 * cloud.width);
    for (let i = 0; i < cloud.width; ++i) {
      const at = i * cloud.point_step;
      for (const axis of [0, 1, 2]) positions[3 * i + axis] = view.getFloat32(at + 4 * axis, true);
      colours.set(viridis(precision(view.getFloat32(at + 16, true))), 3 * i);
    }
    const geometry = this.cloud.geometry;
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
    geometry.boundingSphere = null;
    if (this.shows("ellipsoids")) this.ellipsoids();
    this.draw();
  }

  /** Of a sample of the points: along the ray as uncertain as it is, across it as a pixel is wide. */
  private ellipsoids(): void {
    const cloud = this.lastCloud;
    const group = this.layers.ellipsoids;
    group.clear();
    if (!cloud || cloud.width === 0) return;
    const view = new DataView(cloud.data.buffer, cloud.data.byteOffset, cloud.data.byteLength);
    const every = Math.max(1, Math.floor(cloud.width / kEllipsoids));
    const count = Math.floor(cloud.width / every);
    const mesh = new THREE.InstancedMesh(new THREE.SphereGeometry(1, 10, 7),
      new THREE.MeshLambertMaterial({ transparent: true, opacity: 0.75 }), count);
    const eye = new THREE.Vector3().setFromMatrixPosition(this.eye.matrix);
    for (let i = 0; i < count; ++i) {
      const at = i * every * cloud.point_step;
      const point = new THREE.Vector3(view.getFloat32(at, true), view.getFloat32(at + 4, true), view.getFloat32(at + 8, true));
      const sigma = view.getFloat32(at + 16, true);
      const ray = point.clone().sub(eye);
      const across = ray.length() / 1200;
      const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(1, 0, 0), ray.normalize());
      mesh.setMatrixAt(i, new THREE.Matrix4().compose(point, turn,
        new THREE.Vector3(kMagnified * sigma, Math.max(kMagnified * across, 0.004), Math.max(kMagnified * across, 0.004))));
      mesh.setColorAt(i, new THREE.Color(...viridis(precision(sigma))));
    }
    group.add(mesh);
  }

  takeFields(fields: Markers): string[] {
    this.fields = fields.markers;
    this.showField(this.resolution);
    return this.fields.map((field) => field.ns);
  }
  showField(name: string): void {
    this.resolution = name;
    const field = this.fields.find((one) => one.ns === name);
    for (const [frame, tone] of [[this.eye, "--field"], [this.imagined, "--imagined"]] as const) {
      frame.clear();
      if (!field) continue;
      const geometry = new THREE.BufferGeometry().setFromPoints(field.points.map((p) => new THREE.Vector3(p.x, p.y, p.z)));
      frame.add(new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({
        color: colour(tone), transparent: true, opacity: 0.13, depthWrite: false, side: THREE.DoubleSide })));
      frame.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 8), new THREE.LineBasicMaterial({ color: colour(tone) })));
    }
    this.draw();
  }

  takeFeet(feet: Markers, way: Path | undefined, shown: Path | undefined): void {
    const group = this.layers.feet;
    group.clear();
    for (const foot of feet.markers) {
      if (foot.action !== 0) continue;
      const committed = foot.ns === "committed";
      const plate = new THREE.Mesh(new THREE.BoxGeometry(foot.scale.x, foot.scale.y, 0.012), new THREE.MeshBasicMaterial({
        color: new THREE.Color(foot.color.r, foot.color.g, foot.color.b).convertLinearToSRGB(),
        transparent: !committed, opacity: committed ? 1 : 0.45 }));
      plate.position.set(foot.pose.position.x, foot.pose.position.y, 0.012);
      const q = foot.pose.orientation;
      plate.quaternion.set(q.x, q.y, q.z, q.w);
      group.add(plate);
    }
    for (const [path, tone] of [[way, "--way"], [shown, "--shown"]] as const)
      if (path && path.poses.length > 1)
        group.add(new THREE.Line(
          new THREE.BufferGeometry().setFromPoints(path.poses.map(({ pose }) => new THREE.Vector3(pose.position.x, pose.position.y, 0.03))),
          new THREE.LineBasicMaterial({ color: colour(tone) })));
    this.draw();
  }

  /** Soon. Where a picture takes long there is thrice as long until the next, for all else that the page does. */
  draw(): void {
    if (this.asked) return;
    this.asked = true;
    window.setTimeout(() => requestAnimationFrame(() => this.drawNow()), this.took > kSlow ? 3 * this.took : 0);
  }
  private drawNow(): void {
    this.asked = false;
    const begun = performance.now();
    const more = this.voxels.work();
    this.renderer.render(this.scene, this.camera);
    if (kSoftware) this.renderer.getContext().finish();
    this.took = performance.now() - begun;
    if (more) this.draw();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }
}
