// Asks for the token where the robot wants one.
import type { App } from "../state/app";
import { byId, setText } from "../ui/dom";

export function startLogin({ link }: App): void {
  const dialog = byId<HTMLDialogElement>("login");
  const token = byId<HTMLInputElement>("token");
  dialog.addEventListener("cancel", (event) => event.preventDefault());
  byId("login-form").addEventListener("submit", (event) => {
    event.preventDefault();
    void link.enter(token.value);
    token.value = "";
  });
  link.trouble.watch((trouble) => setText(byId("login-trouble"), trouble));
  link.state.watch((state) => {
    if (state === "login" && !dialog.open) dialog.showModal();
    if (state === "open" && dialog.open) dialog.close();
  });
}
