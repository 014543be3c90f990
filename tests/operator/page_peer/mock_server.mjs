// node mock_server.mjs [--port N] [--page FOLDER] [--resolution M] [--filled]: serves the built page and speaks the
// operator's wire for an invented robot, so that the page can be made and tested without the program.
import { createServer } from "node:http";
import { existsSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { parse } from "@foxglove/rosmsg";
import { MessageWriter } from "@foxglove/rosmsg2-serialization";
import { WebSocketServer } from "ws";
import { MockRobot } from "./mock_robot.mjs";
import { schema, topics } from "./schemas.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const kPage = process.env.HEADWAY_PAGE ?? join(here, "../../../operator/page/dist");
const kTypes = { "/": ["index.html", "text/html; charset=utf-8"], "/page.js": ["page.js", "text/javascript; charset=utf-8"],
                 "/page.css": ["page.css", "text/css; charset=utf-8"], "/favicon.svg": ["favicon.svg", "image/svg+xml"] };
const kPolicy = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; " +
                "frame-ancestors 'none'; base-uri 'none'; form-action 'none'";
const kServices = ["ping", "stop", "take_control", "release_control", "renew", "plan_preview", "plan_confirm", "pause",
                   "resume", "look", "look_around", "explore_preview", "go_home", "tour", "record", "reset"];
const kFree = new Set(["ping", "stop", "take_control", "release_control", "renew"]);
const writers = topics.map(([, type]) => new MessageWriter(parse(schema(type), { ros2: true })));

class Client {
  subscriptions = new Map(); // channel -> subscription
  told = new Set(); // voxel bricks still to be told
  whole = true;

  constructor(socket, robot) {
    this.socket = socket;
    for (const key of robot.voxels.bricks.keys()) this.told.add(key);
  }

  text(message) {
    this.socket.send(JSON.stringify(message));
  }

  send(channel, cdr, seconds) {
    const id = this.subscriptions.get(channel);
    if (id === undefined || this.socket.bufferedAmount > 4e6) return;
    const head = Buffer.alloc(13);
    head.writeUInt8(1, 0);
    head.writeUInt32LE(id, 1);
    head.writeBigUInt64LE(BigInt(Math.round(seconds * 1e9)), 5);
    this.socket.send(Buffer.concat([head, cdr]));
  }
}

export class MockServer {
  clients = new Set();
  latched = new Map(); // channel -> newest cdr
  plan = null;
  plans = 0;
  timers = [];

  constructor(options = {}) {
    this.options = { port: 0, page: kPage, ...options };
    this.robot = new MockRobot(this.options);
  }

  start() {
    this.http = createServer((request, response) => this.serve(request, response));
    this.sockets = new WebSocketServer({ server: this.http, path: "/ws", handleProtocols: (offered) =>
      ["foxglove.sdk.v1", "foxglove.websocket.v1"].find((name) => offered.has(name)) ?? false });
    this.sockets.on("connection", (socket) => this.welcome(socket));
    const every = (ms, act) => this.timers.push(setInterval(act, ms));
    every(50, () => this.step());
    every(300, () => this.frame());
    this.publish("/field", this.robot.field());
    this.propose(null);
    return new Promise((done) => this.http.listen(this.options.port, "127.0.0.1", () => {
      this.options.port = this.http.address().port;
      done(`http://127.0.0.1:${this.options.port}/`);
    }));
  }

  /** As if the machine had lost its power. */
  kill() {
    for (const timer of this.timers) clearInterval(timer);
    for (const { socket } of this.clients) socket.terminate();
    this.http.closeAllConnections?.();
    return new Promise((done) => this.http.close(done));
  }

  serve(request, response) {
    const path = request.url.split("?")[0];
    if (path === "/session") return this.json(response, { role: "operator", token_needed: false });
    const file = kTypes[path] && join(this.options.page, kTypes[path][0]);
    if (!file || !existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { "Content-Type": kTypes[path][1], "Content-Security-Policy": kPolicy,
      "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer" });
    response.end(readFileSync(file));
  }

  json(response, value) {
    response.writeHead(200, { "Content-Type": "application/json" });
    response.end(JSON.stringify(value));
  }

  welcome(socket) {
    const client = new Client(socket, this.robot);
    this.clients.add(client);
    socket.on("message", (data, binary) => (binary ? this.call(client, data) : this.order(client, JSON.parse(data))));
    socket.on("close", () => this.clients.delete(client));
    client.text({ op: "serverInfo", name: "Headway: HRP-2", capabilities: ["services", "time", "clientPublish"],
      supportedEncodings: ["json", "cdr"], sessionId: "mock", metadata: { role: "operator" } });
    client.text({ op: "advertise", channels: topics.map(([topic, type], i) => ({ id: i + 1, topic, encoding: "cdr",
      schemaName: type, schemaEncoding: "ros2msg", schema: schema(type) })) });
    client.text({ op: "advertiseServices", services: kServices.map((name, i) => ({ id: i + 1, name, type: name,
      request: { encoding: "json", schemaName: "", schemaEncoding: "", schema: "" },
      response: { encoding: "json", schemaName: "", schemaEncoding: "", schema: "" }, requestSchema: "", responseSchema: "" })) });
  }

  order(client, message) {
    for (const { id, channelId } of message.subscriptions ?? []) {
      client.subscriptions.set(channelId, id);
      const newest = this.latched.get(channelId);
      if (newest) client.send(channelId, newest, this.robot.now);
    }
  }

  publish(topic, message) {
    const index = topics.findIndex(([name]) => name === topic);
    const cdr = Buffer.from(writers[index].writeMessage(message));
    if (topics[index][2]) this.latched.set(index + 1, cdr);
    for (const client of this.clients) client.send(index + 1, cdr, this.robot.now);
  }

  step() {
    const { robot } = this;
    const late = performance.now() - (this.renewed ?? 0);
    if (robot.lease.holder && late > 5000) robot.lease = { ...robot.lease, holder: "" };
    robot.step(0.05, late > 1000);
    robot.clients = this.clients.size;
    this.publish("/tf", robot.tf());
    this.publish("/headway/status", robot.status());
  }

  frame() {
    const { robot } = this;
    const { points, picture } = robot.see();
    this.publish("/camera/left", { header: robot.header("camera_left"), format: "png", data: new Uint8Array(picture) });
    this.publish("/points", robot.pointCloud(points));
    this.publish("/map", robot.map());
    this.publish("/plan", robot.pathOf(robot.way.length ? [[robot.x, robot.y], ...robot.way] : []));
    this.publish("/footsteps", robot.footsteps());
    this.tellVoxels();
  }

  tellVoxels() {
    for (const client of this.clients) for (const key of this.robot.voxels.changed) client.told.add(key);
    this.robot.voxels.changed.clear();
    for (const client of this.clients) {
      const keys = [...client.told].slice(0, 1000);
      if (!keys.length || !client.subscriptions.has(10)) continue;
      for (const key of keys) client.told.delete(key);
      client.send(10, Buffer.from(writers[9].writeMessage(this.robot.voxels.message(keys, client.whole))), this.robot.now);
      client.whole = false;
    }
  }

  call(client, data) {
    const name = kServices[data.readUInt32LE(1) - 1];
    const body = 13 + data.readUInt32LE(9);
    const answer = Buffer.from(JSON.stringify(this.answer(client, name, JSON.parse(data.subarray(body)))));
    const head = Buffer.alloc(13);
    head.writeUInt8(3, 0);
    data.copy(head, 1, 1, 9);
    head.writeUInt32LE(4, 9);
    client.socket.send(Buffer.concat([head, Buffer.from("json"), answer]));
  }

  answer(client, name, request) {
    const { holder } = this.robot.lease;
    const holds = holder && this.holder === client;
    if (!kFree.has(name) && !holds) return { ok: false, error: holder ? `${holder} has control` : "take control first" };
    return { ok: true, ...this[name](client, request) };
  }

  ping() {
    return { now_ns: Math.round(this.robot.now * 1e9) };
  }

  stop() {
    this.robot.stop();
    this.propose(null);
  }

  take_control(client, { name }) {
    const { lease } = this.robot;
    if (lease.holder && this.holder !== client) return { ok: false, error: `${lease.holder} has control` };
    [this.holder, this.renewed] = [client, performance.now()];
    this.robot.lease = { holder: name, number: lease.number + 1 };
    return { lease: lease.number + 1 };
  }

  release_control(client) {
    if (this.holder === client) this.robot.lease.holder = "";
  }

  renew(client, { lease, state }) {
    const { robot } = this;
    if (this.holder !== client || lease !== robot.lease.number || !robot.lease.holder) return { ok: false, error: "this lease has ended" };
    if (robot.number - state < 20) this.renewed = performance.now();
    return {};
  }

  propose(plan) {
    this.plan = plan && { ...plan, plan: ++this.plans };
    this.publish("/preview", this.robot.pathOf(plan?.way ?? []));
    return this.plan ?? {};
  }

  plan_preview(client, { x, y, yaw_deg }) {
    const found = this.robot.plan([x, y]);
    if (!found.ok) {
      this.propose(null);
      return found;
    }
    const goal = { x, y, ...(yaw_deg === undefined ? {} : { yaw: (yaw_deg * Math.PI) / 180 }) };
    return { ...this.propose({ ...found, goal }), goal: undefined };
  }

  plan_confirm(client, { plan }) {
    if (!this.plan || this.plan.plan !== plan) return { ok: false, error: "this plan is no longer valid" };
    const { way, goal, tour, view } = this.plan;
    this.propose(null);
    if (view) this.robot.aim = view;
    if (way.length > 1) this.robot.walk(way, goal);
    this.robot.tour = tour ?? [];
    return {};
  }

  pause() {
    this.robot.paused = true;
  }

  resume() {
    this.robot.paused = false;
  }

  look_around() {
    this.robot.lookAround();
  }

  look(client, { pan, tilt }) {
    if (!this.robot.atRest) return { ok: false, error: "it looks only where told while it is at rest" };
    this.robot.aim = { pan, tilt };
    return {};
  }

  explore_preview() {
    const found = this.robot.plan([0.2, 0.6]);
    const view = { pan: 0.5, tilt: 0.2 };
    this.propose({ ...found, goal: { x: 0.2, y: 0.6 }, view });
    return { ...this.plan, view: { pan_deg: 28.6, tilt_deg: 11.5, gain: 1.84 } };
  }

  go_home(client) {
    return this.plan_preview(client, { x: -2, y: -0.6 });
  }

  tour(client, { goals }) {
    const [[x, y], ...rest] = goals;
    const answer = this.plan_preview(client, { x, y });
    if (this.plan) this.plan.tour = rest;
    return answer;
  }

  record(client, { on }) {
    this.robot.recording = on;
  }

  reset() {}
}

function option(name) {
  const at = process.argv.indexOf(`--${name}`);
  return at < 0 ? undefined : process.argv[at + 1];
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const options = { port: Number(option("port") ?? 8760), resolution: Number(option("resolution") ?? 0.05),
                    filled: process.argv.includes("--filled"), ...(option("page") ? { page: option("page") } : {}) };
  console.log(await new MockServer(options).start());
}
