// The page in a browser, served by the program: node page_test.mjs HEADWAY [FOLDER for screenshots]
//
// Looks, previews, confirms, watches the walk, stops it, loses the link and comes back, with two operators; by day and
// by night, on a tablet. One line a check; exit code 1 when one fails.
import { mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { chromium } from "playwright-core";
import { Checks, serve } from "./served.mjs";

const [program, folder = "screenshots"] = process.argv.slice(2);
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const kMostBytes = 400 * 1024;
const kPatience = 60000; // with a walk on a slow machine [ms]
mkdirSync(folder, { recursive: true });

const checks = new Checks();
const check = (...what) => checks.check(...what);

async function open(browser, address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, colorScheme: "dark", ...options });
  const page = await context.newPage();
  page.faults = [];
  page.on("console", (message) => { if (message.type() === "error") page.faults.push(message.text()); });
  page.on("pageerror", (fault) => page.faults.push(fault.message));
  const begun = Date.now();
  await page.goto(address);
  await until(page, () => window.headway?.robot.status() !== undefined);
  page.firstView = Date.now() - begun;
  return page;
}
const status = (page) => page.evaluate(() => {
  const { state, at_rest, x, y, has_goal, safety } = window.headway.robot.status();
  return { state, at_rest, x, y, has_goal, safety };
});
/** As page.waitForFunction, which the page's security policy does not let look again by itself. */
async function until(page, what, argument) {
  for (const end = Date.now() + kPatience; Date.now() < end; await page.waitForTimeout(50))
    if (await page.evaluate(what, argument)) return;
  throw new Error(`waited in vain for ${what}`);
}

/** Clicks the floor map at a place of the map [m]. */
async function clickFloor(page, x, y, options = {}) {
  const at = await page.evaluate(([x, y]) => window.headway.map.at(x, y), [x, y]);
  const area = await page.locator("#map").boundingBox();
  await page.mouse.move(area.x + at[0], area.y + at[1]);
  if (options.shift) await page.keyboard.down("Shift");
  await page.mouse.down();
  await page.mouse.up();
  if (options.shift) await page.keyboard.up("Shift");
}

async function accessible(page, name) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "best-practice"] }));
  check(`accessible, ${name}`, violations.length === 0,
    violations.map((v) => `${v.id} ${v.nodes.map((n) => n.target.join(" ")).join(", ")}`).join("; "));
}

