// A chart over time on a canvas: signals with units, a legend that can be read and pressed, colours that follow the theme.
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";

/** Signals; their colours are in signals.css. */
export const COLOURS = ["sp", "pv", "op", "vp"] as const;
export type Signal = (typeof COLOURS)[number];

/** A colour, or another variable, of the style. */
export function style(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Told when the theme changes, so that canvases are drawn again. */
export function onTheme(f: () => void): () => void {
  const query = matchMedia("(prefers-color-scheme: dark)");
  query.addEventListener("change", f);
  return () => query.removeEventListener("change", f);
}

/** Distances of a time axis, s. */
export const ROUND = [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 28800, 86400];

/** Time as a trend tells it: s, or min, or h. */
export function clock(seconds: number): string {
  const s = Math.round(seconds);
  const two = (n: number) => String(n).padStart(2, "0");
  return s < 3600 ? `${Math.floor(s / 60)}:${two(s % 60)}` : `${Math.floor(s / 3600)}:${two(Math.floor(s / 60) % 60)}:${two(s % 60)}`;
}

/** An axis in the colours of the theme. */
export function axis(more: uPlot.Axis = {}): uPlot.Axis {
  return {
    stroke: () => style("soft"),
    grid: { stroke: () => style("line"), width: 1 },
    ticks: { stroke: () => style("line"), width: 1 },
    font: "12px system-ui, sans-serif",
    labelFont: "12px system-ui, sans-serif",
    labelSize: 18,
    ...more,
  };
}

/** The line of a signal. */
export function line(signal: Signal, label: string, more: uPlot.Series = {}): uPlot.Series {
  return {
    label,
    stroke: () => style(signal),
    width: signal === "sp" ? 1.25 : 1.75,
    points: { show: false },
    ...(signal === "sp" ? { dash: [6, 4] } : {}),
    ...more,
  };
}

/** A chart that fills the width of its place; `made` gets it once, to give it data as they come. */
export function Chart(props: {
  /** What it shows, for who cannot see it. */
  label: string;
  height: number;
  options: Omit<uPlot.Options, "width" | "height">;
  data: uPlot.AlignedData;
  made?: (plot: uPlot) => void;
}) {
  const place = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  useEffect(() => {
    const at = place.current;
    if (!at) return;
    const made = new uPlot({ ...props.options, width: at.clientWidth, height: props.height }, props.data, at);
    plot.current = made;
    props.made?.(made);
    const sized = new ResizeObserver(() => {
      if (at.clientWidth > 0 && at.clientWidth !== made.width) made.setSize({ width: at.clientWidth, height: props.height });
    });
    sized.observe(at);
    const off = onTheme(() => made.redraw());
    return () => {
      off();
      sized.disconnect();
      made.destroy();
      plot.current = null;
    };
    // A chart with other options is another chart: give it another key.
  }, []);
  useEffect(() => {
    if (plot.current && plot.current.data !== props.data) plot.current.setData(props.data);
  }, [props.data]);
  return <div class="chart" role="img" aria-label={props.label} ref={place} />;
}
