// The ranking: a row a loop, of which only those are made that can be seen.
import { useComputed, useSignal } from "@preact/signals";
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import { t } from "../../texts";
import { at, limit, NOTHING, page, percent, rough, status, time, turn, walk, way, type At, type Row } from "./state";
import { Grade, Tile } from "./words";

const w = t.plant;
/** Height of a row in rem, as the style has it. */
const HEIGHT = 2.9;
/** Rows that are made beyond those that can be seen. */
const MORE = 12;

type Column = {
  key: keyof typeof w.heads;
  /** What is sorted by; text goes up first, numbers down. */
  by: (row: Row) => number | string | null | undefined;
  cell: (row: Row, place: number) => preact.ComponentChildren;
  number?: boolean;
};

/** A less likely cause is left out, as on the page of the week. */
const LEAST_LIKELY = 0.1;

const cause = (row: Row) => ((row.alternative_likelihood ?? 0) >= LEAST_LIKELY ? row.alternative : null);
const number = (value: number | null | undefined, text = rough) => (value == null ? "–" : text(value));
const COLUMNS: Column[] = [
  {
    key: "name",
    by: (row) => row.loop,
    cell: (row) => (
      <>
        <a href={way({ loop: row.loop, day: "" })}>{row.loop}</a>
        <small>{[row.area ?? status.value?.words.no_area, row.unit].filter(Boolean).join(" · ")}</small>
      </>
    ),
  },
  {
    key: "action",
    by: (row) => status.value?.words.actions.findIndex((word) => word.name === row.action),
    cell: (row) => (
      <>
        <Tile action={row.action} /> <span class="word">{row.action}</span>
      </>
    ),
  },
  { key: "priority", number: true, by: (row) => row.priority, cell: (row) => number(row.priority) },
  {
    key: "grade",
    by: (row) => status.value?.words.grades.findIndex((word) => word.name === row.grade),
    cell: (row) => (
      <>
        {row.grade ? <Grade name={row.grade} /> : row.health}
        {row.override ? <small>{w.person(row.override)}</small> : null}
      </>
    ),
  },
  { key: "p", number: true, by: (row) => row.probability, cell: (row) => number(row.probability, percent) },
  {
    key: "s",
    number: true,
    by: (row) => row.S ?? limit(row),
    cell: (row) => (limit(row) != null ? `< ${rough(limit(row)!)}` : number(row.S)),
  },
  { key: "j", number: true, by: (row) => row.J, cell: (row) => number(row.J) },
  {
    key: "change",
    by: (row) => status.value?.words.changes.indexOf(row.change),
    cell: (row) =>
      row.change === "none" ? null : (
        <>
          <b class={`change ${row.change}`}>{row.change}</b>
          <small>{row.change_day}</small>
        </>
      ),
  },
  { key: "spark", by: () => null, cell: (_, place) => <Spark place={place} /> },
  {
    key: "drift",
    number: true,
    by: (row) => row.drift_per_week,
    cell: (row) => {
      if (row.drift_per_week == null) return "–";
      const text = `${row.drift_per_week > 0 ? "+" : ""}${rough(row.drift_per_week)}`;
      return row.drift_significant ? <b>{text}</b> : <span class="soft">{text}</span>;
    },
  },
  { key: "auto", number: true, by: (row) => row.auto_share, cell: (row) => number(row.auto_share, (v) => v.toFixed(0)) },
  { key: "travel", number: true, by: (row) => row.travel_per_hour, cell: (row) => number(row.travel_per_hour) },
  {
    key: "cause",
    by: cause,
    cell: (row) => (
      <>
        {cause(row)}
        {row.period_s == null ? null : <small>{w.every(time(row.period_s))}</small>}
      </>
    ),
  },
  {
    key: "said",
    by: (row) => said(row),
    cell: (row) => <small title={said(row)}>{said(row)}</small>,
  },
];

/** What people said of a loop, and its group, in a line. */
function said(row: Row): string {
  return [
    row.snoozed_until ? `${w.lists.snoozed} ${w.snoozed(row.snoozed_until)}` : "",
    row.watch ? w.lists.watched : "",
    row.group == null ? "" : w.loop.group(row.group, row.candidate_rank ?? null),
    row.override_reason ?? "",
    row.note ?? "",
    row.error ?? "",
  ]
    .filter(Boolean)
    .join("; ");
}

function Spark(props: { place: number }) {
  const of = page.value?.sparks[props.place];
  const [width, height] = page.value?.spark_size ?? [84, 22];
  if (!of || !(of.probability || of.S)) return null;
  return (
    <svg class="spark" viewBox={`0 0 ${width} ${height}`} width={width} height={height} aria-hidden="true">
      <path class="r" d={of.repairs} />
      <path class="p" d={of.probability} />
      <path class="s" d={of.S} />
    </svg>
  );
}

