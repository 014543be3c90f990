// The operator's page: the robot, and a panel for each thing that is shown or asked.
import { bar } from "./panels/bar";
import { camera } from "./panels/camera";
import { figures } from "./panels/figures";
import { Go } from "./panels/go";
import { head } from "./panels/head";
import { keys } from "./panels/keys";
import { layers } from "./panels/layers";
import { map } from "./panels/map";
import { player } from "./panels/player";
import { byId } from "./panels/dom";
import { Scene } from "./scene/scene";
import { Robot } from "./wire/robot";

/** The token comes behind the address's #, which is never sent, and is traded for a cookie. */
async function logIn(): Promise<void> {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!token) return;
  history.replaceState(null, "", location.pathname);
  await fetch("/login", { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ token }) });
}

const robot = new Robot();
const scene = new Scene(byId("scene"));
const go = new Go(robot);
bar(robot);
camera(robot);
head(robot, scene);
layers(robot, scene);
const floor = map(robot, go);
figures(robot);
player(robot);
keys();

robot.on("/headway/status", (now) => scene.stand(now.x, now.y, now.yaw, now.pan, now.tilt));
robot.on("/tf", (tf) => scene.takeTransforms(tf));
robot.on("/points", (cloud) => scene.takeCloud(cloud));
robot.on("/voxels", (voxels) => { scene.voxels.take(voxels); scene.draw(); });
const feet = (): void => {
  const marks = robot.get("/footsteps");
  if (marks) scene.takeFeet(marks, robot.get("/plan"), robot.get("/preview"));
};
for (const topic of ["/footsteps", "/plan", "/preview"] as const) robot.on(topic, feet);
window.addEventListener("theme", () => { scene.paint(); scene.showField(scene.resolution); });

// What the page shows, for those who test it.
Object.assign(window, { headway: { robot, scene, map: floor } });
await logIn();
robot.start();
