// The trend: PV and SP above, OP and VP below, one time for both. It zooms and moves on what the page has, and a stretch of
// it can be chosen with the pointer, with a finger or with keys.
import { useEffect, useRef, useState } from "preact/hooks";
import uPlot from "uplot";
import { axis, line, onTheme, style } from "../../chart";
import { t } from "../../texts";
import { type Clock, lasting, place, type Samples, short, type Signal, step, thinned } from "./samples";

const w = t.recordings.trend;
export type Span = readonly [number, number];

export interface TrendProps {
  name: string;
  samples: Samples;
  clock: Clock;
  unit: string;
  /** What is in view. */
  view: Span;
  onView(view: Span): void;
  /** The stretch that is judged; null for all. */
  stretch: Span | null;
  onStretch(stretch: Span | null): void;
  /** When the valve is seen to slip. */
  slips: number[];
  /** The moment that is pointed at, here or in the picture of PV over OP. */
  at: number | null;
  onAt(at: number | null): void;
}

const AXIS = 58;
const MOST_SLIPS = 250;
/** Steps along an axis of elapsed time, s. */
const ROUND = [1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30]
  .concat([1, 2, 5, 10, 15, 30].map((min) => 60 * min))
  .concat([1, 2, 3, 6, 12].map((h) => 3600 * h))
  .concat([1, 2, 5, 10, 20, 50, 100, 200, 500].map((d) => 86400 * d));

/** The ends of a recording. */
export function ends({ time }: Samples): Span {
  return [time[0] ?? 0, time[time.length - 1] ?? 1];
}

