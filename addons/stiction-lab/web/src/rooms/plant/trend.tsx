// The samples of a day, from the plant's files: SP and PV, and OP, on one time axis.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import uPlot from "uplot";
import { call, type Answer } from "../../api";
import { axis, Chart, line } from "../../chart";
import { t } from "../../texts";

const w = t.plant;
type Trend = Answer<"plant/trend">;
const HELD: uPlot.Series = uPlot.paths.stepped ? { paths: uPlot.paths.stepped({ align: 1 }) } : {};
type Part = [number, number] | null;

/** Several signals on one clock, that of the plant. */
function joined(of: Trend, names: readonly ("sp" | "pv" | "op" | "vp")[]): uPlot.AlignedData {
  const tables = names.map((name): uPlot.AlignedData => {
    const signal = of[name];
    return [(signal?.t ?? []).map((at) => of.clock + at), signal?.value ?? []];
  });
  return tables.length === 1 && tables[0] ? tables[0] : uPlot.join(tables);
}

/** What the clock of the plant shows: hours and minutes, with seconds where they count; the day where it begins. */
function clock(at: number, next: number, before: number): string {
  const text = new Date(at * 1000).toISOString();
  const time = text.slice(11, Math.abs((next || before) - at) < 60 ? 19 : 16);
  return before === 0 || time.startsWith("00:00") ? `${time}\n${text.slice(5, 10)}` : time;
}

export function TrendOfDay(props: { loop: string; day: string; days: number; stamp: string }) {
  const [part, setPart] = useState<Part>(null);
  const [trend, setTrend] = useState<Trend | null>(null);
  const [wrong, setWrong] = useState("");
  const key = `${props.loop} ${props.day} ${props.days}`;
  const shown = useRef(key);
  if (shown.current !== key) {
    shown.current = key;
    setPart(null);
    setTrend(null);
  }
  useEffect(() => {
    const stop = new AbortController();
    setWrong("");
    const asked = { loop: props.loop, day: props.day, days: props.days, ...(part ? { from_s: part[0], to_s: part[1] } : {}) };
    call("plant/trend", asked, stop.signal).then(setTrend, (error: Error) => {
      if (!stop.signal.aborted) setWrong(error.message);
    });
    return () => stop.abort();
  }, [key, part]);
  // Charts are made once; what they do when dragged over is of now.
  const zoom = useRef<(from: number, to: number) => void>(() => {});
  zoom.current = (from, to) => {
    if (trend && to - from > 5) setPart([from - trend.clock, to - trend.clock]);
  };
  const names = useMemo(() => {
    if (!trend) return null;
    const all = (["pv", "sp", "op", "vp"] as const).filter((name) => (trend[name]?.t.length ?? 0) > 0);
    return { above: all.filter((name) => name === "sp" || name === "pv"), below: all.filter((name) => name === "op" || name === "vp") };
  }, [trend]);
  if (wrong) return <p class="wrong">{wrong}</p>;
  if (!trend || !names) return <p role="status">{w.loop.reading}</p>;
  const length = props.days * 86_400;
  const [from, to] = part ?? [0, length];
  const move = (a: number, b: number) => {
    const wide = Math.min(length, Math.max(30, b - a));
    const begin = Math.max(0, Math.min(length - wide, a));
    setPart(wide >= length - 1 ? null : [begin, begin + wide]);
  };
  const options = (of: readonly ("sp" | "pv" | "op" | "vp")[], unit: string): Omit<uPlot.Options, "width" | "height"> => ({
    tzDate: (at) => uPlot.tzDate(new Date(at * 1e3), "Etc/UTC"),
    cursor: { sync: { key: "plant-trend" }, drag: { x: true, y: false, setScale: false } },
    scales: { x: { time: true } },
    axes: [axis({ values: (_, at) => at.map((time, k) => clock(time, at[k + 1] ?? 0, at[k - 1] ?? 0)) }), axis({ label: unit, size: 56 })],
    series: [
      {},
      // What a controller sends is held until it sends something else.
      ...of.map((name) => line(name, t.signals[name], name === "pv" || name === "vp" ? {} : HELD)),
    ],
    hooks: {
      setSelect: [
        (plot) => {
          const { left, width } = plot.select;
          if (width < 4) return;
          zoom.current(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
          plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        },
      ],
    },
  });
  const most = Math.max(...(["sp", "pv", "op", "vp"] as const).map((name) => trend[name]?.samples ?? 0));
  const thinned = (["sp", "pv", "op", "vp"] as const).some((name) => trend[name]?.thinned);
  return (
    <div class="trend">
      <div class="row zoom">
        <button type="button" onClick={() => move(from + (to - from) / 4, to - (to - from) / 4)}>
          {w.loop.zoom.in}
        </button>
        <button type="button" disabled={!part} onClick={() => move(from - (to - from) / 2, to + (to - from) / 2)}>
          {w.loop.zoom.out}
        </button>
        <button type="button" disabled={from <= 0} onClick={() => move(from - (to - from) / 2, to - (to - from) / 2)}>
          {w.loop.zoom.back}
        </button>
        <button type="button" disabled={to >= length} onClick={() => move(from + (to - from) / 2, to + (to - from) / 2)}>
          {w.loop.zoom.on}
        </button>
        <button type="button" disabled={!part} onClick={() => setPart(null)}>
          {w.loop.zoom.all}
        </button>
        <span class="soft">{w.loop.zoomHint}</span>
      </div>
      {names.above.length > 0 ? (
        <Chart
          key={`${key} ${names.above.join()}`}
          label={w.loop.trendLabel(props.loop, props.day)}
          height={190}
          options={options(names.above, trend.pv_unit ?? t.signals.pv)}
          data={joined(trend, names.above)}
        />
      ) : null}
      {names.below.length > 0 ? (
        <Chart
          key={`${key} ${names.below.join()} below`}
          label={w.loop.opLabel(props.loop, props.day)}
          height={150}
          options={options(names.below, `${t.signals.op}, ${t.units.percent}`)}
          data={joined(trend, names.below)}
        />
      ) : null}
      <p class="soft">{thinned ? w.loop.thinned(most) : w.loop.whole(most)}</p>
    </div>
  );
}
