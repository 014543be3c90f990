// A frozen picture must not look alive: each view says how old it is, turns grey when that is too old, and a lost link
// is said over everything.
import type { App } from "../state/app";
import { byId, onClick, setText } from "../ui/dom";
import { age } from "../ui/words";

const kPictureOldMs = 2000;
const kPointsOldMs = 5000;
const kFirstLinkMs = 1500;

export class Freshness {
  private lost = false;
  /** When the link was lost. */
  private hadControl = false;
  private readonly begin = performance.now();

  constructor(private readonly app: App) {
    setInterval(() => this.look(), 200);
    onClick("notice-close", () => app.lease.notice.set(""));
    for (const words of [app.lease.notice, app.link.trouble]) words.watch(() => this.showNotice());
  }

  private look(): void {
    const { link } = this.app;
    this.showBanner();
    const live = link.live;
    this.mark("scene", "scene-age", this.app.seenAgoMs, !this.app.seesNow);
    this.mark("map", "map-age", link.ageOf("map"), !this.app.seesNow, "changed");
    this.mark("camera", "camera-age", link.ageOf("picture"), !live || link.ageOf("picture") > kPictureOldMs);
    setText(byId("points-age"), `points ${age(link.ageOf("points"))} old`);
    byId("points-age").dataset["old"] = String(!live || link.ageOf("points") > kPointsOldMs);
    for (const id of ["head", "numbers", "now"]) byId(id).classList.toggle("stale", !live);
  }

  private mark(id: string, ageId: string, ms: number, stale: boolean, verb = ""): void {
    byId(id).classList.toggle("stale", stale);
    const words = !Number.isFinite(ms) ? "no data" : verb ? `${verb} ${age(ms)} ago` : `${age(ms)} old`;
    setText(byId(ageId), stale && Number.isFinite(ms) ? `STALE ${words}` : words);
  }

  private showBanner(): void {
    const { link } = this.app;
    const lost = !link.live && link.state.value !== "login" && performance.now() - this.begin > kFirstLinkMs;
    byId("banner").hidden = !lost;
    document.body.classList.toggle("lost", lost);
    if (!lost) return link.live ? this.comeBack() : undefined;
    if (!this.lost) this.goes();
    setText(byId("banner-title"), "NO LINK TO THE ROBOT");
    const seen = Number.isFinite(link.ageOf("status")) ? `What you see is ${Math.round(link.ageOf("status") / 1000)} s old. ` : "";
    setText(byId("banner-text"), `${seen}STOP cannot reach it from here: it comes to rest by itself, or use the emergency stop. Connecting again…`);
  }

  private goes(): void {
    this.lost = true;
    this.hadControl = this.app.lease.held || this.app.lease.notice.value !== "";
    this.app.lease.notice.set("");
  }

  private comeBack(): void {
    if (!this.lost) return;
    this.lost = false;
    if (this.hadControl && !this.app.lease.held) this.app.lease.notice.set("The link is back. Nobody took control or went on: take control to steer again.");
  }

  private showNotice(): void {
    const text = this.app.link.trouble.value || this.app.lease.notice.value;
    byId("notice").hidden = text === "";
    setText(byId("notice-text"), text);
  }
}
