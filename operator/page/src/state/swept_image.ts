// The floor that the body sweeps along a way, as a picture. Both views draw it.
import type { OccupancyGrid } from "../wire/messages";

/** Light blue, half transparent: as the pictures of `headway plan` have it. */
export const kBodyColor = "#3ca0c8";
const kPixel = 0x80c8a03c; // of a little-endian machine

export class SweptImage {
  readonly canvas = document.createElement("canvas");
  /** [m]; lower left corner, and edge of a cell. */
  x = 0;
  y = 0;
  cell = 0.05;
  /** [m²] */
  area = 0;

  get width(): number {
    return this.canvas.width * this.cell;
  }

  get height(): number {
    return this.canvas.height * this.cell;
  }

  take({ info, data }: OccupancyGrid): void {
    const { width, height, resolution, origin } = info;
    this.x = origin.position.x;
    this.y = origin.position.y;
    this.cell = resolution;
    const image = new ImageData(Math.max(1, width), Math.max(1, height));
    const pixels = new Uint32Array(image.data.buffer);
    let cells = 0;
    data.forEach((value, n) => {
      if (value <= 0) return;
      const row = height - 1 - Math.floor(n / width); // pictures begin at the top
      pixels[row * width + (n % width)] = kPixel;
      ++cells;
    });
    this.area = cells * resolution * resolution;
    this.canvas.width = image.width;
    this.canvas.height = image.height;
    this.canvas.getContext("2d")?.putImageData(image, 0, 0);
  }
}
