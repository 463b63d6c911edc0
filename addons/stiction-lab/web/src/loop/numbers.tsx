// The cycle in numbers: predicted exactly and by describing function, and measured in the trend.
import type { Answer } from "../api";
import { t } from "../texts";
import type { Engine } from "./engine";
import { compensator, stem } from "./knobs";

/** Period and half peak-to-peak values of the last part of the trend. */
export interface Measured {
  period: number | null;
  pv: number;
  op: number;
  vp: number;
}

/** How much the two halves of a settled trend may differ. */
const SETTLED = 0.25;

function halfPp(of: number[], from: number, end: number): number {
  let [low, high] = [Infinity, -Infinity];
  for (let k = from; k < end; k++) {
    const x = of[k] as number;
    if (x < low) low = x;
    if (x > high) high = x;
  }
  return high > low ? (high - low) / 2 : 0;
}

/** Measures the last `window` seconds that are shown; null until they hold no start-up and no change of settings. */
export function measure(engine: Engine, window: number): Measured | null {
  const { op, pv, vp } = engine.kept;
  const [from, end] = engine.shown(window);
  const middle = Math.floor((from + end) / 2);
  const changes = (of: number[]) => {
    const [a, b] = [halfPp(of, from, middle), halfPp(of, middle, end)];
    return Math.abs(a - b) > SETTLED * Math.max(a, b);
  };
  if ((end - from) * engine.dt < window || changes(op) || changes(pv)) return null;
  const swing = halfPp(op, from, end);
  const crossings: number[] = [];
  if (swing > 0) {
    const mean = op.slice(from, end).reduce((a, b) => a + b, 0) / (end - from);
    let above: boolean | null = null;
    for (let k = from; k < end; k++) {
      const x = (op[k] as number) - mean;
      // Noise about the mean is no crossing.
      if (Math.abs(x) < 0.3 * swing) continue;
      if (x > 0 && above === false) crossings.push(k);
      above = x > 0;
    }
  }
  const [first, last] = [crossings[0], crossings[crossings.length - 1]];
  const period =
    crossings.length > 1 && first !== undefined && last !== undefined
      ? ((last - first) / (crossings.length - 1)) * engine.dt
      : null;
  return { period, op: swing, pv: halfPp(pv, from, end), vp: halfPp(vp, from, end) };
}

function digits(x: number | null | undefined): string {
  return x === null || x === undefined || !Number.isFinite(x) ? "–" : String(Number(x.toPrecision(3)));
}

export function Numbers(props: { cycles: Answer<"cycle"> | null; measured: Measured | null; wrong: string }) {
  const { cycles, measured } = props;
  const by = (method: string) => cycles?.cycles.find((each) => each.method === method && each.stable) ?? cycles?.cycles.find((each) => each.method === method);
  const [exact, describing] = [by("exact"), by("describing function")];
  const rows = [
    // Without a cycle it would be the period of the noise.
    [t.loop.period, exact?.period_s, describing?.period_s, exact || describing ? measured?.period : null],
    [t.loop.swing.pv, exact?.half_pp.pv, describing?.half_pp.pv, measured?.pv],
    [t.loop.swing.op, exact?.half_pp.op, describing?.half_pp.op, measured?.op],
    [t.loop.swing.vp, exact?.half_pp.vp, describing?.half_pp.vp, measured?.vp],
  ] as const;
  const why = cycles?.methods.filter((found) => !by(found.method)).flatMap((found) => found.notes.slice(0, 1).map((note) => `${found.method}: ${note}`)) ?? [];
  // "The loop is stable" is true of sines only.
  const notes = exact?.stable && !describing ? [t.loop.sines] : why;
  return (
    <section class="card numbers" aria-live="off">
      <h2>{t.loop.cycle}</h2>
      <table>
        <thead>
          <tr>
            <td />
            <th class="number" scope="col">{t.loop.exact}</th>
            <th class="number" scope="col">{t.loop.describing}</th>
            <th class="number" scope="col">{t.loop.trend}</th>
          </tr>
        </thead>
        <tbody>
          {rows.map(([name, a, b, c]) => (
            <tr key={name}>
              <th scope="row">{name}</th>
              <td class="number">{digits(a)}</td>
              <td class="number">{digits(b)}</td>
              <td class="number">{digits(c)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {(stem.value || compensator.value) && <p class="soft">{t.loop.predictedOf}</p>}
      {!measured && <p class="soft">{t.loop.unsettled}</p>}
      {props.wrong ? <p class="wrong">{props.wrong}</p> : notes.map((each) => <p key={each} class="soft">{each}</p>)}
    </section>
  );
}
