// PV over OP of the stretch: how a valve that sticks draws its loop.
import { useEffect, useRef } from "preact/hooks";
import { onTheme, style } from "../../chart";
import { t } from "../../texts";
import { place, type Samples, short } from "./samples";
import type { Span } from "./trend";

const w = t.recordings.map;
/** Beyond, samples are dots, and not all of them. */
const LINE = 4000;
const DOTS = 20000;

interface Frame {
  x(op: number): number;
  y(pv: number): number;
  first: number;
  last: number;
}

/** Values at even steps between two, and few of them. */
function ticks(low: number, high: number, most: number): number[] {
  const raw = (high - low) / most;
  const decade = 10 ** Math.floor(Math.log10(raw));
  const size = [1, 2, 5, 10].map((each) => each * decade).find((each) => each >= raw) ?? raw;
  const out: number[] = [];
  for (let at = Math.ceil(low / size) * size; at <= high + 1e-9 * size; at += size) out.push(Math.abs(at) < 1e-12 * size ? 0 : at);
  return out;
}

export function PvOverOp(props: {
  samples: Samples;
  stretch: Span;
  unit: string;
  at: number | null;
  onAt(at: number | null): void;
}) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const frame = useRef<Frame | null>(null);
  const now = useRef(props);
  now.current = props;

  const draw = () => {
    const at = canvas.current;
    const { samples, stretch, unit } = now.current;
    const { op, pv } = samples.signals;
    if (!at || !op || !pv) return;
    const [wide, high] = [at.clientWidth, at.clientHeight];
    const ratio = devicePixelRatio || 1;
    at.width = wide * ratio;
    at.height = high * ratio;
    const ctx = at.getContext("2d");
    if (!ctx) return;
    ctx.scale(ratio, ratio);
    const first = place(samples.time, stretch[0]);
    const last = Math.max(first + 1, place(samples.time, stretch[1]));
    let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
    for (let i = first; i < last; i++) {
      const [u, v] = [op[i] as number, pv[i] as number];
      if (u < x0) x0 = u;
      if (u > x1) x1 = u;
      if (v < y0) y0 = v;
      if (v > y1) y1 = v;
    }
    if (!(x1 >= x0 && y1 >= y0)) [x0, x1, y0, y1] = [0, 1, 0, 1];
    const grow = (a: number, b: number): [number, number] => {
      const air = (b - a || Math.max(Math.abs(a) * 0.02, 0.1)) * 0.07;
      return [a - air, b + air];
    };
    [x0, x1] = grow(x0, x1);
    [y0, y1] = grow(y0, y1);
    const box = { left: 52, top: 8, right: wide - 8, bottom: high - 38 };
    const x = (u: number) => box.left + ((u - x0) / (x1 - x0)) * (box.right - box.left);
    const y = (v: number) => box.bottom - ((v - y0) / (y1 - y0)) * (box.bottom - box.top);
    frame.current = { x, y, first, last };
    ctx.font = "12px system-ui, sans-serif";
    ctx.strokeStyle = style("line");
    ctx.fillStyle = style("soft");
    ctx.lineWidth = 1;
    ctx.textAlign = "center";
    ctx.textBaseline = "top";
    for (const u of ticks(x0, x1, Math.max(2, wide / 80))) {
      ctx.beginPath();
      ctx.moveTo(x(u), box.top);
      ctx.lineTo(x(u), box.bottom);
      ctx.stroke();
      ctx.fillText(short(u), x(u), box.bottom + 5);
    }
    ctx.fillText(w.op, (box.left + box.right) / 2, box.bottom + 22);
    ctx.textAlign = "right";
    ctx.textBaseline = "middle";
    for (const v of ticks(y0, y1, Math.max(2, high / 50))) {
      ctx.beginPath();
      ctx.moveTo(box.left, y(v));
      ctx.lineTo(box.right, y(v));
      ctx.stroke();
      ctx.fillText(short(v), box.left - 5, y(v));
    }
    ctx.save();
    ctx.translate(10, (box.top + box.bottom) / 2);
    ctx.rotate(-Math.PI / 2);
    ctx.textAlign = "center";
    ctx.fillText(unit ? `PV (${unit})` : "PV", 0, 0);
    ctx.restore();
    ctx.strokeStyle = ctx.fillStyle = style("pv");
    if (last - first <= LINE) {
      ctx.lineWidth = 1.25;
      ctx.globalAlpha = last - first > 600 ? 0.55 : 0.9;
      ctx.lineJoin = "round";
      ctx.beginPath();
      let pen = false;
      for (let i = first; i < last; i++) {
        const [u, v] = [x(op[i] as number), y(pv[i] as number)];
        if (Number.isNaN(u + v)) pen = false;
        else if (pen) ctx.lineTo(u, v);
        else ctx.moveTo(u, v), (pen = true);
      }
      ctx.stroke();
    } else {
      ctx.globalAlpha = 0.25;
      const stride = Math.max(1, Math.floor((last - first) / DOTS));
      for (let i = first; i < last; i += stride) ctx.fillRect(x(op[i] as number) - 0.75, y(pv[i] as number) - 0.75, 1.5, 1.5);
    }
    ctx.globalAlpha = 1;
    const { at: pointed } = now.current;
    if (pointed !== null) {
      const i = Math.min(place(samples.time, pointed), samples.time.length - 1);
      const [u, v] = [x(op[i] as number), y(pv[i] as number)];
      if (u >= box.left && u <= box.right && v >= box.top && v <= box.bottom) {
        ctx.fillStyle = style("bad");
        ctx.strokeStyle = style("paper");
        ctx.lineWidth = 2;
        ctx.beginPath();
        ctx.arc(u, v, 6, 0, 7);
        ctx.fill();
        ctx.stroke();
      }
    }
  };

  const wanted = useRef(0);
  useEffect(() => {
    cancelAnimationFrame(wanted.current);
    wanted.current = requestAnimationFrame(draw);
  }, [props.samples, props.stretch[0], props.stretch[1], props.at]);
  useEffect(() => {
    const at = canvas.current;
    if (!at) return;
    const sized = new ResizeObserver(draw);
    sized.observe(at);
    const off = onTheme(draw);
    return () => {
      off();
      sized.disconnect();
    };
  }, []);

  // The nearest sample to a pointer; of many, of some.
  const moved = (event: PointerEvent) => {
    const found = frame.current;
    const { op, pv } = props.samples.signals;
    const box = canvas.current?.getBoundingClientRect();
    if (!found || !op || !pv || !box) return;
    const [px, py] = [event.clientX - box.left, event.clientY - box.top];
    const stride = Math.max(1, Math.floor((found.last - found.first) / DOTS));
    let [best, least] = [-1, 900];
    for (let i = found.first; i < found.last; i += stride) {
      const d = (found.x(op[i] as number) - px) ** 2 + (found.y(pv[i] as number) - py) ** 2;
      if (d < least) [best, least] = [i, d];
    }
    props.onAt(best < 0 ? null : (props.samples.time[best] as number));
  };

  return (
    <figure class="map">
      <figcaption>{w.title}</figcaption>
      <canvas ref={canvas} role="img" aria-label={w.label} onPointerMove={moved} onPointerLeave={() => props.onAt(null)} />
    </figure>
  );
}
