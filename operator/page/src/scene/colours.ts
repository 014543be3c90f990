// Scales that people with any kind of colour vision can read (viridis), and the page's own colours as the style
// sheet has them.
const kViridis = [
  [68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99],
  [170, 220, 50], [253, 231, 37],
] as const;

/** 0 to 1 -> red, green, blue, each 0 to 1. */
export function viridis(share: number): [number, number, number] {
  const at = Math.min(Math.max(share, 0), 1) * (kViridis.length - 1);
  const low = kViridis[Math.floor(at)]!;
  const high = kViridis[Math.min(Math.floor(at) + 1, kViridis.length - 1)]!;
  const part = at - Math.floor(at);
  return [0, 1, 2].map((i) => (low[i]! + part * (high[i]! - low[i]!)) / 255) as [number, number, number];
}

/** From fine to coarse: 1 is at 2 mm or less, 0 at 50 mm or more, on a logarithmic scale. */
export const kFinest = 0.002;
export const kCoarsest = 0.05;
export function precision(sigma: number): number {
  return 1 - Math.log(sigma / kFinest) / Math.log(kCoarsest / kFinest);
}

export function css(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
