// A map of the loop's cycles over two settings, with the point where the loop is: it can be dragged.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { Latest, type Answer, type Ask } from "../api";
import { onTheme, style } from "../chart";
import { t } from "../texts";
import { asked, knobs, turn, value, type Knob } from "./knobs";
import { cleared, ticks } from "./phase";

type MapAnswer = Answer<"map">;

const PAIRS = { bands: ["S", "J"], tuning: ["kc", "ti"] } as const;
const PARAMETERS: Record<string, string> = { S: "S", J: "J", kc: "Kc", ti: "Ti" };
const POINTS = 40;

/** Dark to light, even to the eye and to who sees no red (after viridis). */
const SHADES = [
  [68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37],
] as const;

export function shade(share: number): string {
  const at = Math.max(0, Math.min(1, share)) * (SHADES.length - 1);
  const k = Math.min(SHADES.length - 2, Math.floor(at));
  const [a, b] = [SHADES[k], SHADES[k + 1]];
  if (!a || !b) return "#888";
  const mixed = a.map((x, i) => Math.round(x + (at - k) * ((b[i] as number) - x)));
  return `rgb(${mixed.join(" ")})`;
}

export function LoopMap(props: { locked: boolean }) {
  const pair = useSignal<keyof typeof PAIRS>("bands");
  const shown = useSignal<{ map: MapAnswer; pair: keyof typeof PAIRS } | null>(null);
  const wrong = useSignal("");
  const canvas = useRef<HTMLCanvasElement>(null);
  const latest = useRef<Latest<"map"> | null>(null);
  latest.current ??= new Latest(
    "map",
    (map, ask) => {
      shown.value = { map, pair: ask.x.parameter === "S" ? "bands" : "tuning" };
      wrong.value = "";
    },
    (error) => {
      shown.value = null;
      wrong.value = error.message;
    },
  );

  const of = (id: string): Knob | undefined => knobs.value.find((each) => each.id === id);
  const [xId, yId] = PAIRS[pair.value];
  const [x, y] = [of(xId), of(yId)];

  // The map does not change with the point that is dragged over it.
  const rest = (asked.value.set ?? []).filter((each) => !each.startsWith(`${x?.key}=`) && !each.startsWith(`${y?.key}=`));
  const key = JSON.stringify([asked.value.scenario, rest, pair.value]);
  useEffect(() => {
    if (!x || !y) return;
    const axis = (id: string, knob: Knob): Ask<"map">["x"] => ({
      parameter: PARAMETERS[id] ?? id,
      from: knob.log ? knob.min : Math.max(knob.min, 0.25),
      to: knob.max,
      points: POINTS,
    });
    const ask = { loop: asked.value, x: axis(xId, x), y: axis(yId, y) };
    const timer = setTimeout(() => latest.current?.ask(ask), 120);
    return () => clearTimeout(timer);
  }, [key, x?.max, y?.max]);

  const place = useRef<{ left: number; top: number; right: number; bottom: number; xs: number[]; ys: number[] } | null>(null);
  const draw = () => {
    const at = canvas.current;
    const now = shown.peek();
    const got = at && cleared(at);
    if (!got || !now) return;
    const [c, w, h] = got;
    const { map } = now;
    const [xs, ys] = [map.x.values, map.y.values];
    const box = { left: 50, top: 8, right: w - 10, bottom: h - 36, xs, ys };
    place.current = box;
    const pv = map.half_pp.pv;
    const top = Math.max(1e-9, ...pv.map((each) => each ?? 0));
    const [cw, ch] = [(box.right - box.left) / xs.length, (box.bottom - box.top) / ys.length];
    for (let j = 0; j < ys.length; j++)
      for (let i = 0; i < xs.length; i++) {
        const swing = pv[j * xs.length + i];
        c.fillStyle = swing == null ? style("line") : shade(swing / top);
        c.fillRect(box.left + i * cw, box.bottom - (j + 1) * ch, cw + 0.6, ch + 0.6);
      }
    c.fillStyle = style("soft");
    c.textAlign = "center";
    const [x0, x1, y0, y1] = [xs[0] ?? 0, xs[xs.length - 1] ?? 1, ys[0] ?? 0, ys[ys.length - 1] ?? 1];
    const px = (v: number) => box.left + cw / 2 + ((v - x0) / (x1 - x0)) * (box.right - box.left - cw);
    const py = (v: number) => box.bottom - ch / 2 - ((v - y0) / (y1 - y0)) * (box.bottom - box.top - ch);
    for (const v of ticks(x0, x1, 5)) c.fillText(String(v), px(v), box.bottom + 15);
    c.fillText(`${map.x.parameter}${map.x.unit ? `, ${map.x.unit}` : ""}`, (box.left + box.right) / 2, h - 5);
    c.textAlign = "right";
    for (const v of ticks(y0, y1, 5)) c.fillText(String(v), box.left - 5, py(v) + 4);
    c.save();
    c.translate(12, (box.top + box.bottom) / 2);
    c.rotate(-Math.PI / 2);
    c.textAlign = "center";
    c.fillText(`${map.y.parameter}${map.y.unit ? `, ${map.y.unit}` : ""}`, 0, 0);
    c.restore();
    const [kx, ky] = PAIRS[now.pair].map(of);
    if (!kx || !ky) return;
    const [dx, dy] = [px(value(kx.key)), py(value(ky.key))];
    c.beginPath();
    c.arc(Math.max(box.left, Math.min(box.right, dx)), Math.max(box.top, Math.min(box.bottom, dy)), 7, 0, 7);
    c.fillStyle = "#fff";
    c.fill();
    c.lineWidth = 3;
    c.strokeStyle = "#111";
    c.stroke();
  };
  useEffect(draw);
  useEffect(() => {
    const off = onTheme(draw);
    const sized = new ResizeObserver(draw);
    if (canvas.current) sized.observe(canvas.current);
    return () => {
      off();
      sized.disconnect();
    };
  }, []);

  const drag = (event: PointerEvent) => {
    const [box, at] = [place.current, canvas.current];
    if (!box || !at || !x || !y || props.locked) return;
    const r = at.getBoundingClientRect();
    const within = (v: number) => Math.max(0, Math.min(1, v));
    const [sx, sy] = [
      within((event.clientX - r.left - box.left) / (box.right - box.left)),
      within((r.top + box.bottom - event.clientY) / (box.bottom - box.top)),
    ];
    const of = (all: number[], share: number) => (all[0] ?? 0) + share * ((all[all.length - 1] ?? 1) - (all[0] ?? 0));
    turn(x.key, of(box.xs, sx));
    turn(y.key, of(box.ys, sy));
  };
  const top = Math.max(0, ...(shown.value?.map.half_pp.pv ?? []).map((each) => each ?? 0));
  return (
    <section class="card map">
      <div class="row">
        <h2>{t.loop.map}</h2>
        <span class="row" role="group" aria-label={t.loop.mapOf}>
          {(Object.keys(PAIRS) as (keyof typeof PAIRS)[]).map((each) => (
            <button key={each} aria-pressed={pair.value === each} onClick={() => (pair.value = each)}>
              {t.loop.maps[each]}
            </button>
          ))}
        </span>
      </div>
      <canvas
        ref={canvas}
        role="img"
        aria-label={t.loop.mapLabel}
        onPointerDown={(event) => {
          event.currentTarget.setPointerCapture(event.pointerId);
          drag(event);
        }}
        onPointerMove={(event) => event.currentTarget.hasPointerCapture(event.pointerId) && drag(event)}
      />
      <p class="row scale soft">
        <span>{t.loop.noCycle}</span>
        <span class="swatch none" /> <span>0</span>
        <span class="swatch ramp" />
        <span>{top.toPrecision(2)}</span> <span>{t.loop.mapScale}</span>
      </p>
      {wrong.value && <p class="wrong">{wrong.value}</p>}
    </section>
  );
}
