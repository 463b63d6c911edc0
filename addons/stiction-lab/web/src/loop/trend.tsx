// The trend that scrolls: PV and SP above, OP and VP below. The line of the SP can be dragged.
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { axis, Chart, clock, line, ROUND } from "../chart";
import { t } from "../texts";
import type { Engine } from "./engine";
import { Steady } from "./phase";

export interface Drawn {
  draw(window: number): void;
  plots: () => uPlot[];
}

function options(series: uPlot.Series[], label: string, steady: Steady, least: () => number, below: boolean): Omit<uPlot.Options, "width" | "height"> {
  return {
    pxAlign: 0,
    legend: { show: false },
    cursor: { show: true, drag: { x: false, y: false }, sync: { key: "loop" } },
    scales: {
      x: { time: false, auto: false },
      y: {
        range: (_, low, high) => {
          if (low === null || high === null) return [0, 1];
          const { low: a, high: b } = steady.of(low, high, least());
          return [a, b];
        },
      },
    },
    axes: [
      axis({ values: (_, all) => all.map(clock), incrs: ROUND, size: below ? 34 : 8, ...(below ? {} : { values: (_: uPlot, all: number[]) => all.map(() => "") }) }),
      axis({ label, size: 52 }),
    ],
    series: [{}, ...series],
  };
}

export function Trend(props: {
  engine: Engine;
  unit: string;
  isLoop: boolean;
  showVp: boolean;
  drawn: (of: Drawn) => void;
  /** The set point is dragged to. */
  drag: (sp: number) => void;
}) {
  const { engine } = props;
  const plots = useRef<[uPlot | null, uPlot | null]>([null, null]);
  const steady = useRef([new Steady(), new Steady()] as const);
  const vp = useRef(props.showVp);
  vp.current = props.showVp;
  const drag = useRef(props.drag);
  drag.current = props.drag;

  useEffect(() => {
    props.drawn({
      plots: () => plots.current.filter((each): each is uPlot => each !== null),
      draw: (window) => {
        const [upper, lower] = plots.current;
        if (!lower || engine.kept.t.length === 0) return;
        const { t: times, sp, pv, op, vp: vps } = engine.kept;
        const [from, end] = engine.shown(window);
        const part = (of: number[]) => of.slice(from, end);
        const x = part(times);
        // At first the line grows from the left; then all of it moves.
        const begin = Math.max(times[0] ?? 0, engine.clock - window);
        const span = { min: begin, max: begin + window };
        if (upper && pv.length > 0)
          upper.batch(() => {
            upper.setData([x, part(sp), part(pv)], false);
            upper.setScale("x", span);
          });
        lower.batch(() => {
          lower.setData([x, part(op), part(vps)], false);
          if (lower.series[2]?.show !== vp.current) lower.setSeries(2, { show: vp.current });
          lower.setScale("x", span);
        });
      },
    });
  }, []);

  const made = (plot: uPlot) => {
    plots.current[0] = plot;
    const over = plot.over;
    let held = false;
    const near = (event: PointerEvent) => {
      const sp = engine.kept.sp[engine.now()];
      if (sp === undefined) return false;
      return Math.abs(plot.valToPos(sp, "y") - (event.clientY - over.getBoundingClientRect().top)) < 14;
    };
    over.addEventListener("pointerdown", (event) => {
      if (!near(event)) return;
      held = true;
      over.setPointerCapture(event.pointerId);
      event.preventDefault();
    });
    over.addEventListener("pointermove", (event) => {
      over.style.cursor = held || near(event) ? "ns-resize" : "crosshair";
      if (held) drag.current(plot.posToVal(event.clientY - over.getBoundingClientRect().top, "y"));
    });
    for (const end of ["pointerup", "pointercancel"] as const) over.addEventListener(end, () => (held = false));
  };
  const [above, below] = steady.current;
  return (
    <div class="trends">
      <p class="keys" aria-hidden="true" hidden={!props.isLoop}>
        <span class="key pv">PV</span> <span class="key sp">SP</span> <span class="soft">{t.loop.dragSp}</span>
      </p>
      {props.isLoop && <Chart
        label={t.loop.upperLabel}
        height={190}
        options={options([line("sp", "SP"), line("pv", "PV")], `PV${props.unit ? `, ${props.unit}` : ""}`, above, () => 2, false)}
        data={[[], [], []]}
        made={made}
      />}
      <p class="keys" aria-hidden="true">
        <span class="key op">OP</span> {props.showVp && <span class="key vp">VP</span>}
      </p>
      <Chart
        label={t.loop.lowerLabel}
        height={190}
        options={options([line("op", "OP"), line("vp", "VP")], t.loop.percentAxis, below, () => 2, true)}
        data={[[], [], []]}
        made={(plot) => (plots.current[1] = plot)}
      />
    </div>
  );
}
