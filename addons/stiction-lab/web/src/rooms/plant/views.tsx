// Areas, groups, changes, work orders and the health of the data.
import { t } from "../../texts";
import { NOTHING, page, percent, status, time, way, type Row } from "./state";
import { Loop } from "./words";

const w = t.plant;

type Count = { loops: number; judged: number; actions: Map<string, number> };

function counted(rows: readonly Row[]): Count {
  const actions = new Map<string, number>();
  for (const row of rows) actions.set(row.action, (actions.get(row.action) ?? 0) + 1);
  return { loops: rows.length, judged: rows.filter((row) => row.windows_judged > 0).length, actions };
}

function grouped(rows: readonly Row[], by: (row: Row) => string): Map<string, Row[]> {
  const of = new Map<string, Row[]>();
  for (const row of rows) {
    const own = of.get(by(row));
    if (own) own.push(row);
    else of.set(by(row), [row]);
  }
  return of;
}

/** A place of the plant: its loops by what to do, as a bar, and in words. */
function Place(props: { name: string; rows: readonly Row[]; to: string; most: number }) {
  const of = counted(props.rows);
  const actions = status.value?.words.actions ?? [];
  const repair = of.actions.get(actions[0]?.name ?? "") ?? 0;
  const words = actions.map((word) => `${of.actions.get(word.name) ?? 0} ${word.name}`).join(", ");
  return (
    <>
      <a href={props.to}>{props.name}</a>
      <span class="bar" role="img" aria-label={w.areas.bar(words)} title={words}>
        {actions.map((word) => (
          <span key={word.name} class={`tile ${word.symbol}`} style={{ width: `${(100 * (of.actions.get(word.name) ?? 0)) / props.most}%` }} />
        ))}
      </span>
      <span class="soft">{w.areas.counts(of.loops, of.judged, repair)}</span>
    </>
  );
}

export function Areas() {
  const rows = page.value?.loops ?? [];
  const no = status.value?.words.no_area ?? "";
  const areas = grouped(rows, (row) => row.area ?? no);
  const names = [...areas.keys()].sort();
  const most = Math.max(1, ...[...areas.values()].map((own) => own.length));
  const to = (area: string, unit: string) => way({ ...NOTHING, view: "loops", list: "", area, unit });
  return (
    <div class="areas">
      <p class="soft">{w.areas.hint}</p>
      <ul>
        {names.map((area) => {
          const own = areas.get(area) ?? [];
          const units = grouped(own, (row) => row.unit ?? "");
          return (
            <li key={area}>
              <div class="place">
                <Place name={area} rows={own} to={to(area, "")} most={most} />
              </div>
              <ul>
                {[...units.keys()]
                  .filter(Boolean)
                  .sort()
                  .map((unit) => (
                    <li key={unit} class="place">
                      <Place name={unit} rows={units.get(unit) ?? []} to={to(area, unit)} most={most} />
                    </li>
                  ))}
              </ul>
            </li>
          );
        })}
      </ul>
    </div>
  );
}

export function Groups() {
  const groups = page.value?.groups;
  if (page.value?.groups_wrong) return <p class="wrong">{w.groups.wrong(page.value.groups_wrong)}</p>;
  if (!groups) return <p role="status">{w.seeking}</p>;
  if (groups.length === 0) return <p>{w.groups.none}</p>;
  return (
    <>
      <p class="soft">{w.groups.promise}</p>
      <div class="grid cards">
        {groups.map((group) => {
          const candidates = group.members.filter((member) => member.candidate_rank != null);
          const others = group.members.filter((member) => member.candidate_rank == null);
          return (
            <section class="card" key={group.id} id={`group-${group.id}`} aria-labelledby={`group-${group.id}-head`}>
              <h2 id={`group-${group.id}-head`}>{w.groups.title(group.id, time(group.period_s))}</h2>
              <p>{group.reasons.join(" ")}</p>
              {group.source === "not-recorded" ? (
                <p>
                  <b>{w.groups.notRecorded}</b>
                </p>
              ) : (
                <>
                  <p>{w.groups.candidates}</p>
                  <ol>
                    {candidates.map((member) => (
                      <li key={member.loop}>
                        <Loop name={member.loop} /> <span class="soft">{w.groups.coherence(`${percent(member.coherence)} %`)}</span>
                        <br />
                        {member.reasons.join(" ")}
                      </li>
                    ))}
                  </ol>
                </>
              )}
              {others.length > 0 ? (
                <p>
                  {group.source === "not-recorded" ? "" : `${w.groups.others} `}
                  {others.map((member, k) => (
                    <>
                      {k > 0 ? ", " : ""}
                      <Loop name={member.loop} />
                    </>
                  ))}
                </p>
              ) : null}
            </section>
          );
        })}
      </div>
    </>
  );
}

export function Changes() {
  const order = status.value?.words.changes ?? [];
  const changed = (page.value?.loops ?? []).filter((row) => row.change !== "none");
  const sorted = [...changed].sort((a, b) => order.indexOf(a.change) - order.indexOf(b.change));
  return (
    <>
      <p class="soft">{w.changes.hint}</p>
      {sorted.length === 0 ? <p>{w.changes.none}</p> : null}
      <ul class="changes">
        {sorted.map((row) => (
          <li key={row.loop}>
            <b class={`change ${row.change}`}>{row.change}</b> <Loop name={row.loop} />{" "}
            <span class="soft">
              {row.change_day ? w.changes.since(row.change_day) : ""}
              {row.verdict_before && row.grade ? `; ${w.changes.from(row.verdict_before, row.grade)}` : ""}
            </span>
          </li>
        ))}
      </ul>
    </>
  );
}

export function Orders() {
  const orders = page.value?.orders ?? [];
  if (orders.length === 0) return <p>{w.orders.none}</p>;
  return (
    <div class="grid cards">
      {orders.map((order) => (
        <section class="card order" key={order.loop} aria-label={order.loop}>
          <p>
            <b>
              <Loop name={order.loop} />
            </b>{" "}
            <span class="soft">{[order.area, order.unit].filter(Boolean).join(" · ")}</span>
          </p>
          <p>{order.finding}.</p>
          <p>
            <span class="soft">{w.orders.evidence}:</span> {order.evidence}.
          </p>
          <p>
            <span class="soft">{w.orders.test}:</span> {order.test}.
          </p>
          {order.note ? <p class="soft">{order.note}</p> : null}
        </section>
      ))}
    </div>
  );
}

export function Health() {
  const rows = page.value?.loops ?? [];
  const kinds = status.value?.words.health ?? [];
  const good = kinds[kinds.length - 1];
  const bad = kinds.filter((kind) => kind !== good && rows.some((row) => row.health === kind));
  if (bad.length === 0) return <p>{w.data.fine}</p>;
  return (
    <div class="grid cards">
      {bad.map((kind) => {
        const own = rows.filter((row) => row.health === kind);
        return (
          <section class="card" key={kind} aria-label={kind}>
            <h2>
              {kind} <a href={way({ ...NOTHING, view: "loops", list: "", health: kind })}>{w.data.loops(own.length)}</a>
            </h2>
            <ul class="plain">
              {own.slice(0, 12).map((row) => (
                <li key={row.loop}>
                  <Loop name={row.loop} /> <span class="soft">{row.error ?? ""}</span>
                </li>
              ))}
            </ul>
          </section>
        );
      })}
    </div>
  );
}
