// Learn the test: a valve with hidden S and J, turned by hand; then what the test says, and the truth.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { go, remember, state } from "../address";
import { call } from "../api";
import { Hand } from "../exercise/hand";
import { Reading, type Read, type Truth } from "../exercise/reading";
import { Run } from "../exercise/run";
import { Trend } from "../exercise/trend";
import { t } from "../texts";
import "./exercise.css";

const w = t.exercise;
/** How much of the trend may be shown, s. */
const WINDOWS = [180, 600, Infinity];

function chance(): number {
  return 1 + Math.floor(Math.random() * 9999);
}

export function Exercise() {
  const kept = useRef<Run | null>(null);
  kept.current ??= new Run();
  const run = kept.current;
  const seed = useSignal<number | null>(null);
  const playing = useSignal(true);
  const window_ = useSignal(180);
  const guess = useSignal("");
  const read = useSignal<Read | null>(null);
  const truth = useSignal<Truth | null>(null);
  const wrong = useSignal("");
  const busy = useSignal(false);

  useEffect(() => {
    const x = Number(state.value.get("seed") ?? NaN);
    seed.value = Number.isInteger(x) && x >= 0 && x < 2 ** 31 ? x : chance();
  }, [state.value]);
  const begin = () => {
    if (seed.value === null) return;
    forget();
    guess.value = "";
    playing.value = true;
    window_.value = 180;
    remember([["seed", String(seed.value)]]);
    void run.begin(seed.value);
  };
  useEffect(begin, [seed.value]);
  useEffect(() => () => run.end(), []);

  /** What was read is of other turns. */
  const forget = () => {
    read.value = truth.value = null;
    wrong.value = "";
  };
  const ask = async <T,>(asked: Promise<T>, then: (got: T) => void) => {
    const sets = run.sets.value;
    busy.value = true;
    try {
      const got = await asked;
      if (sets === run.sets.value) then(got);
    } catch (error) {
      if (sets === run.sets.value) wrong.value = (error as Error).message;
    }
    busy.value = false;
  };
  const reads = () => {
    playing.value = false;
    window_.value = Infinity;
    wrong.value = "";
    const at = run.until.value;
    void ask(call("exercise/read", run.done()), (of) => (read.value = { of, at }));
  };
  const byLab = () => {
    forget();
    playing.value = false;
    window_.value = Infinity;
    void run.carryOut();
  };

  const plan = run.before.value?.plan;
  const said = guess.value === "" ? null : Number(guess.value);
  return (
    <div class="exercise-room">
      <div class="row exercise-head">
        <h1>{w.title}</h1>
        <p class="row">
          <label>
            {w.seed}{" "}
            <input type="number" min="0" value={seed.value ?? ""} onChange={(event) => go("exercise", [["seed", event.currentTarget.value]])} />
          </label>
          <button onClick={() => go("exercise", [["seed", String(chance())]])}>{w.next}</button>
          <button onClick={begin}>{w.again}</button>
        </p>
      </div>
      <p class="soft">{w.intro}</p>
      {(run.wrong.value || wrong.value) && (
        <p class="wrong" role="alert">
          {run.wrong.value || wrong.value}
        </p>
      )}
      <div class="exercise">
        <div class="grid">
          <Trend kept={run.kept.value} vp={truth.value?.vp ?? null} window={window_.value} />
          <label>
            {w.shown}{" "}
            <select value={String(window_.value)} onChange={(event) => (window_.value = Number(event.currentTarget.value))}>
              {WINDOWS.map((each) => (
                <option key={each} value={String(each)}>
                  {w.window(each)}
                </option>
              ))}
            </select>
          </label>
          <Hand run={run} playing={playing} turned={forget} />
        </div>
        <div class="grid">
          <section class="card">
            <h2>{w.how}</h2>
            <ol>
              {w.steps.map((each) => (
                <li key={each}>{each}</li>
              ))}
            </ol>
            {plan && (
              <details>
                <summary>{w.plan}</summary>
                <ol>
                  {plan.instructions.map((each) => (
                    <li key={each}>{each}</li>
                  ))}
                </ol>
                <table>
                  <thead>
                    <tr>
                      <th scope="col">{w.turn}</th>
                      <th scope="col">{w.hold}</th>
                    </tr>
                  </thead>
                  <tbody>
                    {plan.grow
                      .filter((_, k) => k % 2 === 0)
                      .map(({ op, hold_s }) => (
                        <tr key={op}>
                          <td>u0 ± {Math.abs(op)} %</td>
                          <td>{hold_s} s</td>
                        </tr>
                      ))}
                  </tbody>
                </table>
              </details>
            )}
          </section>
          <section class="card" aria-label={w.end}>
            <p>
              <label>
                {w.guess}{" "}
                <input type="number" min="0" max="100" step="any" value={guess.value} onInput={(event) => (guess.value = event.currentTarget.value)} /> %
              </label>
            </p>
            <p class="row">
              <button class="main" disabled={run.sets.value.length === 0 || busy.value} onClick={reads}>
                {busy.value ? w.wait : w.read}
              </button>
              <button disabled={!plan} onClick={byLab}>
                {w.byLab}
              </button>
            </p>
            <p class="soft">{w.byLabHint}</p>
          </section>
          {read.value && (
            <Reading
              read={read.value}
              guess={said}
              truth={truth.value}
              reveal={() => void ask(call("exercise/reveal", run.done()), (got) => (truth.value = got))}
            />
          )}
        </div>
      </div>
    </div>
  );
}
