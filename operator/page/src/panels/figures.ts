// How the loops keep up: time of each stage, age of the frame, and counts.
import uPlot from "uplot";
import { css } from "../scene/colours";
import type { Status } from "../wire/messages";
import type { Robot } from "../wire/robot";
import { byId, make } from "./dom";
import { tell } from "./go";

const kWindow = 60; // [s]
const kEvery = 100; // between two samples [ms]

export function figures(robot: Robot): void {
  const place = byId("plots");
  const rows: number[][] = [[], [], [], [], [], []];
  let plot: uPlot | undefined;
  let last = 0;

  const build = (): void => {
    plot?.destroy();
    const axis = { stroke: css("--muted"), grid: { stroke: css("--line"), width: 1 }, ticks: { stroke: css("--line"), width: 1 } };
    const series = [["see", "--c1"], ["map", "--c2"], ["floor", "--c3"], ["plan", "--c4"], ["frame age", "--c5"]] as const;
    plot = new uPlot({
      width: Math.max(place.clientWidth, 200), height: 170,
      scales: { x: { time: false }, y: { range: (_u, _low, high) => [0, Math.max(40, high)] } },
      axes: [{ ...axis, values: (_u, ticks) => ticks.map((t) => `${t} s`) }, { ...axis, size: 58, values: (_u, ticks) => ticks.map((t) => `${t} ms`) }],
      series: [{}, ...series.map(([label, tone]) => ({ label, stroke: css(tone), width: 1.5, points: { show: false } }))],
      legend: { live: false },
      cursor: { show: false },
    }, rows as unknown as uPlot.AlignedData, place);
  };

  robot.on("/headway/status", (now) => {
    const t = performance.now();
    if (t - last < kEvery) return;
    last = t;
    [t / 1000, now.see_ms, now.map_ms, now.floor_ms, now.plan_ms, now.frame_age_ms].forEach((value, i) => rows[i]!.push(value));
    while (rows[0]!.length > 0 && rows[0]![0]! < t / 1000 - kWindow) for (const row of rows) row.shift();
    const newest = t / 1000;
    plot?.setData([rows[0]!.map((s) => s - newest), ...rows.slice(1)] as unknown as uPlot.AlignedData);
    facts(now);
  });
  byId("record").addEventListener("click", async () => tell(await robot.ask("record", { on: !(robot.status()?.recording ?? false) })));
  byId("reset").addEventListener("click", async () => tell(await robot.ask("reset")));
  new ResizeObserver(() => plot?.setSize({ width: Math.max(place.clientWidth, 200), height: 170 })).observe(place);
  window.addEventListener("theme", build);
  build();
}

function facts(now: Status): void {
  const rows: [string, string][] = [
    ["frames", `${now.frames} used, ${now.frames_lost} lost, ${now.frames_no_pose} without pose, ${now.frames_late} late`],
    ["effort", now.frame_level],
    ["bus loop", now.bus_cycles ? `${now.bus_missed} of ${now.bus_cycles} missed; ${now.bus_wake_max_us.toFixed(0)} µs late at most` : "-"],
    ["plans", `${now.plans}, of which ${now.replans} changed steps`],
    ["control computer", now.control_computer],
    ["viewers", `${now.clients}${now.recording ? "; recording" : ""}`],
  ];
  byId("facts").replaceChildren(...rows.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]));
}
