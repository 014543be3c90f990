// node build.mjs [--out FOLDER]: the page as it is served, in dist/ unless told otherwise.
import * as esbuild from "esbuild";
import { copyFileSync, mkdirSync } from "node:fs";
import { join } from "node:path";

const at = process.argv.indexOf("--out");
const out = at > 0 ? process.argv[at + 1] : "dist";
mkdirSync(out, { recursive: true });
await esbuild.build({
  entryPoints: { page: "src/main.ts" },
  bundle: true,
  minify: true,
  format: "esm",
  target: ["chrome100", "firefox100", "safari15"],
  legalComments: "none",
  outdir: out,
  logLevel: "warning",
});
await esbuild.build({ entryPoints: { page: "src/page.css" }, bundle: true, minify: true, outdir: out, logLevel: "warning" });
for (const file of ["index.html", "favicon.svg"]) copyFileSync(join("src", file), join(out, file));
