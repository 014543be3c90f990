// The floor map as a picture: what is free, blocked and not seen yet. Both views draw it.
import { theme, themeColor } from "../ui/theme";
import type { OccupancyGrid } from "../wire/messages";

export class FloorImage {
  readonly canvas = document.createElement("canvas");
  /** [m]; lower left corner, and edge of a cell. */
  x = 0;
  y = 0;
  cell = 0.05;
  private newest: OccupancyGrid | null = null;

  constructor(private readonly changed: () => void) {
    theme.watch(() => this.paint());
  }

  get known(): boolean {
    return this.newest !== null;
  }

  get width(): number {
    return this.canvas.width * this.cell;
  }

  get height(): number {
    return this.canvas.height * this.cell;
  }

  take(message: OccupancyGrid): void {
    this.newest = message;
    this.x = message.info.origin.position.x;
    this.y = message.info.origin.position.y;
    this.cell = message.info.resolution;
    this.paint();
  }

  /** Undefined outside. */
  at(x: number, y: number): "free" | "blocked" | "unseen" | undefined {
    if (!this.newest) return undefined;
    const { width, height } = this.newest.info;
    const [i, j] = [Math.floor((x - this.x) / this.cell), Math.floor((y - this.y) / this.cell)];
    if (i < 0 || j < 0 || i >= width || j >= height) return undefined;
    const value = this.newest.data[j * width + i] ?? -1;
    return value < 0 ? "unseen" : value >= 50 ? "blocked" : "free";
  }

  private paint(): void {
    if (!this.newest) return;
    const { width, height } = this.newest.info;
    if (!width || !height) return;
    this.canvas.width = width;
    this.canvas.height = height;
    const context = this.canvas.getContext("2d");
    if (!context) return;
    const image = context.createImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    const [free, blocked, unseen] = [packed("map-free"), packed("map-blocked"), packed("map-unseen")];
    this.newest.data.forEach((value, n) => {
      const row = height - 1 - Math.floor(n / width); // pictures begin at the top
      pixels[row * width + (n % width)] = value < 0 ? unseen : value >= 50 ? blocked : free;
    });
    context.putImageData(image, 0, 0);
    this.changed();
  }
}

/** "#rrggbb" as a pixel of a little-endian machine. */
function packed(name: string): number {
  const rgb = parseInt(themeColor(name).slice(1), 16);
  return (0xff000000 | ((rgb & 255) << 16) | (rgb & 0xff00) | (rgb >> 16)) >>> 0;
}
