// Guess the fault: trends only, then the truth. A seed makes the same loops for a whole class.
import { useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import uPlot from "uplot";
import { go, remember, state } from "../address";
import { call, type Answer } from "../api";
import { axis, Chart, clock, line, ROUND } from "../chart";
import { Short } from "../loop/verdict";
import { t } from "../texts";
import "./guess.css";
import { Sketch } from "./kinds";

const LOOPS = 20;

type Trends = Answer<"guess/trends">;
type Revealed = Answer<"guess/reveal">;

/** Signals on a common time line; where one has no sample there is none. */
function joined(trends: { time: number[]; values: (number | null)[] }[]): uPlot.AlignedData {
  return trends.length === 0 ? [[]] : uPlot.join(trends.map((each) => [each.time, each.values] as uPlot.AlignedData));
}

/** Signals of a loop over time; with `read`, the legend shows the values under the pointer. */
export function Plot(props: { label: string; unit: string; of: Trends["signals"]; names: ("SP" | "PV" | "OP" | "VP")[]; read?: string }) {
  const found = props.names.flatMap((name) => props.of.filter((each) => each.name === name));
  const data = useMemo(() => joined(found), [props.of]);
  const options = {
    legend: { show: true, live: props.read !== undefined },
    cursor: { drag: { x: true, y: false }, sync: { key: props.read ?? "guess" } },
    scales: { x: { time: false } },
    axes: [axis({ values: (_, all) => all.map(clock), incrs: ROUND }), axis({ label: props.unit, size: 52 })],
    series: [{ label: t.guess.time, value: (_: uPlot, x: number | null) => (x == null ? "–" : clock(x)) }, ...found.map((each) => line(each.name.toLowerCase() as "sp", each.name, { spanGaps: true }))],
  };
  return <Chart key={found.map((each) => each.name).join()} label={props.label} height={220} options={options} data={data} />;
}

export function Guess() {
  const seed = useSignal(1);
  const number = useSignal(0);
  const trends = useSignal<Trends | null>(null);
  const revealed = useSignal<Revealed | null>(null);
  const said = useSignal("");
  const wrong = useSignal("");
  const scores = useSignal<Readonly<Record<number, number>>>({});

  useEffect(() => {
    const of = (name: string, otherwise: number) => {
      const x = Number(state.value.get(name) ?? otherwise);
      return Number.isInteger(x) && x >= 0 && x < 2 ** 31 ? x : otherwise;
    };
    const next = of("seed", 1);
    if (next !== seed.value) scores.value = {};
    seed.value = next;
    number.value = Math.max(0, Math.min(LOOPS - 1, of("loop", 1) - 1));
  }, [state.value]);
  useEffect(() => {
    remember([
      ["seed", String(seed.value)],
      ["loop", String(number.value + 1)],
    ]);
    let stays = true;
    trends.value = revealed.value = null;
    said.value = wrong.value = "";
    call("guess/trends", { seed: seed.value, number: number.value }).then(
      (got) => stays && (trends.value = got),
      (error: Error) => stays && (wrong.value = error.message),
    );
    return () => void (stays = false);
  }, [seed.value, number.value]);

  const guess = async (kind: string) => {
    said.value = kind;
    try {
      const truth = await call("guess/reveal", { seed: seed.value, number: number.value });
      // Half a point for knowing whose fault it is.
      const fault = (of: string) => of === "sticky valve" || of === "stuck valve";
      const points = truth.kind === kind ? 1 : fault(truth.kind) === fault(kind) ? 0.5 : 0;
      if (scores.value[number.value] === undefined) scores.value = { ...scores.value, [number.value]: points };
      revealed.value = truth;
    } catch (error) {
      wrong.value = (error as Error).message;
    }
  };

  const all = Object.values(scores.value);
  const truth = revealed.value;
  const words = (kind: string) => t.guess.kinds[kind] ?? { name: kind, why: "" };
  return (
    <>
      <div class="row guess-head">
        <h1>
          {t.guess.title} <span class="soft">{t.guess.count(number.value + 1, LOOPS)}</span>
        </h1>
        <p class="row">
          <strong>{t.guess.score(all.reduce((a, b) => a + b, 0), all.length)}</strong>
          <label>
            {t.guess.seed}{" "}
            <input type="number" min="0" value={seed.value} onChange={(event) => go("guess", [["seed", event.currentTarget.value], ["loop", "1"]])} />
          </label>
        </p>
      </div>
      <p class="soft">{t.guess.intro}</p>
      {wrong.value && <p class="wrong" role="alert">{wrong.value}</p>}
      {trends.value && (
        <div class="guess">
          <div class="grid">
            <Plot key={`a${seed.value}/${number.value}`} label={t.loop.upperLabel} unit="PV, SP" of={trends.value.signals} names={["SP", "PV"]} />
            <Plot
              key={`b${seed.value}/${number.value}/${truth ? 1 : 0}`}
              label={t.loop.lowerLabel}
              unit={t.loop.percentAxis}
              of={truth ? [...trends.value.signals, truth.vp] : trends.value.signals}
              names={["OP", "VP"]}
            />
          </div>
          <div class="grid">
            <div class="card">
              <h2>{t.guess.ask}</h2>
              <p class="soft">{t.guess.sketches}</p>
              <div class="kinds" role="group" aria-label={t.guess.ask}>
                {trends.value.kinds.map((kind) => (
                  <button
                    key={kind}
                    disabled={truth !== null}
                    aria-pressed={said.value === kind}
                    class={truth?.kind === kind ? "truth" : undefined}
                    title={words(kind).why}
                    onClick={() => void guess(kind)}
                  >
                    <Sketch kind={kind} />
                    {words(kind).name}
                  </button>
                ))}
              </div>
            </div>
            {truth && (
              <div class="card" role="status">
                <h2>{truth.kind === said.value ? t.guess.right : t.guess.other(words(truth.kind).name)}</h2>
                <p>{words(truth.kind).why}</p>
                {truth.S != null && truth.J != null && <p>{t.challenges.truth(Number(truth.S.toFixed(1)), Number(truth.J.toFixed(1)))}</p>}
                <h2>{t.loop.verdict}</h2>
                <Short of={truth.judgement} />
                <details>
                  <summary>{t.verdict.why}</summary>
                  <ul>
                    {truth.judgement.diagnosis.verdict.reasons.map((each) => (
                      <li key={each}>{each}</li>
                    ))}
                  </ul>
                </details>
                <button class="main" disabled={number.value + 1 >= LOOPS} onClick={() => number.value++}>
                  {t.guess.next}
                </button>
              </div>
            )}
          </div>
        </div>
      )}
    </>
  );
}
