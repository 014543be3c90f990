// One drive of the head on the npm package "canopen", which knows nothing of this project: its SDO server, network
// management, heartbeats and PDO mapping do what the master has written. Only the drive profile is written here, from
// CiA 402: the state machine, profile and cyclic synchronous position, and a joint that goes where it is told.
'use strict';

const { Device, Eds, ObjectType, DataType } = require('canopen');

const State = { DISABLED: 0x40, READY: 0x21, ON: 0x23, ENABLED: 0x27, QUICK_STOP: 0x07, FAULT: 0x08 };
const PROFILE_POSITION = 1, CYCLIC_POSITION = 8;
const INITIALIZING = 0, PRE_OPERATIONAL = 127;

const U8 = DataType.UNSIGNED8, U16 = DataType.UNSIGNED16, U32 = DataType.UNSIGNED32;
const I8 = DataType.INTEGER8, I16 = DataType.INTEGER16, I32 = DataType.INTEGER32;

// Index, type and value after power-on.
const variables = (id) => [
  [0x1005, U32, 0x80], [0x1014, U32, 0x80 + id], [0x1017, U16, 0],
  [0x6007, I16, 1], [0x6040, U16, 0], [0x6041, U16, 0], [0x605a, I16, 2], [0x605e, I16, 2],
  [0x6060, I8, 0], [0x6061, I8, 0], [0x6064, I32, 0], [0x6065, U32, 0], [0x6066, U16, 0], [0x606c, I32, 0],
  [0x607a, I32, 0], [0x6081, U32, 0], [0x6083, U32, 0], [0x6084, U32, 0], [0x6085, U32, 0], [0x60a8, U32, 0],
];
// Index, and type and value of each sub-index from 1.
const records = (id) => [
  [0x1016, [[U32, 0]]],
  [0x1200, [[U32, 0x600 + id], [U32, 0x580 + id]]],
  [0x1400, [[U32, 0x80000200 + id], [U8, 255]]], [0x1600, [[U32, 0], [U32, 0], [U32, 0]]],
  [0x1800, [[U32, 0x80000180 + id], [U8, 255]]], [0x1a00, [[U32, 0], [U32, 0]]],
  [0x1801, [[U32, 0x80000280 + id], [U8, 255]]], [0x1a01, [[U32, 0], [U32, 0]]],
  [0x607d, [[I32, -180000], [I32, 180000]]],
  [0x60c2, [[U8, 1], [I8, -3]]],
];

function dictionary(id) {
  const eds = new Eds();
  for (const [index, dataType, defaultValue] of variables(id))
    eds.addEntry(index, { parameterName: index.toString(16), dataType, defaultValue });
  for (const [index, subs] of records(id)) {
    eds.addEntry(index, { parameterName: index.toString(16), objectType: ObjectType.RECORD });
    subs.forEach(([dataType, defaultValue], i) =>
      eds.addSubEntry(index, i + 1, { parameterName: `${index.toString(16)} ${i + 1}`, dataType, defaultValue }));
  }
  return eds;
}

class Drive {
  state = State.DISABLED;
  position = 0; // 0.001 degree
  velocity = 0;
  target = 0;
  word = 0;
  acknowledges = false;
  jump = 0; // the largest of a cyclic target from where the joint was

  constructor(id, send) {
    this.id = id;
    this.device = new Device({ eds: dictionary(id), id });
    this.device.on('message', send);
    let before = INITIALIZING;
    this.device.nmt.on('changeState', (state) => {
      // The package leaves the boot-up message (CiA 301) to the application.
      if (before === INITIALIZING && state === PRE_OPERATIONAL) send({ id: 0x700 + id, data: Buffer.from([0]) });
      before = state;
    });
    this.device.nmt.on('timeout', () => this.loseMaster());
    this.device.start();
  }

  get(index) {
    return this.device.getValue(index);
  }

  /// The bytes of an object, as they travel.
  raw(index, subindex) {
    const entry = this.device.eds.getEntry(index);
    return entry.subNumber ? entry.at(subindex).raw : entry.raw;
  }

  receive(frame) {
    this.device.receive(frame);
    // A controlword commands when it comes, or with the next SYNC; a later stop of the drive's own stands.
    if (frame.id === 0x200 + this.id) this.is_commanded = true;
    const takesSync = this.raw(0x1400, 2)[0] <= 240;
    if (this.is_commanded && (!takesSync || frame.id === 0x80)) {
      this.is_commanded = false;
      this.obey(this.get(0x6040));
    }
    this.report();
  }

  step(milliseconds) {
    const reach = this.is_cyclic() ? Infinity : (this.get(0x6081) * milliseconds) / 1000;
    const before = this.position;
    if (this.state === State.ENABLED && (this.word & 0x100) === 0)
      this.position += Math.round(Math.max(-reach, Math.min(reach, this.target - this.position)));
    this.velocity = ((this.position - before) * 1000) / milliseconds;
    this.report();
  }

  report() {
    const reached = this.position === this.target ? 0x400 : 0;
    const acknowledged = this.acknowledges || this.is_cyclic() ? 0x1000 : 0; // or: it follows
    this.device.setValue(0x6041, this.state | reached | acknowledged);
    this.device.setValue(0x6061, this.get(0x6060));
    this.device.setValue(0x6064, this.position);
    this.device.setValue(0x606c, this.velocity);
  }

  is_cyclic() {
    return this.state === State.ENABLED && this.get(0x6060) === CYCLIC_POSITION;
  }

  obey(word) {
    const rising = word & ~this.word;
    this.word = word;
    this.become(this.after(word, rising));
    if ((word & 0x10) === 0) this.acknowledges = false;
    if (this.is_cyclic()) {
      this.target = this.get(0x607a);
      this.jump = Math.max(this.jump, Math.abs(this.target - this.position));
    }
    if (this.state === State.ENABLED && this.get(0x6060) === PROFILE_POSITION && rising & 0x10) {
      this.target = this.get(0x607a);
      this.acknowledges = true;
    }
  }

  after(word, rising) {
    const { DISABLED, READY, ON, ENABLED, QUICK_STOP, FAULT } = State;
    if (this.state === FAULT) return rising & 0x80 ? DISABLED : FAULT; // 15
    if ((word & 0x02) === 0) return DISABLED; // 7, 9, 10, 12
    if ((word & 0x06) === 0x02) return this.state === ENABLED ? QUICK_STOP : DISABLED; // 11
    if ((word & 0x07) === 0x06) return this.state === QUICK_STOP ? QUICK_STOP : READY; // 2, 6, 8
    if ((word & 0x0f) === 0x07) return [READY, ENABLED].includes(this.state) ? ON : this.state; // 3, 5
    return [ON, QUICK_STOP].includes(this.state) ? ENABLED : this.state; // 4, 16
  }

  become(state) {
    if (state === this.state) return;
    this.state = state;
    this.target = this.position;
  }

  /// The master's heartbeat stays away: object 0x6007, 3 is a quick stop.
  loseMaster() {
    if (this.get(0x6007) === 3 && this.state === State.ENABLED) this.become(State.QUICK_STOP);
  }

  reboot() {
    this.state = State.DISABLED;
    this.word = 0;
    this.device.nmt.resetNode();
  }
}

module.exports = { Drive, State };
