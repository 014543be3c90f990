// Numbers as people read them, with their units.

export function metres(value: number): string {
  return `${value.toFixed(2)} m`;
}

export function millimetres(value: number): string {
  const mm = value * 1000;
  return `${mm < 10 ? mm.toFixed(1) : mm.toFixed(0)} mm`;
}

export function degrees(radians: number): string {
  return `${((radians * 180) / Math.PI).toFixed(0)}°`;
}

export function place(x: number, y: number): string {
  return `${x.toFixed(2)}, ${y.toFixed(2)} m`;
}

export function seconds(value: number): string {
  if (value < 60) return `${value.toFixed(0)} s`;
  return `${Math.floor(value / 60)} min ${Math.round(value % 60)} s`;
}

export function milliseconds(value: number): string {
  return value < 10 ? `${value.toFixed(1)} ms` : `${value.toFixed(0)} ms`;
}

/** Of data, from milliseconds. */
export function age(ms: number): string {
  if (!Number.isFinite(ms)) return "no data";
  if (ms < 9950) return `${(ms / 1000).toFixed(1)} s`;
  if (ms < 120e3) return `${(ms / 1000).toFixed(0)} s`;
  return `${(ms / 60e3).toFixed(0)} min`;
}

/** How much a recording holds, and what it lacks. */
export function recorded(of: { record_mib: number; record_dropped: number }): string {
  const { record_mib: mib, record_dropped: missed } = of;
  return `${mib.toFixed(1)} MiB${missed > 0 ? ` · ${missed} missed` : ""}`;
}

const kTwoPi = 2 * Math.PI;
export function wrapAngle(angle: number): number {
  return angle - kTwoPi * Math.round(angle / kTwoPi);
}
