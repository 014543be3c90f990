// What the panels share.
import { Commands } from "./commands";
import { Lease } from "./lease";
import { Link } from "./link";
import { Mission } from "./mission";
import { SweptImage } from "./swept_image";
import { Signal } from "../ui/signal";

export type HeadPose = { pan: number; tilt: number };

export class App {
  readonly link = new Link();
  readonly lease = new Lease(this.link);
  readonly mission = new Mission(this.link, this.lease);
  readonly commands = new Commands(this.link);
  /** Where the field is shown as if the head looked there; null: only where it looks. */
  readonly whatIf = new Signal<HeadPose | null>(null);
  /** The floor that the body sweeps: along the way that is walked, and along the one that is proposed. */
  readonly planBody = new SweptImage();
  readonly previewBody = new SweptImage();
  readonly showsBody = new Signal(true);

  constructor() {
    this.link.on("planBody", (message) => this.planBody.take(message));
    this.link.on("previewBody", (message) => this.previewBody.take(message));
  }

  /** The one that matters now: of the proposed way while it is shown. */
  get body(): SweptImage {
    return this.showsProposal && this.previewBody.area > 0 ? this.previewBody : this.planBody;
  }

  /** The robot keeps a proposed way until the next; who cancelled it does not want to see it. */
  get showsProposal(): boolean {
    return !this.lease.held || this.mission.state.value.kind === "proposed";
  }

  /** Since the newest camera frame [ms]; infinite before the first. */
  get seenAgoMs(): number {
    const status = this.link.status;
    if (status === undefined || status.frame_age_ms < 0) return Infinity;
    return status.frame_age_ms + this.link.ageOf("status");
  }

  /** False where the newest camera frame is so old that map and points may tell of a world that has changed. */
  get seesNow(): boolean {
    return this.link.live && this.seenAgoMs < 2000;
  }
}