export function Trend(props: TrendProps) {
  const place_ = useRef<HTMLDivElement>(null);
  const over = useRef<HTMLDivElement>(null);
  const now = useRef(props);
  now.current = props;
  const plots = useRef<{ plot: uPlot; shown: Signal[] }[]>([]);
  const [mode, setMode] = useState<"select" | "move">("select");
  const [width, setWidth] = useState(0);
  const { samples, clock, view, stretch } = props;
  const all = ends(samples);
  const least = step(samples);

  const clamp = (a: number, b: number): Span => {
    const length = Math.min(Math.max(b - a, 8 * least), all[1] - all[0] || 1);
    const from = Math.min(Math.max(a, all[0]), all[1] - length);
    return [from, from + length];
  };
  const zoom = (by: number, about = (now.current.view[0] + now.current.view[1]) / 2) => {
    const [a, b] = now.current.view;
    now.current.onView(clamp(about - (about - a) * by, about + (b - about) * by));
  };
  const move = (by: number) => {
    const [a, b] = now.current.view;
    now.current.onView(clamp(a + by * (b - a), b + by * (b - a)));
  };

  const draw = () => {
    const { view, samples } = now.current;
    for (const { plot, shown } of plots.current) {
      const pixels = Math.max(50, Math.round(plot.bbox.width / devicePixelRatio) || 300);
      const [x, ...columns] = thinned(samples, shown, view[0], view[1], pixels);
      const origin = now.current.clock.origin;
      if (origin) for (let i = 0; i < x.length; i++) (x[i] as number) += origin;
      plot.batch(() => {
        plot.setData([x, ...columns] as uPlot.AlignedData, false);
        plot.setScale("x", { min: view[0] + origin, max: view[1] + origin });
      });
    }
  };

  // The plots, anew for each recording.
  useEffect(() => {
    const at = place_.current;
    if (!at) return;
    const has = (signal: Signal) => signal in samples.signals;
    const upper = (["sp", "pv"] as Signal[]).filter(has);
    const lower = (["op", "vp"] as Signal[]).filter(has);
    const narrow = at.clientWidth < 500;
    const height = narrow ? 150 : 190;
    const made = [upper, lower]
      .filter((shown) => shown.length > 0)
      .map((shown, k, groups) => {
        const bottom = k === groups.length - 1;
        const label = shown[0] === "op" || shown[0] === "vp" ? w.percent : `PV${props.unit ? ` (${props.unit})` : ""}`;
        const time: uPlot.Axis = axis({ size: bottom ? 34 : 8, ...(bottom ? {} : { values: (_, splits) => splits.map(() => "") }) });
        if (!clock.dated) time.incrs = ROUND;
        if (bottom && !clock.dated) time.values = (_, splits) => elapsed(splits);
        const options: uPlot.Options = {
          width: at.clientWidth,
          height: height + (bottom ? 26 : 0),
          padding: [8, 8, 0, 0],
          legend: { show: false },
          cursor: { show: false },
          tzDate: (ts) => uPlot.tzDate(new Date(ts * 1e3), "Etc/UTC"),
          scales: { x: { time: clock.dated }, y: { range: padded } },
          axes: [time, axis({ size: AXIS, label })],
          series: [{}, ...shown.map((signal) => line(signal, t.signals[signal], steps(signal)))],
          hooks: shown.includes("op") ? { draw: [(plot) => slips(plot, now.current)] } : {},
        };
        const plot = new uPlot(options, [[], ...shown.map(() => [])] as uPlot.AlignedData, at);
        return { plot, shown };
      });
    plots.current = made;
    setWidth(at.clientWidth);
    draw();
    const sized = new ResizeObserver(() => {
      if (at.clientWidth > 0 && at.clientWidth !== made[0]?.plot.width) {
        for (const { plot } of made) plot.setSize({ width: at.clientWidth, height: plot.height });
        setWidth(at.clientWidth);
        draw();
      }
    });
    sized.observe(at);
    const off = onTheme(() => made.forEach(({ plot }) => plot.redraw()));
    return () => {
      off();
      sized.disconnect();
      made.forEach(({ plot }) => plot.destroy());
      plots.current = [];
    };
  }, [samples]);

  // A view that changes many times between two pictures is drawn once.
  const frame = useRef(0);
  useEffect(() => {
    cancelAnimationFrame(frame.current);
    frame.current = requestAnimationFrame(draw);
  }, [view[0], view[1], props.slips]);

  const left = AXIS + 18;
  const inner = Math.max(1, width - left - 8);
  const x = (time: number) => ((time - view[0]) / (view[1] - view[0])) * inner;
  const timeAt = (clientX: number) => {
    const box = over.current?.getBoundingClientRect();
    const { view } = now.current;
    return box ? view[0] + ((clientX - box.left) / box.width) * (view[1] - view[0]) : view[0];
  };

  // Fingers and pointers.
  useEffect(() => {
    const at = over.current;
    if (!at) return;
    const wheel = (event: WheelEvent) => {
      event.preventDefault();
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
        move(Math.sign(event.deltaX || event.deltaY) * 0.1);
      } else {
        zoom(Math.exp(Math.max(-120, Math.min(120, event.deltaY)) * 0.002), timeAt(event.clientX));
      }
    };
    at.addEventListener("wheel", wheel, { passive: false });
    return () => at.removeEventListener("wheel", wheel);
  }, [samples]);

  const fingers = useRef(new Map<number, number>());
  const drag = useRef<{ kind: "select" | "move" | "from" | "to"; start: number; view: Span; x: number; other: number } | null>(null);
  const sorted = (a: number, b: number): Span => (a <= b ? [a, b] : [b, a]);
  const within = (time: number) => Math.min(Math.max(time, all[0]), all[1]);

  const down = (event: PointerEvent, kind?: "from" | "to") => {
    if (event.button > 0) return;
    const target = event.currentTarget as HTMLElement;
    target.setPointerCapture?.(event.pointerId);
    fingers.current.set(event.pointerId, event.clientX);
    const start = timeAt(event.clientX);
    const moves = (mode === "move") !== event.shiftKey;
    const [a, b] = stretch ?? all;
    const other = kind === "from" ? b : kind === "to" ? a : start;
    drag.current = { kind: kind ?? (moves ? "move" : "select"), start, view, x: event.clientX, other };
    if (kind) event.stopPropagation();
  };
  const moved = (event: PointerEvent) => {
    const known = fingers.current;
    if (!known.has(event.pointerId)) {
      props.onAt(within(timeAt(event.clientX)));
      return;
    }
    if (known.size === 2) {
      const others = [...known].filter(([id]) => id !== event.pointerId).map(([, x]) => x);
      const before = Math.abs((known.get(event.pointerId) as number) - (others[0] as number));
      const after = Math.abs(event.clientX - (others[0] as number));
      known.set(event.pointerId, event.clientX);
      drag.current = null;
      if (before > 8 && after > 8) zoom(before / after, timeAt(((others[0] as number) + event.clientX) / 2));
      return;
    }
    known.set(event.pointerId, event.clientX);
    const of = drag.current;
    if (!of) return;
    if (of.kind === "move") {
      const by = ((of.x - event.clientX) / inner) * (of.view[1] - of.view[0]);
      props.onView(clamp(of.view[0] + by, of.view[1] + by));
    } else if (of.kind !== "select" || Math.abs(event.clientX - of.x) > 4) {
      props.onStretch(sorted(within(of.other), within(timeAt(event.clientX))));
    }
  };
  const up = (event: PointerEvent) => {
    fingers.current.delete(event.pointerId);
    drag.current = null;
  };

  // Keys.
  const keys = (event: KeyboardEvent) => {
    const known: Record<string, () => void> = {
      ArrowLeft: () => move(-0.1),
      ArrowRight: () => move(0.1),
      "+": () => zoom(0.7),
      "=": () => zoom(0.7),
      "-": () => zoom(1 / 0.7),
      "0": () => props.onView(all),
    };
    const act = known[event.key];
    if (!act || event.target !== event.currentTarget) return;
    event.preventDefault();
    act();
  };
  const [a, b] = stretch ?? all;
  const slide = (which: 0 | 1) => (event: KeyboardEvent) => {
    const fine = Math.max(least, (view[1] - view[0]) / 200);
    const by = event.shiftKey ? least : fine;
    const steps: Record<string, number> = {
      ArrowLeft: -by, ArrowDown: -by, ArrowRight: by, ArrowUp: by, PageDown: -20 * fine, PageUp: 20 * fine,
      Home: -Infinity, End: Infinity,
    };
    const delta = steps[event.key];
    if (delta === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    const low = which === 0 ? all[0] : a + 8 * least;
    const high = which === 0 ? b - 8 * least : all[1];
    const value = Math.min(Math.max((which === 0 ? a : b) + delta, low), high);
    const next: Span = which === 0 ? [value, b] : [a, value];
    props.onStretch(next);
    // What is moved stays in view.
    if (value < view[0] || value > view[1]) props.onView(clamp(value - (view[1] - view[0]) / 2, value + (view[1] - view[0]) / 2));
  };

  const seen = props.at === null ? null : place(samples.time, props.at);
  const values = seen === null ? null : Math.min(seen, samples.time.length - 1);
  const shown = (["pv", "sp", "op", "vp"] as Signal[]).filter((signal) => signal in samples.signals);
  const handle = (which: 0 | 1) => {
    const value = which === 0 ? a : b;
    const px = x(value);
    const visible = px >= -1 && px <= inner + 1;
    return (
      <div
        class={`handle ${which === 0 ? "from" : "to"}`}
        role="slider"
        tabIndex={0}
        aria-label={which === 0 ? w.from : w.to}
        aria-orientation="horizontal"
        aria-valuemin={all[0]}
        aria-valuemax={all[1]}
        aria-valuenow={value}
        aria-valuetext={clock.moment(value)}
        style={{ left: `${Math.min(Math.max(px, 0), inner)}px`, opacity: visible ? 1 : 0.35 }}
        onPointerDown={(event) => down(event, which === 0 ? "from" : "to")}
        onPointerMove={moved}
        onPointerUp={up}
        onPointerCancel={up}
        onKeyDown={slide(which)}
      />
    );
  };
  const [l, r] = [Math.max(0, x(a)), Math.min(inner, x(b))];
  const whole = view[0] <= all[0] && view[1] >= all[1];

  return (
    <section class="trend" aria-label={w.label(props.name)}>
      <div class="tools row">
        <span class="modes" role="group" aria-label={w.drag}>
          <button type="button" aria-pressed={mode === "select"} onClick={() => setMode("select")}>
            {w.select}
          </button>
          <button type="button" aria-pressed={mode === "move"} onClick={() => setMode("move")}>
            {w.move}
          </button>
        </span>
        <button type="button" aria-label={w.zoomIn} title={w.zoomIn} onClick={() => zoom(0.6)}>+</button>
        <button type="button" aria-label={w.zoomOut} title={w.zoomOut} disabled={whole} onClick={() => zoom(1 / 0.6)}>−</button>
        <button type="button" disabled={whole} onClick={() => props.onView(all)}>{w.all}</button>
        <button type="button" disabled={!stretch} onClick={() => props.onView(clamp(a - (b - a) * 0.08, b + (b - a) * 0.08))}>{w.toStretch}</button>
        <button type="button" disabled={!stretch} onClick={() => props.onStretch(null)}>{w.judgeAll}</button>
      </div>
      <div class="reads">
        <span class="legend" aria-hidden="true">
          {shown.map((signal) => (
            <span key={signal} class={`key ${signal}`}>
              {t.signals[signal]}
              {values !== null && <b>{short((samples.signals[signal] as Float64Array)[values] as number)}</b>}
            </span>
          ))}
        </span>
        <span class="reading soft">
          {values === null ? clock.span(view[0], view[1]) : clock.moment(samples.time[values] as number, least < 1)}
          {clock.dated && clock.name ? ` ${clock.name}` : ""}
          {values === null ? ` (${lasting(view[1] - view[0])})` : ""}
        </span>
      </div>
      <div
        class="canvases"
        role="group"
        tabIndex={0}
        aria-label={w.keys}
        onKeyDown={keys}
      >
        <div ref={place_} aria-hidden="true" />
        <div
          class={`over ${mode}`}
          ref={over}
          style={{ left: `${left}px`, width: `${inner}px` }}
          onPointerDown={(event) => down(event)}
          onPointerMove={moved}
          onPointerUp={up}
          onPointerCancel={up}
          onPointerLeave={() => props.onAt(null)}
          onDblClick={() => props.onView(all)}
        >
          {stretch && r > l && <div class="picked" style={{ left: `${l}px`, width: `${r - l}px` }} />}
          {props.at !== null && props.at >= view[0] && props.at <= view[1] && (
            <div class="cross" style={{ left: `${x(props.at)}px` }} />
          )}
          {handle(0)}
          {handle(1)}
        </div>
      </div>
    </section>
  );
}

