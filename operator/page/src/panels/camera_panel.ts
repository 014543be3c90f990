// What the left camera sees.
import type { App } from "../state/app";
import { byId } from "../ui/dom";
import type { CompressedImage } from "../wire/messages";

export class CameraPanel {
  private readonly canvas = byId<HTMLCanvasElement>("camera-canvas");
  private decoding = false;
  private next: CompressedImage | null = null;

  constructor(app: App) {
    app.link.on("picture", (message) => {
      this.next = message;
      if (!this.decoding) void this.show();
    });
  }

  /** The newest picture; those that came while one was being decoded are left out. */
  private async show(): Promise<void> {
    this.decoding = true;
    while (this.next) {
      const { data, format } = this.next;
      this.next = null;
      await this.paint(new Blob([data as Uint8Array<ArrayBuffer>], { type: `image/${format.includes("png") ? "png" : "jpeg"}` }));
    }
    this.decoding = false;
  }

  private async paint(blob: Blob): Promise<void> {
    try {
      const picture = await createImageBitmap(blob);
      this.canvas.width = picture.width;
      this.canvas.height = picture.height;
      this.canvas.getContext("2d")?.drawImage(picture, 0, 0);
      picture.close();
      byId("camera-missing").hidden = true;
    } catch {
      byId("camera-missing").textContent = "This picture cannot be read.";
      byId("camera-missing").hidden = false;
    }
  }
}
