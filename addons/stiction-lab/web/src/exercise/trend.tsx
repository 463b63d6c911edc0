// The trend of the exercise: PV above, OP below, and the valve position once the truth is shown.
import { useMemo } from "preact/hooks";
import uPlot from "uplot";
import { axis, Chart, clock, line, ROUND } from "../chart";
import { t } from "../texts";
import type { Kept } from "./run";

function Plot(props: { label: string; unit: string; names: ("pv" | "op" | "vp")[]; data: uPlot.AlignedData }) {
  const options = {
    legend: { show: true, live: false },
    cursor: { drag: { x: true, y: false }, sync: { key: "exercise" } },
    scales: { x: { time: false } },
    axes: [axis({ values: (_: uPlot, all: number[]) => all.map(clock), incrs: ROUND }), axis({ label: props.unit, size: 52 })],
    series: [{}, ...props.names.map((each) => line(each, each.toUpperCase()))],
  };
  return <Chart key={props.names.join()} label={props.label} height={210} options={options} data={props.data} />;
}

export function Trend(props: { kept: Kept; vp: number[] | null; window: number }) {
  const { kept, vp } = props;
  const { time, pv, op, position } = useMemo(() => {
    const end = kept.op.length;
    const from = Math.max(0, end - Math.ceil(props.window / kept.dt));
    const part = (of: number[]) => of.slice(from, end);
    return {
      time: Array.from({ length: end - from }, (_, k) => (from + k) * kept.dt),
      pv: part(kept.pv),
      op: part(kept.op),
      // What ran after the truth was shown has no position.
      position: vp && Array.from({ length: end - from }, (_, k) => vp[from + k] ?? null),
    };
  }, [kept, vp, props.window]);
  const above = useMemo<uPlot.AlignedData>(() => [time, pv], [time]);
  const below = useMemo<uPlot.AlignedData>(() => (position ? [time, op, position] : [time, op]), [time]);
  return (
    <div class="grid">
      <Plot label={t.exercise.pvLabel} unit="PV, %" names={["pv"]} data={above} />
      <Plot label={t.exercise.opLabel} unit={t.loop.percentAxis} names={position ? ["op", "vp"] : ["op"]} data={below} />
    </div>
  );
}
