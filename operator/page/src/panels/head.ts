// Where the head looks: a pad as wide as the neck turns, viewpoints, and what it would see from there.
import type { Scene } from "../scene/scene";
import type { Robot } from "../wire/robot";
import { byId, degrees, make, say } from "./dom";
import { tell } from "./go";

const kStep = 0.05; // of an arrow key [rad]

export function head(robot: Robot, scene: Scene): void {
  const pad = byId("head-pad");
  const whatIf = byId<HTMLInputElement>("what-if");
  const dot = pad.appendChild(make("span", { class: "dot now" }));
  const wish = pad.appendChild(make("span", { class: "dot wish" }));
  const wished = { pan: 0, tilt: 0.4 };
  wish.hidden = true;

  const place = (element: HTMLElement, pan: number, tilt: number): void => {
    const s = robot.status();
    if (!s) return;
    element.style.left = `${(100 * (s.pan_high - pan)) / (s.pan_high - s.pan_low)}%`;
    element.style.top = `${(100 * (tilt - s.tilt_low)) / (s.tilt_high - s.tilt_low)}%`;
  };
  const imagine = (): void => {
    const s = robot.status();
    if (s) scene.imagine(wished.pan, wished.tilt, s.pan, s.tilt, whatIf.checked && !wish.hidden);
  };
  const choose = (pan: number, tilt: number): void => {
    const s = robot.status();
    if (!s) return;
    wished.pan = Math.min(Math.max(pan, s.pan_low), s.pan_high);
    wished.tilt = Math.min(Math.max(tilt, s.tilt_low), s.tilt_high);
    wish.hidden = false;
    place(wish, wished.pan, wished.tilt);
    imagine();
  };
  const order = async (): Promise<void> => {
    if (whatIf.checked) return; // only imagined
    tell(await robot.ask("look", wished));
  };

  const point = (event: PointerEvent): void => {
    const s = robot.status();
    if (!s) return;
    const area = pad.getBoundingClientRect();
    choose(s.pan_high - ((event.clientX - area.left) / area.width) * (s.pan_high - s.pan_low),
      s.tilt_low + ((event.clientY - area.top) / area.height) * (s.tilt_high - s.tilt_low));
  };
  pad.addEventListener("pointerdown", (event) => { pad.setPointerCapture(event.pointerId); point(event); });
  pad.addEventListener("pointermove", (event) => { if (pad.hasPointerCapture(event.pointerId)) point(event); });
  pad.addEventListener("pointerup", () => void order());
  pad.addEventListener("keydown", (event) => {
    const move = { ArrowLeft: [kStep, 0], ArrowRight: [-kStep, 0], ArrowUp: [0, -kStep], ArrowDown: [0, kStep] }[event.key];
    if (move) choose(wished.pan + move[0]!, wished.tilt + move[1]!);
    else if (event.key === "Enter") void order();
    else return;
    event.preventDefault();
  });
  whatIf.addEventListener("change", imagine);

  const nine = byId("viewpoints");
  for (const [row, tilt] of [["up", 0], ["ahead", 0.35], ["down", 0.75]] as const)
    for (const [side, pan] of [["left", 0.6], ["middle", 0], ["right", -0.6]] as const)
      nine.append(make("button", { type: "button", "data-control": true, "aria-label": `${row} ${side}`,
        click: () => { choose(pan, tilt); void order(); } }, "•"));
  byId("look-around").addEventListener("click", async () => tell(await robot.ask("look_around")));

  robot.on("/headway/status", (s) => {
    place(dot, s.pan, s.tilt);
    say(byId("head-now"), `pan ${degrees(s.pan)}, tilt ${degrees(s.tilt)}; ${s.head}`);
    imagine();
  });
}
