// One line per check; the process ends with 1 where any failed.

let failed = 0;

export function check(name, good, more = "") {
  if (!good) failed++;
  console.log(`${good ? "ok  " : "FAIL"}  ${name}${more === "" ? "" : `: ${more}`}`);
  return good;
}

/** Runs `act`; what it throws is a failed check. */
export async function section(name, act) {
  try {
    await act();
  } catch (error) {
    check(name, false, error instanceof Error ? error.message.split("\n")[0] : String(error));
  }
}

export async function until(what, within = 15000) {
  const end = Date.now() + within;
  while (Date.now() < end) {
    if (await what()) return true;
    await new Promise((done) => setTimeout(done, 50));
  }
  return false;
}

export function finish() {
  console.log(failed ? `${failed} checks failed` : "all checks passed");
  process.exit(failed ? 1 : 0);
}
