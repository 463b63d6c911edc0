// A loop day by day: the probability that it sticks with the verdict's symbol, S with its interval, and what people said.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Answer } from "../../api";
import { t } from "../../texts";
import { graded, percent, rough } from "./state";

const w = t.plant;
const DAY = 86_400_000;
/** Heights: events, p, a gap, S, days. */
const [TOP, P, GAP, S, BOTTOM] = [18, 96, 14, 62, 20];
const LEFT = 34;

type History = Answer<"plant/loop">;

/** Days since 1970 of a date. */
function number(day: string): number {
  return Date.parse(`${day}T00:00:00Z`) / DAY;
}

/** A window in words. */
function told(window: History["windows"][number]): string {
  const { row } = window;
  const parts = [row.error ? `${w.loop.error}: ${row.error}` : (row.grade ?? ""), row.probability == null ? "" : `${percent(row.probability)} %`];
  if (row.S != null) parts.push(`S ${rough(row.S)} %`);
  return `${window.day}: ${parts.filter(Boolean).join(", ")}`;
}

export function HistoryChart(props: { of: History; day: string; choose: (day: string) => void }) {
  const box = useRef<HTMLDivElement>(null);
  const width = useSignal(600);
  useEffect(() => {
    const of = box.current;
    if (!of) return;
    const sized = new ResizeObserver(() => (width.value = Math.max(240, of.clientWidth)));
    sized.observe(of);
    return () => sized.disconnect();
  }, []);
  const windows = props.of.windows;
  const [first, last] = [windows[0], windows[windows.length - 1]];
  if (!first || !last) return null;
  const begin = number(first.day);
  const end = Math.max(number(last.day) + last.days, begin + 2);
  const x = (day: number) => LEFT + ((width.value - LEFT - 6) * (day - begin)) / (end - begin);
  const middle = (window: History["windows"][number]) => x(number(window.day) + window.days / 2);
  const y = (p: number) => TOP + P * (1 - p);
  const most = Math.max(1, ...windows.map(({ row }) => Math.min(row.S_high ?? row.S ?? 0, 2 * (row.S ?? 0))));
  const below = TOP + P + GAP;
  const z = (s: number) => below + S * (1 - Math.min(1, s / most));
  const height = below + S + BOTTOM;
  let line = "";
  let pen = false;
  for (const window of windows) {
    const p = window.row.probability;
    if (p == null) pen = false;
    else {
      line += `${pen ? "L" : "M"}${middle(window).toFixed(1)} ${y(p).toFixed(1)}`;
      pen = true;
    }
  }
  const chosen = windows.findIndex((window) => window.day === props.day);
  const start = chosen < 0 ? windows.length - 1 : chosen;
  const step = (event: KeyboardEvent) => {
    const by = { ArrowRight: 1, ArrowLeft: -1, Home: -windows.length, End: windows.length }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    const next = Math.max(0, Math.min(windows.length - 1, start + by));
    props.choose(windows[next]?.day ?? props.day);
    box.current?.querySelector<SVGElement>(`[data-day="${windows[next]?.day}"]`)?.focus();
  };
  // As many days are named as there is room for, Mondays first.
  const room = Math.max(1, Math.ceil((80 * (end - begin)) / (width.value - LEFT)));
  const every = room <= 7 ? (room <= 1 ? 1 : room <= 3 ? room : 7) : 7 * Math.ceil(room / 7);
  const names: number[] = [];
  const monday = begin + ((7 - ((begin + 3) % 7)) % 7);
  for (let day = every % 7 === 0 && monday < end ? monday : begin; day < end; day += every) names.push(day);
  return (
    <div class="history" ref={box}>
      <svg width={width.value} height={height} viewBox={`0 0 ${width.value} ${height}`} role="group" aria-label={w.loop.historyLabel(props.of.loop)} onKeyDown={step}>
        <g class="frame" aria-hidden="true">
          {[0, 0.5, 1].map((p) => (
            <g key={p}>
              <path d={`M${LEFT} ${y(p)}H${width.value}`} />
              <text x={LEFT - 5} y={y(p) + 4} class="end">
                {100 * p}
              </text>
            </g>
          ))}
          <text x={LEFT + 4} y={y(1) + 12} class="what">
            {w.loop.p}
          </text>
          {[0, most].map((s) => (
            <g key={s}>
              <path d={`M${LEFT} ${z(s)}H${width.value}`} />
              <text x={LEFT - 5} y={z(s) + 4} class="end">
                {rough(s)}
              </text>
            </g>
          ))}
          <text x={LEFT + 4} y={z(most) + 12} class="what">
            {w.loop.s}
          </text>
          {names.map((day) => (
            <text key={day} x={x(day)} y={height - 5}>
              {new Date(day * DAY).toISOString().slice(5, 10)}
            </text>
          ))}
        </g>
        <g class="events" aria-hidden="true">
          {props.of.entries.map(({ entry, words }, k) => {
            const at = x(number(entry.day) + 0.02);
            if (at < LEFT - 1 || at > width.value) return null;
            return (
              <g key={k} class={entry.kind}>
                <title>{words}</title>
                <path d={`M${at} ${TOP - 3}V${below + S}`} />
                <text x={at} y={TOP - 6}>
                  {w.events[entry.kind]}
                </text>
              </g>
            );
          })}
        </g>
        <path class="line" d={line} aria-hidden="true" />
        {windows.map((window, k) => {
          const { row } = window;
          const { symbol, tone } = graded(row.grade);
          const [at, from, to] = [middle(window), x(number(window.day)), x(number(window.day) + window.days)];
          return (
            <g
              key={window.day}
              class={`day ${tone}`}
              role="button"
              data-day={window.day}
              aria-pressed={k === chosen}
              aria-label={told(window)}
              tabindex={k === start ? 0 : -1}
              onClick={() => props.choose(window.day)}
              onKeyDown={(event) => {
                if (event.key !== "Enter" && event.key !== " ") return;
                event.preventDefault();
                props.choose(window.day);
              }}
            >
              <title>{told(window)}</title>
              <rect x={from} y={TOP} width={Math.max(1, to - from)} height={below + S - TOP} />
              {row.S != null ? (
                <>
                  {row.S_low != null && row.S_high != null ? <path class="range" d={`M${at} ${z(row.S_low)}V${z(row.S_high)}`} /> : null}
                  <circle class="s" cx={at} cy={z(row.S)} r={2.6} />
                </>
              ) : null}
              {row.probability != null ? (
                <text class="mark" x={at} y={y(row.probability) + 5}>
                  {symbol}
                </text>
              ) : (
                <text class="mark" x={at} y={y(0.5) + 5}>
                  {row.error ? "×" : symbol}
                </text>
              )}
            </g>
          );
        })}
      </svg>
      <p class="key soft">
        {[...new Set(windows.map(({ row }) => row.grade))].map((grade) =>
          grade ? (
            <span key={grade} class={`named ${graded(grade).tone}`}>
              <b>{graded(grade).symbol}</b> {grade}
            </span>
          ) : null,
        )}
        {props.of.entries.length > 0 ? <span class="named">{w.eventsKey}</span> : null}
      </p>
    </div>
  );
}
