// The buttons that put the loop in manual, turn its OP, and let time go on.
import { useSignal, type Signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { clock } from "../chart";
import { t } from "../texts";
import type { Run } from "./run";

const w = t.exercise;
const SPEEDS = [1, 2, 5, 10, 20];
/** So often the loop that runs asks for more, ms. */
const EVERY = 250;
/** From one size of growing turns to the next, and of shrinking ones. */
const [LARGER, SMALLER] = [1.6, 0.85];

function two(x: number): number {
  return Math.round(100 * x) / 100;
}

export function Hand(props: { run: Run; playing: Signal<boolean>; turned: () => void }) {
  const { run, playing } = props;
  const speed = useSignal(5);
  /** The OP about which the turns go, %. */
  const rest = useSignal<number | null>(null);
  const size = useSignal(0.4);
  const manual = run.manual();
  const most = run.before.value?.longest_s ?? 0;
  const over = most > 0 && run.until.value >= most;

  useEffect(() => {
    const timer = setInterval(() => {
      if (playing.value && !run.busy && run.before.peek()) void run.goTo(run.until.peek() + (speed.peek() * EVERY) / 1000);
    }, EVERY);
    return () => clearInterval(timer);
  }, []);
  // Another valve, or a test by the lab, begins at another OP.
  useEffect(() => {
    if (manual === null) rest.value = null;
  }, [manual]);

  const set = (op: number | null) => {
    run.set(op === null ? null : two(Math.max(0, Math.min(100, op))));
    props.turned();
  };
  const begin = () => {
    const now = run.kept.value.op.at(-1);
    if (now === undefined) return;
    rest.value = Math.round(10 * now) / 10;
    set(rest.value);
  };
  const other = () => {
    if (manual === null) return;
    const about = rest.value ?? manual;
    set(about + ((manual > about + 0.001 ? -1 : 1) * size.value) / 2);
  };
  const by = (way: number) => manual !== null && set(manual + way * size.value);
  const sized = (to: number) => (size.value = Math.max(0.05, Math.min(50, two(to))));
  const turns = run.sets.value.filter((each) => each.op !== null).length;
  return (
    <section class="card hand" aria-label={w.hand}>
      <p class="row">
        <button class={manual === null ? "main" : undefined} disabled={over || run.kept.value.op.length === 0} onClick={() => (manual === null ? begin() : set(null))}>
          {manual === null ? w.toManual : w.toAutomatic}
        </button>
        <output>{manual === null ? w.automatic : w.manual(manual, rest.value)}</output>
      </p>
      <div class="row">
        <label>
          {w.size}{" "}
          <input type="number" min="0.05" max="50" step="any" value={size.value} onChange={(event) => sized(Number(event.currentTarget.value) || size.value)} /> %
        </label>
        <button onClick={() => sized(size.value * LARGER)}>{w.larger}</button>
        <button onClick={() => sized(size.value * SMALLER)}>{w.smaller}</button>
      </div>
      <p class="row">
        <button class={manual === null ? undefined : "main"} disabled={manual === null || over} onClick={other}>
          {w.other}
        </button>
        <button disabled={manual === null || over} onClick={() => by(1)}>
          {w.up}
        </button>
        <button disabled={manual === null || over} onClick={() => by(-1)}>
          {w.down}
        </button>
      </p>
      <div class="row">
        <button disabled={over} onClick={() => (playing.value = !playing.value)}>
          {playing.value ? t.loop.pause : t.loop.play}
        </button>
        <label>
          {t.loop.speed}{" "}
          <select value={String(speed.value)} onChange={(event) => (speed.value = Number(event.currentTarget.value))}>
            {SPEEDS.map((each) => (
              <option key={each} value={String(each)}>
                {each}×
              </option>
            ))}
          </select>
        </label>
        {[10, 30].map((seconds) => (
          <button key={seconds} disabled={over} onClick={() => void run.goTo(run.until.value + seconds)}>
            {w.goOn(seconds)}
          </button>
        ))}
        <span class="soft">{w.at(clock(run.until.value), turns)}</span>
      </div>
      {over && <p role="status">{w.over(clock(most))}</p>}
    </section>
  );
}
