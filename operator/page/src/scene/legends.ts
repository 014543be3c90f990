// What the colours of the 3D view mean.
import { byId, el } from "../ui/dom";
import { type ScaleName, kHeightHigh, kHeightLow, kSigmaHigh, kSigmaLow, scales } from "./colours";

function paint(canvas: HTMLCanvasElement, name: ScaleName): void {
  canvas.width = 180;
  canvas.height = 8;
  const context = canvas.getContext("2d");
  if (!context) return;
  const gradient = context.createLinearGradient(0, 0, canvas.width, 0);
  scales[name].forEach((step, i) => gradient.addColorStop(i / (scales[name].length - 1), step));
  context.fillStyle = gradient;
  context.fillRect(0, 0, canvas.width, canvas.height);
}

function ticks(id: string, marks: [number, string][]): void {
  byId(id).replaceChildren(
    ...marks.map(([at, text]) => {
      const tick = el("span", {}, text);
      tick.style.left = `${(100 * at).toFixed(1)}%`;
      return tick;
    }),
  );
}

export function showLegends(): void {
  paint(byId("sigma-scale"), "viridis");
  paint(byId("height-scale"), "cividis");
  const log = (mm: number) => Math.log(mm / 1000 / kSigmaLow) / Math.log(kSigmaHigh / kSigmaLow);
  ticks("sigma-ticks", [2, 5, 10, 20, 100].map((mm) => [log(mm), mm === 100 ? "100 mm" : String(mm)]));
  ticks("height-ticks", [0, 0.5, 1, 1.5, 2].map((m) => [(m - kHeightLow) / (kHeightHigh - kHeightLow), m === 2 ? "2 m" : String(m)]));
}
