// The bar: how the robot is, what it does next, the link, and the stop.
import type { Robot } from "../wire/robot";
import type { Topic } from "../wire/messages";
import { byId, say } from "./dom";

const kStale = 1000; // [ms]

function age(ms: number): string {
  if (ms === Infinity) return "nothing yet";
  return ms < 1000 ? `${(ms / 1000).toFixed(1)} s` : `${Math.round(ms / 1000)} s ago`;
}

export function bar(robot: Robot): void {
  const stop = (): void => void robot.ask("stop");
  byId("stop").addEventListener("click", stop);
  // Ahead of every input: Esc and Space stop, wherever the focus is.
  window.addEventListener("keydown", (event) => {
    const writes = event.target instanceof HTMLInputElement && event.target.type === "text";
    if (event.key !== "Escape" && (event.key !== " " || writes)) return;
    stop();
    if (event.key === " ") event.preventDefault();
    byId("stop").classList.add("pressed");
    setTimeout(() => byId("stop").classList.remove("pressed"), 400);
  }, { capture: true });

  robot.on("/headway/status", (now) => {
    say(byId("state"), now.recording_name ? "recording" : now.paused ? "paused" : now.state);
    byId("state").dataset.state = now.state;
    say(byId("safety"), now.safety);
    byId("safety").dataset.state = now.safety;
    byId("safety").title = now.safety_reason;
    const reason = now.reason ? ` (${now.reason})` : "";
    say(byId("next"), `Next: ${now.next}${reason}`);
    say(byId("robot"), robot.name + (now.simulated && !now.recording_name ? `, simulated ×${now.speed.toFixed(2)}` : ""));
    document.title = `${now.state} · Headway`;
  });

  setInterval(() => {
    say(byId("link"), robot.connected
      ? `${robot.roundTrip.toFixed(0)} ms · ${robot.dropped} left out · ${age(robot.age("/headway/status"))}` : "no link");
    const banner = byId("banner");
    const dead = !robot.connected || robot.age("/headway/status") > kStale;
    banner.hidden = !dead;
    if (dead)
      say(banner, robot.role === "none" && !robot.connected ? "Not connected. Open the page with the address that the robot printed."
        : "The link is lost: what you see is old. The robot comes to rest by itself, and goes on only when told anew.");
    document.body.classList.toggle("dead", dead);
    for (const element of document.querySelectorAll<HTMLElement>("[data-age]"))
      say(element, (element.dataset.ageSays ? "changed " : "") + age(robot.age(element.dataset.age as Topic)));
    for (const element of document.querySelectorAll<HTMLElement>("[data-stale]"))
      element.classList.toggle("stale", dead || robot.age(element.dataset.stale as Topic) > 3 * kStale);
  }, 200);
  setInterval(() => { if (robot.connected && !robot.inControl) void robot.ask("ping"); }, 1000);

  const theme = byId("theme");
  theme.addEventListener("click", () => {
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    const is = document.documentElement.dataset.theme ?? (dark ? "dark" : "light");
    document.documentElement.dataset.theme = is === "dark" ? "light" : "dark";
    window.dispatchEvent(new Event("theme"));
  });
}
