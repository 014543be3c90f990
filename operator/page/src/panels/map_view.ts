// Which part of the floor the map shows, and where. Screen in CSS pixels, y down; floor in metres, y up.

export type Spot = { x: number; y: number };

export class MapView {
  x = 0;
  y = 0;
  /** Pixels per metre. */
  scale = 60;
  width = 1;
  height = 1;

  toScreen({ x, y }: Spot): Spot {
    return { x: this.width / 2 + (x - this.x) * this.scale, y: this.height / 2 - (y - this.y) * this.scale };
  }

  toFloor({ x, y }: Spot): Spot {
    return { x: this.x + (x - this.width / 2) / this.scale, y: this.y - (y - this.height / 2) / this.scale };
  }

  shift(dx: number, dy: number): void {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
  }

  /** What lies under `at` stays there. */
  zoom(factor: number, at: Spot = { x: this.width / 2, y: this.height / 2 }): void {
    const before = this.toFloor(at);
    this.scale = Math.min(600, Math.max(8, this.scale * factor));
    const after = this.toFloor(at);
    this.x += before.x - after.x;
    this.y += before.y - after.y;
  }

  fit(x: number, y: number, width: number, height: number): void {
    this.x = x + width / 2;
    this.y = y + height / 2;
    this.scale = 0.97 * Math.min(this.width / width, this.height / height);
  }
}
