// No picture is begun before the last is ready. Pictures that queue up would hold up all that the page does, and the
// renewal of control and STOP with it.

const kLookMs = 15;
const kGiveUpMs = 3000;

export class Pace {
  /** How long the last picture took until it was ready [ms]. */
  lastMs = 0;
  private sync: WebGLSync | null = null;
  private begun = 0;
  private waiting: (() => void) | null = null;

  constructor(private readonly gl: WebGL2RenderingContext) {}

  /** True while a picture is being drawn; `then` is called when it is ready. */
  busy(then: () => void): boolean {
    if (!this.sync) return false;
    this.waiting = then;
    return true;
  }

  /** All that makes a picture has been asked for. */
  begin(): void {
    this.sync = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.gl.flush();
    this.begun = performance.now();
    setTimeout(this.look, kLookMs);
  }

  private readonly look = (): void => {
    if (!this.sync) return;
    const took = performance.now() - this.begun;
    const ready = this.gl.getSyncParameter(this.sync, this.gl.SYNC_STATUS) === this.gl.SIGNALED;
    if (!ready && took < kGiveUpMs) {
      setTimeout(this.look, kLookMs);
      return;
    }
    this.lastMs = took;
    this.gl.deleteSync(this.sync);
    this.sync = null;
    const then = this.waiting;
    this.waiting = null;
    then?.();
  };
}
