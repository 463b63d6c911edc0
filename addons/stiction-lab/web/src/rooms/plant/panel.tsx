// A loop of the plant: its week, its days, the trend and the verdict of a day, and what people say.
import { useEffect, useRef, useState } from "preact/hooks";
import { call, type Answer } from "../../api";
import { t } from "../../texts";
import { Forms } from "./forms";
import { HistoryChart } from "./history";
import { at, entered, limit, open, percent, rough, stamp, time, turn, walk, way, type Row } from "./state";
import { TrendOfDay } from "./trend";
import { Grade, Loop, Tile } from "./words";

const w = t.plant;
type History = Answer<"plant/loop">;
type Explained = Answer<"plant/diagnose">;

/** Lines that are shown on demand. */
function Fold(props: { title: string; lines: string[] }) {
  if (props.lines.length === 0) return null;
  return (
    <details>
      <summary>{props.title}</summary>
      <ul>
        {props.lines.map((line) => (
          <li key={line}>{line}</li>
        ))}
      </ul>
    </details>
  );
}

function range(value?: number | null, low?: number | null, high?: number | null): string {
  if (value == null) return "–";
  return `${rough(value)} %${low != null && high != null ? ` (${rough(low)} to ${rough(high)})` : ""}`;
}

function Facts(props: { row: Row; upstream: readonly string[] }) {
  const { row } = props;
  const f = w.loop.row;
  const facts: [string, preact.ComponentChildren][] = [
    [f.p, row.probability == null ? "–" : `${percent(row.probability)} %, ${w.loop.windows(row.windows_judged)}`],
    [f.s, limit(row) != null ? `< ${rough(limit(row)!)} %` : range(row.S, row.S_low, row.S_high)],
    [f.j, range(row.J, row.J_low, row.J_high)],
  ];
  if (row.period_s != null) facts.push([f.period, w.every(time(row.period_s))]);
  if (row.drift_per_week != null) facts.push([f.drift, w.loop.drift(rough(row.drift_per_week), row.limit_day ?? "")]);
  if (row.auto_share != null) facts.push([f.auto, `${row.auto_share.toFixed(0)} %`]);
  if (row.change !== "none") facts.push([f.change, `${row.change}${row.change_day ? ` ${w.changes.since(row.change_day)}` : ""}`]);
  if (row.group != null) {
    facts.push([f.group, <a href={way({ view: "groups" })}>{w.loop.group(row.group, row.candidate_rank ?? null)}</a>]);
  }
  if (props.upstream.length > 0) {
    facts.push([f.upstream, props.upstream.map((name, k) => <>{k > 0 ? ", " : ""}<Loop name={name} /></>)]);
  }
  facts.push([f.data, row.error ? `${row.health}: ${row.error}` : row.health]);
  facts.push([f.weight, rough(row.weight)]);
  return (
    <dl class="facts">
      {facts.map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  );
}

function Verdict(props: { loop: string; day: string; days: number }) {
  const [found, setFound] = useState<Explained | null>(null);
  const [wrong, setWrong] = useState("");
  useEffect(() => {
    const stop = new AbortController();
    setFound(null);
    setWrong("");
    call("plant/diagnose", { loop: props.loop, day: props.day, days: props.days }, stop.signal).then(setFound, (error: Error) => {
      if (!stop.signal.aborted) setWrong(error.message);
    });
    return () => stop.abort();
  }, [props.loop, props.day, props.days]);
  if (wrong) return <p class="wrong">{wrong}</p>;
  if (!found) return <p role="status">{w.loop.judging}</p>;
  const of = found.judgement;
  const { verdict } = of.diagnosis;
  return (
    <>
      <p>
        <Grade name={verdict.grade} />
        {of.probability ? <> · {of.probability}</> : null}
        {of.S ? <> · S {of.S}</> : null}
        {of.J ? <> · J {of.J}</> : null}
      </p>
      <p>{of.sentence}</p>
      {of.why ? <p>{of.why}</p> : null}
      {found.answer ? <p>{found.answer}</p> : null}
      <Fold title={w.loop.reasons} lines={verdict.reasons} />
      <Fold title={w.loop.against} lines={verdict.contradictions} />
      {verdict.alternatives.length > 0 ? (
        <details>
          <summary>{w.loop.other}</summary>
          <ul>
            {verdict.alternatives.map((other) => (
              <li key={other.cause}>
                <b>
                  {other.cause}, {percent(other.likelihood)} %
                </b>
                : {other.because}
              </li>
            ))}
          </ul>
        </details>
      ) : null}
      {verdict.confirm ? (
        <details>
          <summary>{w.loop.test}</summary>
          <ol>
            {verdict.confirm.instructions.map((line) => (
              <li key={line}>{line}</li>
            ))}
          </ol>
        </details>
      ) : null}
      <p class="soft">{w.loop.notKept}</p>
    </>
  );
}

export function Panel() {
  const name = at.value.loop;
  const row = open.value;
  const [history, setHistory] = useState<History | null>(null);
  const [wrong, setWrong] = useState("");
  const head = useRef<HTMLHeadingElement>(null);
  useEffect(() => {
    const stop = new AbortController();
    setWrong("");
    const week = at.value.week;
    call("plant/loop", { loop: name, ...(week ? { week } : {}) }, stop.signal).then(setHistory, (error: Error) => {
      if (!stop.signal.aborted) setWrong(error.message);
    });
    return () => stop.abort();
  }, [name, at.value.week, stamp.value, entered.value]);
  // Where there is no room beside the list the panel takes its place.
  useEffect(() => {
    if (matchMedia("(max-width: 68rem)").matches) {
      scrollTo({ top: 0 });
      head.current?.focus();
    }
  }, [name]);
  const close = () => walk({ loop: "", day: "" });
  const windows = history?.loop === name ? history.windows : [];
  const day = windows.find((window) => window.day === at.value.day) ?? windows[windows.length - 1];
  const place = day ? windows.indexOf(day) : -1;
  const step = (by: number) => {
    const next = windows[place + by];
    if (next) turn({ day: next.day });
  };
  return (
    <section class="panel" aria-labelledby="loop-head" onKeyDown={(event) => event.key === "Escape" && close()}>
      <header class="row">
        <h2 id="loop-head" ref={head} tabIndex={-1}>
          {name}
        </h2>
        {row ? (
          <>
            <span>
              <Tile action={row.action} /> {row.action}
            </span>
            {row.grade ? <Grade name={row.grade} /> : null}
            <span class="soft">{[row.area, row.unit, row.type].filter(Boolean).join(" · ")}</span>
          </>
        ) : null}
        <button type="button" class="close" onClick={close}>
          {w.loop.close}
        </button>
      </header>
      {row?.override ? (
        <p class="overruled">
          <b>{w.overruled}</b> {row.override_reason}
        </p>
      ) : null}
      {wrong ? <p class="wrong">{wrong}</p> : null}
      {row && history?.loop === name ? <Facts row={row} upstream={history.upstream} /> : null}
      {windows.length > 0 && history ? (
        <>
          <h3>{w.loop.history}</h3>
          <HistoryChart of={history} day={day?.day ?? ""} choose={(chosen) => turn({ day: chosen })} />
        </>
      ) : null}
      {day ? (
        <>
          <div class="row days">
            <h3>
              {w.loop.trend}: {day.day}
            </h3>
            <button type="button" disabled={place <= 0} onClick={() => step(-1)}>
              ← {w.loop.previous}
            </button>
            <button type="button" disabled={place >= windows.length - 1} onClick={() => step(1)}>
              {w.loop.next} →
            </button>
          </div>
          <TrendOfDay loop={name} day={day.day} days={day.days} stamp={stamp.value} />
          <h3>{w.loop.verdict}</h3>
          {day.row.error ? (
            <p class="wrong">
              {w.loop.error}: {day.row.error}
            </p>
          ) : null}
          <Verdict loop={name} day={day.day} days={day.days} />
        </>
      ) : null}
      <h3>{w.loop.said}</h3>
      {history?.loop === name && history.entries.length > 0 ? (
        <ul class="entries">
          {[...history.entries].reverse().map(({ entry, words }, k) => (
            <li key={k}>
              <b class={`event ${entry.kind}`}>{t.plant.forms.kinds[entry.kind]}</b> {words}
            </li>
          ))}
        </ul>
      ) : (
        <p class="soft">{w.loop.nothing}</p>
      )}
      <Forms key={name} loop={name} day={day?.day ?? ""} />
    </section>
  );
}
