// The time line of a recording that is played.
import type { Robot } from "../wire/robot";
import { byId, make, say } from "./dom";
import { tell } from "./go";

export function player(robot: Robot): void {
  const place = byId("player");
  const play = make("button", { type: "button", id: "play" }, "Pause");
  const line = make("input", { type: "range", id: "time", min: "0", max: "1", step: "0.1", "aria-label": "Time" });
  const speed = make("select", { id: "speed", "aria-label": "Speed" },
    ...["0.25", "0.5", "1", "2", "5"].map((x) => make("option", { value: x }, `×${x}`)));
  const clock = make("span", { class: "muted" });
  speed.value = "1";
  place.append(play, line, clock, speed);
  let dragged = false;
  line.addEventListener("input", () => { dragged = true; });
  line.addEventListener("change", async () => { dragged = false; tell(await robot.ask("play", { at: Number(line.value) })); });
  play.addEventListener("click", async () => tell(await robot.ask("play", { play: robot.status()?.played_paused ?? false })));
  speed.addEventListener("change", async () => tell(await robot.ask("play", { speed: Number(speed.value) })));
  robot.on("/headway/status", (now) => {
    place.hidden = !now.recording_name;
    document.body.classList.toggle("played", !place.hidden);
    if (place.hidden) return;
    line.min = String(now.played_from);
    line.max = String(now.played_to);
    if (!dragged) line.value = String(now.played_at);
    say(play, now.played_paused ? "Play" : "Pause");
    say(clock, `${(now.played_at - now.played_from).toFixed(1)} of ${(now.played_to - now.played_from).toFixed(1)} s of ${now.recording_name}`);
  });
}