/** The places of the rows that are shown, in their order. */
export function chosen(rows: readonly Row[], of: At): number[] {
  const words = of.search.toLowerCase().split(/\s+/).filter(Boolean);
  const no = status.value?.words.no_area;
  const places: number[] = [];
  rows.forEach((row, place) => {
    const snoozed = row.snoozed_until != null;
    if (of.action && row.action !== of.action) return;
    if (of.change && row.change !== of.change) return;
    if (of.list === "open" ? snoozed : of.list === "watched" ? !row.watch : of.list === "snoozed" && !snoozed) return;
    if (of.area && (row.area ?? no) !== of.area) return;
    if (of.unit && row.unit !== of.unit) return;
    if (of.health && row.health !== of.health) return;
    if (words.length > 0) {
      const text = [row.loop, row.area, row.unit, row.type, row.action, row.grade, row.alternative, said(row)]
        .join(" ")
        .toLowerCase();
      if (!words.every((word) => text.includes(word))) return;
    }
    places.push(place);
  });
  const column = COLUMNS.find((each) => each.key === of.sort);
  if (column) {
    const keys = rows.map((row) => column.by(row));
    const way = of.down ? -1 : 1;
    places.sort((a, b) => {
      const [x, y] = [keys[a] ?? "", keys[b] ?? ""];
      // What is not known is last, either way.
      if (x === "" || y === "") return (x === "" ? 1 : 0) - (y === "" ? 1 : 0) || a - b;
      const sign = typeof x === "string" ? x.localeCompare(String(y)) : x - Number(y);
      return way * sign || a - b;
    });
  }
  return places;
}

function Choice(props: { of: "action" | "change" | "list" | "area" | "unit" | "health"; options: [string, string][] }) {
  const value = at.value[props.of];
  const options = props.options.some(([key]) => key === value) ? props.options : [...props.options, [value, value]];
  return (
    <label class={`${props.of === "list" || props.of === "area" ? "" : "extra"}${value ? " used" : ""}`}>
      {w.filters[props.of]}
      <select value={value} onChange={(event) => turn({ [props.of]: event.currentTarget.value })}>
        {options.map(([key, text]) => (
          <option key={key} value={key}>
            {text}
          </option>
        ))}
      </select>
    </label>
  );
}

/** What narrows the list down. */
function Filters(props: { shown: number }) {
  const rows = page.value?.loops ?? [];
  const count = (is: (row: Row) => boolean) => rows.filter(is).length;
  const words = status.value?.words;
  const no = words?.no_area ?? "";
  const areas = [...new Set(rows.map((row) => row.area ?? no))].sort();
  const units = [...new Set(rows.filter((row) => !at.value.area || (row.area ?? no) === at.value.area).map((row) => row.unit))]
    .filter((unit): unit is string => unit != null)
    .sort();
  const any: [string, string] = ["", w.all];
  const is = (Object.keys(NOTHING) as (keyof typeof NOTHING)[]).some((key) => at.value[key] !== NOTHING[key]);
  return (
    <>
      <div class="chips" role="group" aria-label={w.filters.action}>
        {words?.actions.map((word) => {
          const loops = count((row) => row.action === word.name);
          return loops === 0 ? null : (
            <button
              type="button"
              key={word.name}
              aria-pressed={at.value.action === word.name}
              onClick={() => turn({ action: at.value.action === word.name ? "" : word.name })}
            >
              <Tile action={word.name} /> {word.name} <span class="count">{loops}</span>
            </button>
          );
        })}
      </div>
      <div class="filters">
        <label class="search">
          {w.search}
          <input
            type="search"
            value={at.value.search}
            placeholder={w.searchHint}
            onInput={(event) => turn({ search: event.currentTarget.value })}
          />
        </label>
        <Choice
          of="list"
          options={[
            ["open", w.lists.open],
            ["watched", w.lists.watched],
            ["snoozed", `${w.lists.snoozed} (${count((row) => row.snoozed_until != null)})`],
            ["", w.lists.every],
          ]}
        />
        <Choice
          of="change"
          options={[any, ...(words?.changes ?? []).filter((word) => word !== "none").map((word): [string, string] => [word, word])]}
        />
        <Choice of="area" options={[any, ...areas.map((area): [string, string] => [area, area])]} />
        <Choice of="unit" options={[any, ...units.map((unit): [string, string] => [unit, unit])]} />
        <Choice of="health" options={[any, ...(words?.health ?? []).map((word): [string, string] => [word, word])]} />
        {is ? (
          <button type="button" onClick={() => turn({ ...NOTHING })}>
            {w.clear}
          </button>
        ) : null}
      </div>
      <p class="soft shown" role="status">
        {w.shown(props.shown, rows.length)}
      </p>
    </>
  );
}

