// The loop that runs: it asks the server for samples a little ahead of what is shown, and keeps what was.
import { signal } from "@preact/signals";
import { call, Wrong, type Ask } from "../api";

/** Samples that are kept. */
const KEPT = 60_000;
/** So much real time is asked for ahead, s. */
const AHEAD = 0.25;

export interface Kept {
  t: number[];
  sp: number[];
  pv: number[];
  op: number[];
  signal: number[];
  vp: number[];
}

function empty(): Kept {
  return { t: [], sp: [], pv: [], op: [], signal: [], vp: [] };
}

export class Engine {
  readonly playing = signal(true);
  readonly speed = signal(5);
  readonly wrong = signal("");
  /** Samples, from some time on; at equal distances. */
  kept = empty();
  /** The time that is shown, s. */
  clock = 0;
  /** Time between samples, s. */
  dt = 1;
  private id = 0;
  private next = 0;
  private busy = false;
  private generation = 0;
  /** The scenario that was begun. */
  private scenario = "";

  /** The settings of the moment. */
  constructor(private readonly knobs: () => Ask<"live/begin">) {}

  /** Begins at rest. */
  async begin(): Promise<void> {
    const generation = ++this.generation;
    this.busy = true;
    try {
      const knobs = this.knobs();
      const begun = await call("live/begin", knobs);
      if (generation !== this.generation) return;
      this.scenario = knobs.loop.scenario;
      this.kept = empty();
      this.clock = 0;
      this.next = 0;
      this.id = begun.id;
      this.dt = begun.sample_time_s;
      this.wrong.value = "";
    } catch (error) {
      if (generation === this.generation) this.wrong.value = (error as Error).message;
    } finally {
      if (generation === this.generation) this.busy = false;
    }
  }

  end(): void {
    this.generation++;
    this.id = 0;
  }

  /** Goes on by so much real time, s. */
  tick(passed: number): void {
    if (!this.playing.value || this.id === 0) return;
    const until = Math.max(0, (this.next - 1) * this.dt);
    this.clock = Math.min(until, this.clock + Math.min(passed, 0.1) * this.speed.value);
    // Some samples are shown at once, for a first look.
    const wanted = this.clock + Math.max(this.speed.value * AHEAD, 2 * this.dt);
    if (!this.busy && (this.next - 1) * this.dt < wanted) void this.more(wanted);
  }

  private async more(until: number): Promise<void> {
    const generation = this.generation;
    // Another scenario is about to begin.
    if (this.knobs().loop.scenario !== this.scenario) return;
    const samples = Math.min(20_000, Math.max(1, Math.ceil(until / this.dt) - this.next + 1));
    this.busy = true;
    try {
      const ask = { id: this.id, from: this.next, samples, knobs: this.knobs() };
      const got = await call("live/go", ask).catch((error: unknown) => {
        // An answer that was lost on the way is there a second time.
        if (error instanceof Wrong && error.status === 0) return call("live/go", ask);
        throw error;
      });
      if (generation !== this.generation) return;
      const { kept } = this;
      for (let k = 0; k < got.op.length; k++) kept.t.push((got.from + k) * this.dt);
      for (const name of ["sp", "pv", "op", "signal", "vp"] as const) kept[name].push(...got[name]);
      this.next = got.from + got.op.length;
      if (kept.t.length > 2 * KEPT) for (const all of Object.values(kept) as number[][]) all.splice(0, KEPT);
      this.wrong.value = "";
    } catch (error) {
      if (generation !== this.generation) return;
      const wrong = error as Wrong;
      this.wrong.value = wrong.message;
      // A server that was started anew knows nothing of it.
      if (wrong.status === 404) {
        await new Promise((done) => setTimeout(done, 500));
        if (generation === this.generation) void this.begin();
        return;
      }
      await new Promise((done) => setTimeout(done, 400));
    } finally {
      if (generation === this.generation) this.busy = false;
    }
  }

  /** The place of the sample that is shown now. */
  now(): number {
    const first = this.kept.t[0] ?? 0;
    return Math.min(this.kept.t.length - 1, Math.max(0, Math.floor((this.clock - first) / this.dt + 1e-9)));
  }

  /** From where to where the samples of the last `window` seconds are. */
  shown(window: number): [number, number] {
    const end = this.now() + 1;
    return [Math.max(0, end - Math.ceil(window / this.dt) - 1), end];
  }
}
