// Timers that run on the test's clock: nothing happens but when step() says that time has passed.
'use strict';

class Timer {
  constructor(clock, action, delay, repeats) {
    Object.assign(this, { clock, action, delay: Math.max(1, delay), repeats });
    this.refresh();
  }
  refresh() {
    this.due = this.clock.now + this.delay;
    this.clock.timers.add(this);
    return this;
  }
}

class SteppedTimers {
  now = 0; // milliseconds
  timers = new Set();
  soon = [];

  /// Takes the place of the runtime's own timers: to be called before anything that uses them is loaded.
  install() {
    const start = (repeats) => (action, delay, ...args) => new Timer(this, () => action(...args), delay, repeats);
    const stop = (timer) => void this.timers.delete(timer);
    Object.assign(globalThis, {
      setTimeout: start(false),
      setInterval: start(true),
      clearTimeout: stop,
      clearInterval: stop,
      setImmediate: (action, ...args) => void this.soon.push(() => action(...args)),
    });
  }

  /// Does what was put off, until nothing is.
  settle() {
    while (this.soon.length > 0) this.soon.shift()();
  }

  step(milliseconds) {
    for (const end = this.now + milliseconds; this.now < end; ) {
      this.now += 1;
      for (const timer of [...this.timers].filter((t) => t.due <= this.now)) {
        timer.repeats ? timer.refresh() : this.timers.delete(timer);
        timer.action();
        this.settle();
      }
    }
  }
}

module.exports = { SteppedTimers };
