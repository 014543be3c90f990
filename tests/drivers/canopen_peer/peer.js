// usage: node peer.js
// Two head drives (nodes 17 and 18) on a bus made of lines. Read from standard input:
//   211#0F00010000    a frame, as candump writes it
//   step 5            time passes [ms]; answered with the frames sent since the last step, then "."
//   position 17       answered with the joint's [0.001 deg]; get 17 607d 2, with an object's bytes
//   jump 17           answered with the largest way from the joint to a cyclic target [0.001 deg]
//   push 17 1234      somebody turns the joint; reboot 17; fault 17; emergency 17 8611; remove 17 60a8, an object
// Ends with its input; with exit code 77 where the package "canopen" is missing (scripts/setup installs it).
'use strict';

const readline = require('readline');
const { SteppedTimers } = require('./stepped_timers');

const timers = new SteppedTimers();
timers.install();

function load() {
  // It checks blocks of data, which no drive here is sent, by a native add-on that would have to be compiled.
  const checksum = require.resolve('node-crc');
  require.cache[checksum] = { id: checksum, filename: checksum, loaded: true, exports: {} };
  return require('./drive');
}

let Drive, State;
try {
  ({ Drive, State } = load());
} catch (missing) {
  if (missing.code !== 'MODULE_NOT_FOUND') throw missing;
  console.error(missing.message);
  process.exit(77);
}

const out = [];
const write = ({ id, data }) => out.push(`${id.toString(16).toUpperCase().padStart(3, '0')}#${data.toString('hex')}`);
const drives = new Map([17, 18].map((id) => [id, new Drive(id, write)]));

const hex = (text) => parseInt(text, 16);
const say = (text) => process.stdout.write(`${text}\n`);
const orders = {
  step(milliseconds) {
    timers.step(Number(milliseconds));
    for (const drive of drives.values()) drive.step(Number(milliseconds));
    say([...out.splice(0), '.'].join('\n'));
  },
  position: (id) => say(drives.get(Number(id)).position),
  jump: (id) => say(drives.get(Number(id)).jump),
  get: (id, index, subindex) => say(drives.get(Number(id)).raw(hex(index), Number(subindex)).toString('hex')),
  push: (id, position) => void (drives.get(Number(id)).position = Number(position)),
  reboot: (id) => drives.get(Number(id)).reboot(),
  fault: (id) => drives.get(Number(id)).become(State.FAULT),
  emergency: (id, code) => drives.get(Number(id)).device.emcy.write(hex(code)),
  remove: (id, index) => drives.get(Number(id)).device.eds.removeEntry(hex(index)),
};

readline.createInterface({ input: process.stdin }).on('line', (line) => {
  const [, id, data] = line.match(/^([0-9A-F]{3})#([0-9A-F]*)$/i) ?? [];
  if (id) {
    for (const drive of drives.values()) drive.receive({ id: hex(id), data: Buffer.from(data, 'hex') });
  } else {
    const [order, ...args] = line.split(' ');
    orders[order](...args);
  }
  timers.settle();
});
