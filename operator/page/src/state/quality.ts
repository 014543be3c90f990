// What the link is like: round trip, messages that never came, and how much comes.

const kWindowMs = 10e3;

export class Quality {
  roundTripMs = NaN;
  private readonly messages: { at: number; bytes: number }[] = [];
  private readonly gaps: { at: number; missed: number; all: number }[] = [];
  private lastNumber: number | null = null;

  took(bytes: number): void {
    this.messages.push({ at: performance.now(), bytes });
    trim(this.messages);
  }

  /** Status messages are numbered one by one: a number left out is a message that the server dropped for this page. */
  numbered(number: number): void {
    const all = this.lastNumber === null || number <= this.lastNumber ? 1 : number - this.lastNumber;
    this.gaps.push({ at: performance.now(), missed: all - 1, all });
    this.lastNumber = number;
    trim(this.gaps);
  }

  answered(ms: number): void {
    this.roundTripMs = ms;
  }

  forget(): void {
    this.roundTripMs = NaN;
    this.lastNumber = null;
  }

  /** 0 to 1, of the last seconds. */
  get dropped(): number {
    const all = sum(this.gaps, (gap) => gap.all);
    return all > 0 ? sum(this.gaps, (gap) => gap.missed) / all : 0;
  }

  get bytesPerSecond(): number {
    trim(this.messages);
    return (sum(this.messages, (message) => message.bytes) * 1000) / kWindowMs;
  }
}

function sum<T>(list: T[], value: (of: T) => number): number {
  return list.reduce((total, item) => total + value(item), 0);
}

function trim(list: { at: number }[]): void {
  const from = performance.now() - kWindowMs;
  const keep = list.findIndex((item) => item.at >= from);
  list.splice(0, keep < 0 ? list.length : keep);
}
