// The page: puts its parts together. STOP comes first and needs nothing of the rest.
import { App } from "./state/app";
import { FloorImage } from "./state/floor_image";
import { CameraPanel } from "./panels/camera_panel";
import { CommandBar } from "./panels/command_bar";
import { Facts } from "./panels/facts";
import { Freshness } from "./panels/freshness";
import { HeadPanel } from "./panels/head_panel";
import { Keys } from "./panels/keys";
import { startLogin } from "./panels/login";
import { MapPanel } from "./panels/map_panel";
import { Player } from "./panels/player";
import { Plots } from "./panels/plots";
import { ScenePanel } from "./panels/scene_panel";
import { startTabs } from "./panels/tabs";
import { TopBar } from "./panels/top_bar";
import { Viewers } from "./panels/viewers";
import { byId } from "./ui/dom";
import { beforeNextFrame } from "./ui/frame";
import { startTheme } from "./ui/theme";

declare global {
  interface Window {
    /** What tests ask the page about itself. */
    headway?: { scene: ScenePanel | null; map: MapPanel; app: App };
  }
}

function sceneOf(app: App, floor: FloorImage): ScenePanel | null {
  try {
    return new ScenePanel(app, floor);
  } catch {
    // Without WebGL all the rest is to work, STOP above all.
    byId("scene-missing").hidden = false;
    return null;
  }
}

startTheme();
const app = new App();
const bar = new CommandBar(app);
let scene: ScenePanel | null = null;
const head = new HeadPanel(app);
new Keys(app, {
  stop: () => bar.stop(),
  near: () => bar.goNear(),
  preset: (preset) => scene?.choosePreset(preset),
  viewpoint: (n) => head.viewpoint(n),
});
new TopBar(app);
new Freshness(app);
startLogin(app);
startTabs();
const floor = new FloorImage(() => {
  map.draw();
  scene?.floorChanged();
});
const map = new MapPanel(app, floor);
app.link.on("map", (message) => floor.take(message));
new CameraPanel(app);
new Facts(app);
new Plots(app);
new Player(app);
new Viewers(app);
window.headway = { scene, map, app };
// The rest is on the screen, and STOP answers, before the 3D view takes its time.
beforeNextFrame(() =>
  setTimeout(() => {
    scene = sceneOf(app, floor);
    window.headway = { scene, map, app };
    void app.link.start();
  }),
);
