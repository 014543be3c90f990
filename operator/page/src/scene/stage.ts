// Canvas, camera and light of the 3D view. It draws when something has changed, and not otherwise.
import {
  AmbientLight, Color, DirectionalLight, GridHelper, HemisphereLight, type Object3D, PerspectiveCamera, Scene, Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { fitCanvas } from "../ui/dom";
import { beforeNextFrame } from "../ui/frame";
import { theme, themeColor } from "../ui/theme";
import { Pace } from "./pace";

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(45, 1, 0.05, 200);
  readonly controls: OrbitControls;
  /** How long the newest pictures took to draw [ms], and how many there were. */
  drawMs = 0;
  drawn = 0;
  private readonly renderer: WebGLRenderer;
  private readonly before: (() => void)[] = [];
  private grid: GridHelper | null = null;
  /** What a picture's preparation changes is in it already. */
  private painting = false;
  private readonly dataMs: number;
  private readonly ratio: number;
  private dataTimer: ReturnType<typeof setTimeout> | null = null;
  private readonly pace: Pace;

  constructor(readonly canvas: HTMLCanvasElement) {
    const software = drawsInSoftware();
    this.renderer = new WebGLRenderer({ canvas, antialias: !software });
    this.dataMs = software ? 350 : 40;
    this.ratio = software ? 1 : 2;
    this.pace = new Pace(this.renderer.getContext() as WebGL2RenderingContext);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(-3.2, -3.4, 3.0);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.target.set(0.4, 0, 0.5);
    this.controls.maxDistance = 60;
    this.controls.minDistance = 0.3;
    this.controls.addEventListener("change", () => this.draw());
    this.controls.update();
    this.light();
    theme.watch(() => this.paper());
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  add(...objects: Object3D[]): void {
    this.scene.add(...objects);
    this.draw();
  }

  /** Called before each picture. */
  beforeDraw(task: () => void): void {
    this.before.push(task);
  }

  /** At once: the operator has moved something. */
  readonly draw = (): void => {
    if (!this.painting) beforeNextFrame(this.paint);
  };

  /** Soon: there is news of the robot. However much there is, hands come first. */
  readonly drawSoon = (): void => {
    this.dataTimer ??= setTimeout(() => {
      this.dataTimer = null;
      this.draw();
    }, Math.max(this.dataMs, 2 * this.pace.lastMs));
  };

  private readonly paint = (): void => {
    if (this.canvas.clientWidth === 0 || this.pace.busy(this.draw)) return;
    if (fitCanvas(this.canvas, this.ratio)) this.resize();
    this.painting = true;
    for (const task of this.before) task();
    this.painting = false;
    const begin = performance.now();
    this.renderer.render(this.scene, this.camera);
    this.drawMs = performance.now() - begin;
    this.drawn++;
    this.pace.begin();
  };

  /** Draws, waits until it is drawn, and tells how long that took [ms]. */
  measure(): number {
    const begin = performance.now();
    this.renderer.render(this.scene, this.camera);
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    return performance.now() - begin;
  }

  private resize(): void {
    const { width, height } = this.canvas;
    this.renderer.setViewport(0, 0, width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  private light(): void {
    const sun = new DirectionalLight("#ffffff", 1.6);
    sun.position.set(-2, -3, 6);
    const sky = new HemisphereLight("#ffffff", "#8a8f98", 1.3);
    sky.position.set(0, 0, 1);
    this.scene.add(sun, sky, new AmbientLight("#ffffff", 0.25));
  }

  private paper(): void {
    this.scene.background = new Color(themeColor("scene"));
    if (this.grid) this.scene.remove(this.grid);
    this.grid = new GridHelper(24, 24, themeColor("grid-axis"), themeColor("grid"));
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.copy(new Vector3(0, 0, -0.012));
    this.scene.add(this.grid);
    this.draw();
  }
}

/** Without a graphics card a picture takes long: fewer are drawn, and plainer ones. */
function drawsInSoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl");
  const names = gl?.getExtension("WEBGL_debug_renderer_info");
  const renderer = gl && names ? String(gl.getParameter(names.UNMASKED_RENDERER_WEBGL)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(renderer);
}
