// The samples of a recording, and as few of them as a picture needs.

export type Signal = "sp" | "pv" | "op" | "vp";
const SIGNALS: readonly Signal[] = ["sp", "pv", "op", "vp"];

/** The signals of a loop over the times at which it was sampled; a value that is missing is NaN. */
export interface Samples {
  time: Float64Array;
  signals: Partial<Record<Signal, Float64Array>>;
}

/** Samples from the bytes that the lab sends: count, mask, times, signals. */
export function samplesOf(bytes: ArrayBuffer): Samples {
  const [count = 0, mask = 0] = new Uint32Array(bytes, 0, 2);
  const column = (k: number) => new Float64Array(bytes, 8 + 8 * count * k, count);
  const signals: Samples["signals"] = {};
  let at = 1;
  SIGNALS.forEach((signal, bit) => {
    if (mask & (1 << bit)) signals[signal] = column(at++);
  });
  return { time: column(0), signals };
}

/** The first sample at or after a time. */
export function place(time: Float64Array, t: number): number {
  let low = 0;
  let high = time.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((time[middle] as number) < t) low = middle + 1;
    else high = middle;
  }
  return low;
}

type Column = (number | null)[];

/**
 * What a picture of so many pixels needs of the samples from `from` to `to`: all of them if they are few, else the least and
 * the largest of each pixel, in the order in which they came. So no swing is lost, however long the recording.
 */
export function thinned(samples: Samples, wanted: Signal[], from: number, to: number, pixels: number): [number[], ...Column[]] {
  const { time } = samples;
  const first = Math.max(0, place(time, from) - 1);
  const last = Math.min(time.length, place(time, to) + 2);
  const count = last - first;
  const columns = wanted.map((signal) => samples.signals[signal] as Float64Array);
  const known = (value: number) => (Number.isNaN(value) ? null : value);
  if (count <= 4 * pixels) {
    const x = Array.from(time.subarray(first, last));
    return [x, ...columns.map((column) => Array.from(column.subarray(first, last), known))];
  }
  const per = count / pixels;
  const x: number[] = new Array(2 * pixels);
  const out = columns.map((): Column => new Array(2 * pixels));
  for (let k = 0; k < pixels; k++) {
    const a = first + Math.floor(k * per);
    const b = Math.min(last, first + Math.floor((k + 1) * per));
    x[2 * k] = time[a] as number;
    x[2 * k + 1] = time[(a + b) >> 1] as number;
    for (let c = 0; c < columns.length; c++) {
      const column = columns[c] as Float64Array;
      let low = Infinity;
      let high = -Infinity;
      let lowAt = a;
      let highAt = a;
      for (let i = a; i < b; i++) {
        const value = column[i] as number;
        if (value < low) (low = value), (lowAt = i);
        if (value > high) (high = value), (highAt = i);
      }
      const o = out[c] as Column;
      if (low > high) {
        o[2 * k] = o[2 * k + 1] = null;
      } else {
        o[2 * k] = lowAt <= highAt ? low : high;
        o[2 * k + 1] = lowAt <= highAt ? high : low;
      }
    }
  }
  return [x, ...out];
}

/** The time between most samples. */
export function step(samples: Samples): number {
  const { time } = samples;
  const n = time.length;
  if (n < 2) return 1;
  const some: number[] = [];
  const stride = Math.max(1, Math.floor(n / 200));
  for (let i = 1; i < n; i += stride) some.push((time[i] as number) - (time[i - 1] as number));
  some.sort((a, b) => a - b);
  return some[some.length >> 1] || 1;
}

/** A number as one reads it. */
export function short(value: number, digits = 4): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const text = Math.abs(value) >= 1e-4 && Math.abs(value) < 1e7 ? String(Number(value.toPrecision(digits))) : value.toExponential(2);
  return text.replace("-", "\u2212");
}

/** A duration as people say it. */
export function lasting(seconds: number): string {
  const s = Math.abs(seconds);
  if (s < 120) return `${short(s, 3)}\u00a0s`;
  if (s < 7200) return `${short(s / 60, 3)}\u00a0min`;
  if (s < 172800) return `${short(s / 3600, 3)}\u00a0h`;
  return `${short(s / 86400, 3)}\u00a0d`;
}

/** The clock of a recording: dates where they are known, else the time since its beginning. */
export class Clock {
  /** What is added to a time of the recording to have what the plant's clock shows. */
  readonly origin: number;

  constructor(
    readonly start: number | null,
    offset: number,
    readonly name: string,
  ) {
    this.origin = start === null ? 0 : start + offset;
  }

  get dated(): boolean {
    return this.start !== null;
  }

  /** A moment, to the second or better. */
  moment(t: number, fine = false): string {
    if (!this.dated) return lasting(t);
    const text = new Date((t + this.origin) * 1000).toISOString().replace("T", " ");
    return fine ? text.slice(0, 23) : text.slice(0, 19);
  }

  /** From one moment to another, without a day that is the same. */
  span(from: number, to: number): string {
    const [a, b] = [this.moment(from), this.moment(to)];
    return this.dated && a.slice(0, 10) === b.slice(0, 10) ? `${a} – ${b.slice(11)}` : `${a} – ${b}`;
  }
}
