// The exercise that runs: what was set by hand, until when, and what was recorded. The server simulates it from its start.
import { signal } from "@preact/signals";
import { call, type Answer, type Ask } from "../api";

export type Done = Ask<"exercise/read">;
type Before = Answer<"exercise/begin">;

/** What was recorded so far, sample by sample. */
export interface Kept {
  dt: number;
  op: number[];
  pv: number[];
}

export class Run {
  /** The loop before the test, with its plan. */
  readonly before = signal<Before | null>(null);
  readonly sets = signal<Done["sets"]>([]);
  /** Until when it runs, s. */
  readonly until = signal(0);
  readonly kept = signal<Kept>({ dt: 1, op: [], pv: [] });
  readonly wrong = signal("");
  private seed = 0;
  /** Which beginning this is: what was asked before it is not shown. */
  private generation = 0;
  private queue: Promise<void> = Promise.resolve();
  private waits = 0;

  /** Whether the server is asked for samples. */
  get busy(): boolean {
    return this.waits > 0;
  }

  /** What was done. */
  done(): Done {
    return { seed: this.seed, sets: this.sets.peek(), until_s: this.until.peek() };
  }

  /** The OP that is set by hand; null in automatic. */
  manual(): number | null {
    return this.sets.value.at(-1)?.op ?? null;
  }

  /** Begins with the valve of this seed. */
  begin(seed: number): Promise<void> {
    this.clear(seed);
    this.before.value = null;
    return this.answered(call("exercise/begin", { seed }), (before) => {
      this.before.value = before;
      void this.goTo(before.until_s);
    });
  }

  end(): void {
    this.generation++;
  }

  /** Goes on until a time, s. */
  goTo(time: number): Promise<void> {
    const most = this.before.peek()?.longest_s ?? 0;
    if (this.until.peek() >= most) return Promise.resolve();
    this.until.value = Math.min(time, most);
    const done = this.done();
    // One after the other: each asks for what the one before has not brought.
    const generation = this.generation;
    this.waits++;
    this.queue = this.queue
      .then(() => {
        if (generation !== this.generation) return;
        const from = this.kept.peek().op.length;
        return this.answered(call("exercise/trend", { exercise: done, from }), (got) => {
          const { op, pv } = this.kept.peek();
          this.kept.value = { dt: got.sample_time_s, op: [...op, ...got.op], pv: [...pv, ...got.pv] };
        });
      })
      .finally(() => void this.waits--);
    return this.queue;
  }

  /** Sets the OP from now on; null is automatic. What is set at the same time takes the place of what was. */
  set(op: number | null): void {
    const at_s = this.until.peek();
    const before = this.sets.peek().filter((each) => each.at_s < at_s);
    if (before.length < (this.before.peek()?.most_sets ?? 0)) this.sets.value = [...before, { at_s, op }];
  }

  /** The lab does it, from the beginning. */
  carryOut(): Promise<void> {
    this.clear(this.seed);
    return this.answered(call("exercise/carry-out", { seed: this.seed }), (got) => {
      this.sets.value = got.sets;
      this.until.value = got.until_s;
      const { sample_time_s, op, pv } = got.recorded;
      this.kept.value = { dt: sample_time_s, op, pv };
    });
  }

  private clear(seed: number): void {
    this.generation++;
    this.seed = seed;
    this.sets.value = [];
    this.until.value = 0;
    this.kept.value = { dt: 1, op: [], pv: [] };
    this.wrong.value = "";
  }

  private async answered<T>(asked: Promise<T>, then: (got: T) => void): Promise<void> {
    const generation = this.generation;
    try {
      const got = await asked;
      if (generation === this.generation) then(got);
    } catch (error) {
      if (generation === this.generation) this.wrong.value = (error as Error).message;
    }
  }
}
