// Work is done once per picture that the browser shows, and only when something has changed.

const due = new Set<() => void>();
let asked = false;

function run(): void {
  asked = false;
  const work = [...due];
  due.clear();
  for (const task of work) task();
}

/** Runs `task` with the next picture; asked for twice, it runs once. */
export function beforeNextFrame(task: () => void): void {
  due.add(task);
  if (asked) return;
  asked = true;
  requestAnimationFrame(run);
}
