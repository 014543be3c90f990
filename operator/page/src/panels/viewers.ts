// Who looks on, who of them has control, and what each was too slow for.
import type { App } from "../state/app";
import type { ViewerStatus } from "../wire/messages";
import { byId, el } from "../ui/dom";

export class Viewers {
  private shown = "";

  constructor(private readonly app: App) {
    app.link.on("status", (status) => this.show(status.viewers));
  }

  private show(viewers: readonly ViewerStatus[]): void {
    const own = this.app.link.viewer;
    const said = JSON.stringify([own, viewers.map(({ sent: _, ...rest }) => rest)]);
    if (said === this.shown) return;
    this.shown = said;
    byId("viewers").replaceChildren(...viewers.map((viewer) => row(viewer, viewer.number === own)));
  }
}

function row(viewer: ViewerStatus, own: boolean): HTMLElement {
  const name = viewer.name || `${viewer.role} ${viewer.number}`;
  const who = `${own ? `${name} (you)` : name}${viewer.has_control ? ", in control" : ""}`;
  const from = el("span", { class: "from" }, ` ${viewer.role}, ${viewer.address}`);
  const line = el("tr", {}, el("th", { scope: "row" }, who, from), el("td", {}, `${viewer.missed}`));
  line.dataset["control"] = String(viewer.has_control);
  line.dataset["own"] = String(own);
  return line;
}
