// The room of a plant: its week as the report tells it, live, and each loop over time.
import { useEffect } from "preact/hooks";
import { call } from "../api";
import { t } from "../texts";
import "./plant.css";
import { List } from "./plant/list";
import { PlantMap } from "./plant/map";
import { Panel } from "./plant/panel";
import { at, lookNow, page, status, VIEWS, walk, watch, way, wrong, type View } from "./plant/state";
import { Areas, Changes, Groups, Health, Orders } from "./plant/views";

const w = t.plant;
const SHOWN: Record<View, () => preact.JSX.Element | null> = {
  loops: List,
  map: PlantMap,
  areas: Areas,
  groups: Groups,
  changes: Changes,
  orders: Orders,
  data: Health,
};

function None() {
  return (
    <section class="card none">
      <h1>{w.none.head}</h1>
      <p>{w.none.how}</p>
      <pre>{w.none.command}</pre>
      <p>{w.none.demo}</p>
      <pre>{w.none.demoCommand}</pre>
    </section>
  );
}

/** Begins a scan, and tells how far it is. */
function Scan() {
  const scan = status.value?.scan;
  if (!scan) return null;
  const ask = async (name: "plant/scan" | "plant/stop") => {
    try {
      await call(name, {});
      wrong.value = "";
    } catch (error) {
      wrong.value = (error as Error).message;
    }
    await lookNow();
  };
  const words = () => {
    if (scan.running) {
      if (scan.stopping) return w.scan.stopping;
      return scan.done == null ? w.scan.looking(scan.looked, scan.files) : w.scan.judging(scan.done, scan.of);
    }
    if (scan.failed) return scan.failed;
    if (scan.stopped) return w.scan.stopped;
    return scan.ended ? w.scan.ended(scan.ended.windows, scan.ended.errors) : "";
  };
  const problems = scan.ended?.problems ?? [];
  return (
    <div class="scan">
      {scan.running ? (
        <>
          <progress
            aria-label={w.scan.label}
            max={Math.max(1, scan.done == null ? scan.files : scan.of)}
            value={scan.done == null ? scan.looked : scan.done}
          />
          <button type="button" disabled={scan.stopping} onClick={() => ask("plant/stop")}>
            {w.scan.stop}
          </button>
        </>
      ) : (
        <button type="button" onClick={() => ask("plant/scan")}>
          {w.scan.begin}
        </button>
      )}
      <span role="status" class={scan.failed ? "wrong" : "soft"}>
        {words()}
      </span>
      {!scan.running && problems.length > 0 ? (
        <details>
          <summary>{w.scan.problems(problems.length)}</summary>
          <ul>
            {problems.slice(0, 50).map((problem, k) => (
              <li key={k}>{[problem.file, problem.loop, problem.message].filter(Boolean).join(": ")}</li>
            ))}
          </ul>
        </details>
      ) : null}
    </div>
  );
}

/** The last events of a plant that is watched, the newest first. */
function Events() {
  const events = status.value?.events ?? [];
  if (events.length === 0) return null;
  return (
    <details class="happened" open>
      <summary>{w.happened(events.length)}</summary>
      <div role="log">
        <ol>
          {events.map((each) => (
            <li key={`${each.at} ${each.event} ${each.loop}`}>
              <time dateTime={each.at}>{each.at.slice(0, 16).replace("T", " ")}</time> {each.event}:{" "}
              <a href={way({ loop: each.loop, day: "" })}>{each.text}</a>
            </li>
          ))}
        </ol>
      </div>
    </details>
  );
}

function Tabs() {
  const of = page.value;
  const good = status.value?.words.health.at(-1);
  const counts: Partial<Record<View, number>> = {
    loops: of?.loops.length ?? 0,
    groups: of?.groups?.length ?? 0,
    changes: of?.loops.filter((row) => row.change !== "none").length ?? 0,
    orders: of?.orders.length ?? 0,
    data: of?.loops.filter((row) => row.health !== good).length ?? 0,
  };
  return (
    <nav class="views" aria-label={w.viewsLabel}>
      {VIEWS.map((view) => (
        <a key={view} href={way({ view })} aria-current={at.value.view === view ? "true" : undefined}>
          {w.views[view]}
          {counts[view] === undefined ? null : <span class="count"> {counts[view]}</span>}
        </a>
      ))}
    </nav>
  );
}

export function Plant() {
  useEffect(watch, []);
  const now = status.value;
  const of = page.value;
  if (!now) return <p role="status">{wrong.value || w.loading}</p>;
  if (!now.folder) return <None />;
  const View = SHOWN[at.value.view];
  const judged = of?.loops.filter((row) => row.windows_judged > 0).length ?? 0;
  return (
    <div class={`plant-room${at.value.loop ? " with-panel" : ""}`}>
      <header class="plant-head">
        <h1>{now.plant ?? now.folder}</h1>
        {now.weeks.length > 0 ? (
          <label>
            {w.week}{" "}
            <select value={at.value.week || (of?.week ?? "")} onChange={(event) => walk({ week: event.currentTarget.value === now.weeks[0] ? "" : event.currentTarget.value, day: "" })}>
              {now.weeks.map((week) => (
                <option key={week} value={week}>
                  {week}
                </option>
              ))}
            </select>
          </label>
        ) : null}
        {of ? (
          <span class="soft">
            {w.days(of.first_day, of.last_day)} · {w.counts(of.loops.length, judged)}
          </span>
        ) : null}
        <Scan />
      </header>
      {now.wrong ? <p class="wrong">{now.wrong}</p> : null}
      {wrong.value ? (
        <p class="wrong" role="alert">
          {wrong.value}
        </p>
      ) : null}
      <Events />
      {now.weeks.length === 0 && !now.wrong ? <p>{w.unscanned}</p> : null}
      {of && !of.groups && !of.groups_wrong ? <p class="soft">{w.seeking}</p> : null}
      {of ? (
        <div class="plant-body">
          <div class="plant-view">
            <Tabs />
            <View />
          </div>
          {at.value.loop ? <Panel /> : null}
        </div>
      ) : now.weeks.length > 0 && !wrong.value ? (
        <p role="status">{w.loading}</p>
      ) : null}
    </div>
  );
}