const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"] });
const { child, address } = await serve(program);
child.removeAllListeners("exit");
try {
  let bytes = 0;
  for (const path of ["", "page.js", "page.css", "favicon.svg"]) {
    const got = await fetch(new URL(path, address), { headers: { "accept-encoding": "gzip" } });
    bytes += Number(got.headers.get("content-length"));
    check(`/${path} is served`, got.ok);
  }
  check("the page is small", bytes <= kMostBytes, `${(bytes / 1024).toFixed(0)} KiB gzip`);

  const page = await open(browser, address);
  // Its time is told and not judged: machines that run tests are busy.
  check("the first view comes", true, `${page.firstView} ms`);
  await until(page, () => window.headway.robot.status().state === "wait for a goal");
  await until(page, () => window.headway.scene.voxels.occupied > 1000);
  check("the robot has looked around, and voxels are shown", true, `${await page.evaluate(() => window.headway.scene.voxels.occupied)} occupied`);
  await page.screenshot({ path: join(folder, "waits.png") });
  await accessible(page, "dark");

  check("without control nothing can be told", await page.locator("#home").isDisabled());
  await clickFloor(page, -1.6, -1.0);
  await until(page, () => document.querySelector("#plan").textContent.includes("take control"));
  check("a click without control says what to do", true);
  await page.keyboard.press("t");
  await until(page, () => window.headway.robot.inControl);
  check("control is taken with a key", true);

  const other = await open(browser, address);
  await until(other, () => document.querySelector("#control").textContent.includes("operator has control"));
  await other.click("#take");
  await until(other, () => document.querySelector("#plan").textContent.includes("has control"));
  check("a second operator is refused", !(await other.evaluate(() => window.headway.robot.inControl)));

  const before = await status(page);
  await clickFloor(page, 0.2, 0.2);
  await page.waitForSelector("#confirm", { timeout: kPatience });
  check("a way is shown", /\d+ steps/.test(await page.textContent("#plan")), await page.textContent("#plan p"));
  await page.screenshot({ path: join(folder, "preview.png") });
  await page.waitForTimeout(1500);
  const still = await status(page);
  check("and not walked before it is confirmed", Math.hypot(still.x - before.x, still.y - before.y) < 1e-6);
  await page.click("#confirm");
  await until(page, () => !window.headway.robot.status().at_rest);
  await until(page, (x) => Math.hypot(window.headway.robot.status().x - x[0], window.headway.robot.status().y - x[1]) > 0.6, [before.x, before.y]);
  await page.screenshot({ path: join(folder, "walks.png") });
  check("the confirmed way is walked", true);
  await page.keyboard.press("Escape");
  await until(page, () => window.headway.robot.status().at_rest);
  const stopped = await status(page);
  check("Esc stops it", stopped.state === "stopped", stopped.state);
  await page.waitForTimeout(1500);
  const stays = await status(page);
  check("and it stays", Math.hypot(stays.x - stopped.x, stays.y - stopped.y) < 1e-6);

  const wall = await page.evaluate(() => {
    const { info, data } = window.headway.robot.get("/map");
    const place = (i) => [info.origin.position.x + (i % info.width + 0.5) * info.resolution,
      info.origin.position.y + (Math.floor(i / info.width) + 0.5) * info.resolution];
    const canvas = document.querySelector("#map");
    for (let i = 0; i < data.length; ++i) {
      const [left, top] = window.headway.map.at(...place(i));
      if (data[i] === 100 && left > 5 && top > 5 && left < canvas.clientWidth - 5 && top < canvas.clientHeight - 5) return place(i);
    }
  });
  await clickFloor(page, ...wall);
  await until(page, () => document.querySelector("#plan .bad") !== null);
  check("where there is no way it says why", true, await page.textContent("#plan .bad"));

  await page.click("#home");
  await page.waitForSelector("#confirm", { timeout: kPatience });
  await page.click("#confirm");
  await until(page, () => !window.headway.robot.status().at_rest);
  await page.context().setOffline(true);
  await page.evaluate(() => window.headway.robot.breakLink());
  await until(page, () => !document.querySelector("#banner").hidden);
  await page.screenshot({ path: join(folder, "link_lost.png") });
  check("a lost link cannot be overlooked", await page.evaluate(() => document.body.classList.contains("dead")));
  await until(other, () => window.headway.robot.status().at_rest);
  check("without the link the robot comes to rest", true);
  await page.context().setOffline(false);
  await until(page, () => window.headway.robot.connected && document.querySelector("#banner").hidden);
  const back = await status(page);
  await page.waitForTimeout(2000);
  const later = await status(page);
  check("the link comes back by itself, control and walk do not",
    !(await page.evaluate(() => window.headway.robot.inControl)) && Math.hypot(later.x - back.x, later.y - back.y) < 1e-6);
  await until(other, () => window.headway.robot.status().lease_holder === "");
  await other.click("#take");
  await until(other, () => window.headway.robot.inControl);
  check("then another may take control", true);
  check("no error in the console", page.faults.filter((f) => !/ERR_INTERNET_DISCONNECTED|WebSocket/.test(f)).length === 0, page.faults.join("; "));
  check("nor in the other's", other.faults.length === 0, other.faults.join("; "));
  await other.context().close();

  for (const [name, options] of [["light", { colorScheme: "light" }], ["tablet", { viewport: { width: 1024, height: 768 }, hasTouch: true }],
    ["phone", { viewport: { width: 390, height: 844 }, hasTouch: true }]]) {
    const small = await open(browser, address, options);
    await until(small, () => window.headway.scene.voxels.occupied > 1000);
    await small.waitForTimeout(500);
    await small.screenshot({ path: join(folder, `${name}.png`) });
    check(`${name}: nothing sticks out`, await small.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
    await accessible(small, name);
    await small.context().close();
  }
} catch (fault) {
  check("all of it could be done", false, fault.message);
} finally {
  child.kill("SIGINT");
  await browser.close();
}
checks.end();
