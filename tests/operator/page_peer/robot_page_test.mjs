// The page against the program itself: node robot_page_test.mjs HEADWAY [FOLDER for pictures]
//
// Serves a simulated robot, and lets page_test.mjs look, preview, confirm, stop, lose the link and come back.
import { spawn } from "node:child_process";
import { serve } from "./served.mjs";

const [program, shots = "page_shots"] = process.argv.slice(2);
const { child, address } = await serve(program);
child.removeAllListeners("exit");
const test = spawn(process.execPath, [new URL("page_test.mjs", import.meta.url).pathname], {
  stdio: "inherit",
  env: { ...process.env, HEADWAY_URL: address, HEADWAY_PID: String(child.pid), HEADWAY_GOAL: "0.2,0.2", HEADWAY_SHOTS: shots },
});
test.on("exit", (code) => {
  child.kill("SIGCONT");
  child.kill("SIGINT");
  process.exit(code ?? 1);
});
