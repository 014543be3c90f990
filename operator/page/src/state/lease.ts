// Control of the robot, which one operator holds at a time and renews with the number of the last state that this page
// has shown: what is not seen is not steered.
import { Signal } from "../ui/signal";
import type { Link } from "./link";

const kRenewMs = 200;
const kNameKey = "headway.name";

export class Lease {
  /** Null: this page has no control. */
  readonly number = new Signal<number | null>(null);
  /** Why the page lost control, or did not get it. */
  readonly notice = new Signal("");
  private shownState = 0;

  constructor(private readonly link: Link) {
    setInterval(() => void this.renew(), kRenewMs);
    link.state.watch((state) => {
      if (state !== "open" && this.held) this.lose("The link was lost, and control with it.");
    });
  }

  get held(): boolean {
    return this.number.value !== null;
  }

  get name(): string {
    return localStorage.getItem(kNameKey) ?? "operator";
  }

  set name(name: string) {
    localStorage.setItem(kNameKey, name.trim() || "operator");
  }

  /** This status is on the screen now. */
  shown(number: number): void {
    this.shownState = number;
  }

  async take(): Promise<void> {
    const answer = await this.link.call("take_control", { name: this.name });
    if (answer.ok && typeof answer["lease"] === "number") {
      this.notice.set("");
      this.number.set(answer["lease"]);
    } else {
      this.notice.set(`No control: ${answer.error ?? "refused"}.`);
    }
  }

  async release(): Promise<void> {
    this.number.set(null);
    await this.link.call("release_control");
  }

  private async renew(): Promise<void> {
    const lease = this.number.value;
    if (lease === null) return;
    const answer = await this.link.call("renew", { lease, state: this.shownState });
    if (!answer.ok && this.number.value === lease) this.lose(`Control was lost: ${answer.error ?? "not renewed"}.`);
  }

  private lose(why: string): void {
    this.number.set(null);
    this.notice.set(why);
  }
}
