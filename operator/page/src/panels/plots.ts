// Times over the last minute: of the stages, of frames, of the bus, of the link.
import uPlot from "uplot";
import type { App } from "../state/app";
import type { OperatorStatus } from "../wire/messages";
import { byId, setText } from "../ui/dom";
import { theme, themeColor } from "../ui/theme";
import { milliseconds } from "../ui/words";

const kSeconds = 60;
const kDrawMs = 500;

type Line = { label: string; color: string; dash?: number[] };

class Plot {
  private plot: uPlot | null = null;
  private readonly times: number[] = [];
  private readonly values: (number | null)[][];

  constructor(private readonly place: HTMLElement, private readonly lines: readonly Line[]) {
    this.values = lines.map(() => []);
    theme.watch(() => this.make());
    new ResizeObserver(() => this.resize()).observe(place);
  }

  add(time: number, values: (number | null)[]): void {
    this.times.push(time);
    values.forEach((value, i) => this.values[i]?.push(value));
    const old = this.times.findIndex((t) => t > time - kSeconds);
    this.times.splice(0, old);
    for (const list of this.values) list.splice(0, old);
  }

  draw(): void {
    const last = this.times[this.times.length - 1];
    if (!this.plot || last === undefined || this.place.clientWidth === 0) return;
    const data = [this.times.map((t) => t - last), ...this.values] as uPlot.AlignedData;
    this.plot.setData(data);
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (width === 0 || height === 0) return;
    if (this.plot) this.plot.setSize({ width, height });
    else this.make();
  }

  private make(): void {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (width === 0 || height === 0) return;
    this.plot?.destroy();
    this.plot = new uPlot(this.options(width, height), [[], ...this.lines.map(() => [])] as uPlot.AlignedData, this.place);
    this.draw();
  }

  private options(width: number, height: number): uPlot.Options {
    const axis = { stroke: themeColor("muted"), font: "11px system-ui, sans-serif", grid: { stroke: themeColor("line"), width: 1 }, ticks: { show: false } };
    return {
      width, height, padding: [6, 14, 0, 0],
      cursor: { show: false },
      legend: { show: false },
      scales: { x: { time: false, range: [-kSeconds, 0] }, y: { range: (_, __, max) => [0, niceTop(max)] } },
      axes: [
        { ...axis, size: 20, gap: 2, values: (_, splits) => splits.map((s) => (s === 0 ? "now" : `${s} s`)), splits: [-60, -40, -20, 0] },
        { ...axis, size: 34, gap: 4 },
      ],
      series: [{}, ...this.lines.map(({ label, color, dash }) => ({ label, stroke: themeColor(color), width: 1.5, points: { show: false }, ...(dash ? { dash } : {}) }))],
    };
  }
}

function niceTop(max: number | null): number {
  const most = Math.max(1, max ?? 1);
  const unit = 10 ** Math.floor(Math.log10(most));
  return ([1, 2, 5, 10].find((step) => step * unit >= most) ?? 10) * unit;
}

export class Plots {
  private readonly stages = new Plot(byId("plot-stages"), [
    { label: "see", color: "line-1" }, { label: "map", color: "line-2" }, { label: "floor", color: "line-3", dash: [6, 3] }, { label: "plan", color: "line-4", dash: [2, 3] },
  ]);
  private readonly frames = new Plot(byId("plot-frames"), [{ label: "age", color: "line-1" }]);
  private readonly bus = new Plot(byId("plot-bus"), [{ label: "latest wake-up", color: "line-1" }, { label: "missed", color: "line-4" }]);
  private readonly link = new Plot(byId("plot-link"), [{ label: "round trip", color: "line-1" }]);
  private missedBefore: number | null = null;

  constructor(private readonly app: App) {
    app.link.on("status", (status) => this.take(status));
    setInterval(() => this.draw(), kDrawMs);
  }

  private take(status: OperatorStatus): void {
    const time = performance.now() / 1000;
    const missed = this.missedBefore === null ? 0 : Math.max(0, status.bus_missed - this.missedBefore);
    this.missedBefore = status.bus_missed;
    const { roundTripMs } = this.app.link.quality;
    this.stages.add(time, [status.see_ms, status.map_ms, status.floor_ms, status.plan_ms]);
    this.frames.add(time, [status.frame_age_ms < 0 ? null : status.frame_age_ms]);
    this.bus.add(time, [status.bus_wake_max_us, missed]);
    this.link.add(time, [Number.isFinite(roundTripMs) ? roundTripMs : null]);
  }

  private draw(): void {
    const { status, quality } = this.app.link;
    if (!status || document.hidden) return;
    for (const plot of [this.stages, this.frames, this.bus, this.link]) plot.draw();
    const load = status.bus_load > 0 ? ` · ${(100 * status.bus_load).toFixed(0)} %` : "";
    setText(byId("stages-now"), `${status.see_ms.toFixed(0)} · ${status.map_ms.toFixed(0)} · ${status.floor_ms.toFixed(0)} · ${status.plan_ms.toFixed(0)} ms`);
    setText(byId("frames-now"), status.frame_age_ms < 0 ? "–" : milliseconds(status.frame_age_ms));
    setText(byId("bus-now"), `${status.bus_wake_max_us.toFixed(0)} µs · ${status.bus_missed} missed${load}`);
    const trip = Number.isFinite(quality.roundTripMs) ? milliseconds(quality.roundTripMs) : "–";
    setText(byId("link-now"), `${trip} · ${(100 * quality.dropped).toFixed(0)} % lost · ${(quality.bytesPerSecond / 1000).toFixed(0)} kB/s`);
  }
}