export function List() {
  const rows = page.value?.loops ?? [];
  const places = useComputed(() => chosen(page.value?.loops ?? [], at.value)).value;
  const box = useRef<HTMLDivElement>(null);
  const top = useSignal(0);
  const tall = useSignal(800);
  const wanted = useRef("");
  const rem = parseFloat(getComputedStyle(document.documentElement).fontSize) * HEIGHT;
  const first = Math.max(0, Math.min(places.length - 1, Math.floor(top.value / rem)) - MORE);
  const last = Math.min(places.length, Math.ceil((top.value + tall.value) / rem) + MORE);

  useEffect(() => {
    const of = box.current;
    if (!of) return;
    const sized = new ResizeObserver(() => (tall.value = of.clientHeight));
    sized.observe(of);
    return () => sized.disconnect();
  }, []);
  // Another order begins at its top; the loop that is open stays in sight.
  const order = `${at.value.sort} ${at.value.down} ${at.value.search} ${at.value.action} ${page.value?.week}`;
  useEffect(() => box.current?.scrollTo({ top: 0 }), [order]);
  useLayoutEffect(() => {
    const link = wanted.current && box.current?.querySelector<HTMLElement>(`tr[data-loop="${CSS.escape(wanted.current)}"] a`);
    if (link) {
      wanted.current = "";
      link.focus({ preventScroll: true });
    }
  });

  const sort = (key: string, by: Column) => {
    const down = at.value.sort === key ? !at.value.down : by.number === true;
    turn({ sort: key, down });
  };
  const step = (event: KeyboardEvent) => {
    const by = { ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10 }[event.key];
    const own = (event.target as HTMLElement).closest("tr")?.dataset.loop;
    if (by === undefined || own === undefined || !box.current) return;
    event.preventDefault();
    const now = places.findIndex((place) => rows[place]?.loop === own);
    const next = Math.max(0, Math.min(places.length - 1, now + by));
    wanted.current = rows[places[next] ?? 0]?.loop ?? "";
    const [from, to] = [next * rem, (next + 2) * rem];
    const head = box.current.querySelector("thead")?.clientHeight ?? 0;
    if (from < box.current.scrollTop) box.current.scrollTop = from;
    else if (to + head > box.current.scrollTop + box.current.clientHeight) box.current.scrollTop = to + head - box.current.clientHeight;
    top.value = box.current.scrollTop;
    // It may be there already, and nothing be drawn anew.
    box.current.querySelector<HTMLElement>(`tr[data-loop="${CSS.escape(wanted.current)}"] a`)?.focus({ preventScroll: true });
  };
  return (
    <div class="list">
      <Filters shown={places.length} />
      <div
        class="rows"
        ref={box}
        role="region"
        aria-label={w.table}
        tabIndex={0}
        onScroll={(event) => (top.value = event.currentTarget.scrollTop)}
      >
        <table class="loops" aria-rowcount={places.length + 1}>
          <thead>
            <tr>
              {COLUMNS.map((column) => {
                const [head, title] = w.heads[column.key] ?? ["", ""];
                const sorted = at.value.sort === column.key;
                return (
                  <th
                    scope="col"
                    key={column.key}
                    class={`c-${column.key}${column.number ? " number" : ""}`}
                    aria-sort={sorted ? (at.value.down ? "descending" : "ascending") : undefined}
                    title={title}
                  >
                    {column.key === "spark" ? (
                      head
                    ) : (
                      <button type="button" onClick={() => sort(column.key, column)}>
                        {head}
                        {sorted ? <span aria-hidden="true">{at.value.down ? " ↓" : " ↑"}</span> : null}
                      </button>
                    )}
                  </th>
                );
              })}
            </tr>
          </thead>
          <tbody onKeyDown={step}>
            {first > 0 ? <tr class="space" aria-hidden="true" style={{ height: `${first * rem}px` }} /> : null}
            {places.slice(first, last).map((place, k) => {
              const row = rows[place];
              if (!row) return null;
              return (
                <tr
                  key={row.loop}
                  data-loop={row.loop}
                  aria-rowindex={first + k + 2}
                  class={row.loop === at.value.loop ? "open" : undefined}
                  onClick={(event) => {
                    if (!(event.target as HTMLElement).closest("a") && !getSelection()?.toString()) walk({ loop: row.loop, day: "" });
                  }}
                >
                  {COLUMNS.map((column) =>
                    column.key === "name" ? (
                      <th scope="row" key={column.key} class="c-name">
                        {column.cell(row, place)}
                      </th>
                    ) : (
                      <td key={column.key} class={`c-${column.key}${column.number ? " number" : ""}`}>
                        {column.cell(row, place)}
                      </td>
                    ),
                  )}
                </tr>
              );
            })}
            {last < places.length ? (
              <tr class="space" aria-hidden="true" style={{ height: `${(places.length - last) * rem}px` }} />
            ) : null}
          </tbody>
        </table>
      </div>
      <p class="soft">{w.priority}</p>
    </div>
  );
}