/** OP and SP hold until they change. */
function steps(signal: Signal): uPlot.Series {
  const of = uPlot.paths.stepped?.({ align: 1 });
  return { ...(of && (signal === "op" || signal === "sp") ? { paths: of } : {}), spanGaps: false };
}

/** A range with some air, that has a height where a signal rests. */
function padded(_: uPlot, low: number | null, high: number | null): uPlot.Range.MinMax {
  if (low === null || high === null || !Number.isFinite(low + high)) return [0, 1];
  const height = high - low || Math.max(Math.abs(high) * 0.02, 0.1);
  return [low - 0.06 * height, high + 0.06 * height];
}

/** Times since the beginning, in one unit along the axis. */
function elapsed(splits: number[]): string[] {
  const far = Math.max(...splits.map(Math.abs));
  const [by, unit] = far < 180 ? [1, "s"] : far < 10800 ? [60, "min"] : far < 259200 ? [3600, "h"] : [86400, "d"];
  return splits.map((s) => `${short(s / by, 6)} ${unit}`);
}

/** Marks where the valve slips, above the OP. */
function slips(plot: uPlot, { slips, clock }: TrendProps) {
  const { min = 0, max = 1 } = plot.scales.x as { min?: number; max?: number };
  const seen = slips.filter((time) => time + clock.origin >= min && time + clock.origin <= max);
  if (seen.length === 0 || seen.length > MOST_SLIPS) return;
  const { ctx, bbox } = plot;
  const size = 4 * devicePixelRatio;
  ctx.save();
  ctx.fillStyle = style("bad");
  for (const time of seen) {
    const at = plot.valToPos(time + clock.origin, "x", true);
    ctx.beginPath();
    ctx.moveTo(at - size, bbox.top);
    ctx.lineTo(at + size, bbox.top);
    ctx.lineTo(at, bbox.top + 1.6 * size);
    ctx.fill();
  }
  ctx.restore();
}
