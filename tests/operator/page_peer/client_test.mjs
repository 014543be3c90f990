// Foxglove's own client against the program: node client_test.mjs HEADWAY
//
// Subscribes to every channel that is advertised and decodes every message with the schema that came with it; then calls
// services, well and badly.
import { existsSync } from "node:fs";
import protocol from "@foxglove/ws-protocol";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import WebSocket from "ws";
import { Checks, serve } from "./served.mjs";

const { FoxgloveClient } = protocol;
const kPatience = 60000; // [ms]
const checks = new Checks();
const { child, address } = await serve(process.argv[2]);
child.removeAllListeners("exit");
const client = new FoxgloveClient({ ws: new WebSocket(address.replace("http", "ws") + "ws", [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
const faults = [];
client.on("error", (fault) => faults.push(String(fault.message ?? fault)));

const readers = new Map();
const seen = new Map();
client.on("advertise", (channels) => {
  for (const channel of channels) {
    const reader = new MessageReader(parse(channel.schema, { ros2: true }));
    readers.set(client.subscribe(channel.id), { channel, reader });
  }
});
client.on("message", ({ subscriptionId, data }) => {
  const { channel, reader } = readers.get(subscriptionId);
  try {
    const message = reader.readMessage(data);
    seen.set(channel.topic, { count: (seen.get(channel.topic)?.count ?? 0) + 1, message });
  } catch (fault) {
    faults.push(`${channel.topic}: ${fault.message}`);
  }
});
const services = new Map();
client.on("advertiseServices", (list) => { for (const service of list) services.set(service.name, service.id); });

async function until(what) {
  for (const end = Date.now() + kPatience; Date.now() < end; await new Promise((go) => setTimeout(go, 50))) if (what()) return true;
  return false;
}
let lastCall = 0;
function call(name, body, id = services.get(name)) {
  const callId = ++lastCall;
  return new Promise((done) => {
    const take = (answer) => {
      if (answer.callId !== callId) return;
      done(JSON.parse(new TextDecoder().decode(answer.data)));
    };
    client.on("serviceCallResponse", take);
    client.on("serviceCallFailure", (failure) => { if (failure.callId === callId) done({ failed: failure.message }); });
    const text = new TextEncoder().encode(typeof body === "string" ? body : JSON.stringify(body));
    client.sendServiceCallRequest({ serviceId: id, callId, encoding: "json", data: new DataView(text.buffer) });
  });
}

try {
  checks.check("channels are advertised", await until(() => readers.size >= 12), `${readers.size}`);
  const topics = [...readers.values()].map(({ channel }) => channel.topic);
  checks.check("every channel sends, and is decoded", await until(() => topics.every((topic) => seen.has(topic))),
    topics.map((topic) => `${topic} ${seen.get(topic)?.count ?? 0}`).join(", "));
  checks.check("the newest status counts up", await until(() => (seen.get("/headway/status")?.count ?? 0) > 5));
  const status = () => seen.get("/headway/status").message;
  checks.check("the robot has looked around", await until(() => status().state === "wait for a goal"));

  checks.check("ping is answered", (await call("ping", {})).ok === true);
  checks.check("a goal without control is refused", /take control/.test((await call("plan_preview", { x: 0, y: 0 })).error));
  const taken = await call("take_control", { name: "client" });
  checks.check("control is taken", taken.ok === true);
  const renewal = setInterval(() => void call("renew", { lease: taken.lease, state: status().number }), 200);
  checks.check("and told to all", await until(() => status().lease_holder === "client"));
  checks.check("with who looks on, and from where", await until(() => status().viewers.some((viewer) =>
    viewer.name === "client" && viewer.has_control && viewer.address === "127.0.0.1" && viewer.sent > 0n && viewer.missed >= 0n)));
  const way = await call("plan_preview", { x: 0.2, y: 0.2 });
  checks.check("a way is shown", way.ok === true && way.steps > 5, JSON.stringify({ ...way, way: undefined }));
  checks.check("to all", await until(() => seen.get("/preview").message.poses.length > 5));
  checks.check("with the floor that the body sweeps", await until(() => seen.get("/preview/body").message.data.some((cell) => cell === 100)));
  checks.check("a goal in a wall is refused with the reason", /no way/.test((await call("plan_preview", { x: -20, y: 0 })).error ?? "") ||
    /outside the floor/.test((await call("plan_preview", { x: -20, y: 0 })).error ?? ""));
  checks.check("an unknown key is refused", /no such key/.test((await call("plan_preview", { x: 0, y: 0, speed: 9 })).error));
  checks.check("what is no JSON fails", "failed" in (await call("ping", "[1")));
  checks.check("what is too deep fails", "failed" in (await call("ping", "[".repeat(1000) + "]".repeat(1000))));
  checks.check("an unknown service fails", "failed" in (await call("dance", {}, 999)));
  checks.check("the plan is walked", (await call("plan_confirm", { plan: way.plan })).ok === true && await until(() => !status().at_rest));
  checks.check("and committed steps are marked", await until(() =>
    seen.get("/footsteps").message.markers.some((marker) => marker.ns === "committed")));
  checks.check("a recording begins", (await call("record", { on: true })).ok === true && await until(() => status().recording));
  checks.check("in a file that is named, and grows", await until(() => existsSync(status().record_file) && status().record_mib > 0.1),
    status().record_file);
  checks.check("and ends", (await call("record", { on: false })).ok === true && await until(() => !status().recording));
  checks.check("without a fault", status().record_fault === "" && status().record_dropped === 0n, status().record_fault);
  clearInterval(renewal);
  checks.check("without renewals it comes to rest", await until(() => status().at_rest));
  checks.check("and the lease runs out", await until(() => status().lease_holder === ""));
  checks.check("a stop needs no control", (await call("stop", {})).ok === true);
  checks.check("nothing could not be decoded", faults.length === 0, faults.join("; "));
} catch (fault) {
  checks.check("all of it could be done", false, fault.stack);
} finally {
  client.close();
  child.kill("SIGINT");
}
checks.end();
