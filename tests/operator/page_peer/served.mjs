// The simulated robot, serving its page.
import { spawn } from "node:child_process";
import { mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

export const root = new URL("../../../", import.meta.url).pathname;

/** Resolves with the process and the page's address once it listens. */
export function serve(program, ...more) {
  const out = mkdtempSync(join(tmpdir(), "headway-page-"));
  const child = spawn(program, ["sim", "config/worlds/lab.yaml", "--range", "--out", join(out, "sim"), "--serve", "--port", "0", ...more],
    { cwd: root, stdio: ["ignore", "pipe", "inherit"], env: { ...process.env, XDG_STATE_HOME: join(out, "state") } });
  return new Promise((done, fail) => {
    let said = "";
    child.stdout.on("data", (bytes) => {
      said += bytes;
      const address = said.match(/http:\/\/\S+/);
      if (address) done({ child, address: address[0] });
    });
    child.on("exit", (code) => fail(new Error(`the program ended with ${code}: ${said}`)));
  });
}

/** One line a check, and the exit code in the end. */
export class Checks {
  failures = 0;
  check(what, good, more = "") {
    console.log(`${good ? "ok  " : "FAIL"} ${what}${more ? `: ${more}` : ""}`);
    if (!good) ++this.failures;
  }
  end() {
    console.log(this.failures ? `${this.failures} failed` : "all well");
    process.exit(this.failures ? 1 : 0);
  }
}
