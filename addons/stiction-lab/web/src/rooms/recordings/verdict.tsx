// What is said of a stretch: the card, two of them side by side, and all the rest on demand. The words are the library's.
import { useEffect, useState } from "preact/hooks";
import { type Answer, call, type Wrong } from "../../api";
import { t } from "../../texts";
import { type Clock, lasting } from "./samples";

const w = t.recordings.verdict;
export type Judgement = Answer<"recordings/diagnose">;
type FirstScreen = Judgement["first_screen"];
type Details = Answer<"recordings/details">;
type Piece = Details["pieces"][number];

/** Which stretch of which loop. */
export interface Place {
  file: string;
  loop: string;
  from: number | null;
  to: number | null;
}

/** A verdict that is kept to be compared. */
export interface Kept {
  place: Place;
  judgement: Judgement;
}

/** A number stays with its percent. */
function bound(text: string): string {
  return text.replace(/ %/g, "\u00a0%");
}

export function Badge({ of }: { of: FirstScreen["badge"] }) {
  return (
    <span class={`badge ${of.tone}`}>
      <span aria-hidden="true">{of.symbol}</span> {of.word}
    </span>
  );
}

function Facts({ facts }: { facts: { name: string; value: string; unit: string }[] }) {
  if (facts.length === 0) return null;
  return (
    <dl class="facts">
      {facts.map((fact) => (
        <>
          <dt>{fact.name}</dt>
          <dd>{bound(fact.unit ? `${fact.value}\u00a0${fact.unit}` : fact.value)}</dd>
        </>
      ))}
    </dl>
  );
}

function List({ items, ordered = false }: { items: string[]; ordered?: boolean }) {
  const all = items.map((item) => <li key={item}>{bound(item)}</li>);
  return ordered ? <ol>{all}</ol> : <ul>{all}</ul>;
}

/** The probability as a bar; the words beside it say the same. */
function Likelihood({ p, words }: { p: number; words: string }) {
  return (
    <div class="likelihood">
      <span class="bar" aria-hidden="true">
        <span style={{ width: `${100 * Math.min(Math.max(p, 0.01), 0.99)}%` }} />
      </span>
      <span>
        {w.probability}: <strong>{bound(words)}</strong>
      </span>
    </div>
  );
}

/** The verdict on the stretch. */
export function Card(props: { judgement: Judgement; where: string; busy: boolean }) {
  const { first_screen: screen, diagnosis } = props.judgement;
  const p = diagnosis.verdict.probability;
  // What is not known is said, too.
  const unknown = (["S", "J"] as const)
    .filter((name) => !screen.facts.some((fact) => fact.name.startsWith(`${name},`)))
    .map((name) => ({ name: w[name], value: w.notKnown, unit: "" }));
  const why = diagnosis.stiction.why_not;
  const tone = screen.badge.tone;
  return (
    <div class={`card verdict ${tone} ${props.busy ? "busy" : ""}`} aria-busy={props.busy}>
      <div class="first">
        <Badge of={screen.badge} />
        <h2>{props.where}</h2>
      </div>
      <p class="headline" role="status">
        {bound(screen.headline)}
      </p>
      {screen.overruled && <p class="overruled">{screen.overruled}</p>}
      {p !== null && p !== undefined && screen.probability && <Likelihood p={p} words={screen.probability} />}
      <Facts facts={[...unknown, ...screen.facts].sort(bySign)} />
      {unknown.length > 1 && why && <p class="soft">{w.because(why)}</p>}
      {screen.actions.length > 0 && (
        <>
          <h3>{w.actions}</h3>
          <List ordered={screen.actions.length > 1} items={screen.actions} />
        </>
      )}
    </div>
  );
}

/** S before J before all else. */
function bySign(a: { name: string }, b: { name: string }): number {
  const place = ({ name }: { name: string }) => (name.startsWith("S,") ? 0 : name.startsWith("J,") ? 1 : 2);
  return place(a) - place(b);
}

/** What the verdict rests on. */
export function Evidence({ judgement: { first_screen: screen, diagnosis } }: { judgement: Judgement }) {
  const notes = [...screen.remarks.slice(1), ...diagnosis.notes];
  return (
    <section class="evidence" aria-label={w.evidence}>
      {screen.sides.map((side) => (
        <div key={side.heading}>
          <h3>{side.heading}</h3>
          <List items={side.reasons} />
        </div>
      ))}
      {screen.causes.length > 0 && (
        <>
          <h3>{w.causes}</h3>
          <Facts facts={screen.causes.map(({ cause, likelihood }) => ({ name: cause, value: likelihood, unit: "" }))} />
        </>
      )}
      <h3>{screen.remarks[0] ?? w.data}</h3>
      {notes.length > 0 && <List items={notes} />}
    </section>
  );
}

/** Verdicts beside each other: what was kept, and the present one. */
export function Compare(props: {
  kept: Kept[];
  present: Kept | null;
  name(place: Place): string;
  onGo(place: Place): void;
  onDrop(k: number): void;
}) {
  const all = [...props.kept, ...(props.present ? [props.present] : [])];
  const names: string[] = [];
  for (const { judgement } of all) {
    for (const { name } of judgement.first_screen.facts) if (!names.includes(name)) names.push(name);
  }
  const fact = (screen: FirstScreen, name: string) => {
    const found = screen.facts.find((each) => each.name === name);
    return found ? (found.unit ? `${found.value}\u00a0${found.unit}` : found.value) : "–";
  };
  return (
    <section class="card compare" aria-label={w.compareTitle}>
      <h2>{w.compareTitle}</h2>
      <div class="rows" tabIndex={0} role="region" aria-label={w.compareTitle}>
        <table>
          <thead>
            <tr>
              <td />
              {all.map((each, k) => (
                <th scope="col" key={k}>
                  {k < props.kept.length ? (
                    <>
                      <button type="button" class="plain" onClick={() => props.onGo(each.place)} title={w.goTo}>
                        {props.name(each.place)}
                      </button>
                      <button type="button" class="plain drop" aria-label={w.dropKept(props.name(each.place))} onClick={() => props.onDrop(k)}>
                        ×
                      </button>
                    </>
                  ) : (
                    <>
                      {props.name(each.place)} <span class="soft">{w.present}</span>
                    </>
                  )}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            <tr>
              <th scope="row">{w.verdict}</th>
              {all.map(({ judgement }, k) => (
                <td key={k}>
                  <Badge of={judgement.first_screen.badge} />
                </td>
              ))}
            </tr>
            <tr>
              <th scope="row">{w.probability}</th>
              {all.map(({ judgement }, k) => (
                <td key={k}>{judgement.first_screen.probability ?? "–"}</td>
              ))}
            </tr>
            {names.map((name) => (
              <tr key={name}>
                <th scope="row">{name}</th>
                {all.map(({ judgement }, k) => (
                  <td key={k}>{fact(judgement.first_screen, name)}</td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}

function Pieces({ pieces }: { pieces: Piece[] }) {
  return (
    <>
      {pieces.map((piece, k) => (
        <One key={k} piece={piece} />
      ))}
    </>
  );
}

function Picture({ svg, caption }: { svg: string; caption: string }) {
  return (
    <figure class="picture">
      <div class="sheet" tabIndex={0} role="region" aria-label={caption || w.picture}>
        <img src={`data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`} alt={caption || w.picture} />
      </div>
      {caption && <figcaption class="soft">{caption}</figcaption>}
    </figure>
  );
}

/** A table of the report. */
export function Rows({ table }: { table: Extract<Piece, { is: "table" }>["table"] }) {
  return (
    <div class="rows" tabIndex={0} role="region" aria-label={table.caption || w.table}>
      <table>
        {table.caption && <caption>{table.caption}</caption>}
        <thead>
          <tr>
            {table.columns.map((column, k) => (
              <th key={k} scope="col" class={column.number ? "number" : ""}>
                {column.name}
                {column.unit && <span class="soft"> ({column.unit})</span>}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {table.rows.map((row, k) => (
            <tr key={k}>
              {row.map((cell, c) => (
                <td key={c} class={table.columns[c]?.number ? "number" : ""}>
                  {cell}
                </td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function One({ piece }: { piece: Piece }) {
  switch (piece.is) {
    case "heading":
      return <h3>{piece.text}</h3>;
    case "paragraph":
      return <p>{piece.text}</p>;
    case "list":
      return <List items={piece.items} ordered={piece.ordered} />;
    case "facts":
      return <Facts facts={piece.facts} />;
    case "picture":
      return <Picture svg={piece.svg} caption={piece.caption} />;
    case "details":
      return (
        <details>
          <summary>{piece.summary}</summary>
          <Pieces pieces={piece.pieces} />
        </details>
      );
    case "card":
      return (
        <details class="card method">
          <summary>
            {piece.heading} {piece.badge && <Badge of={piece.badge} />} <span class="soft">{piece.sentence}</span>
          </summary>
          {piece.caveats.length > 0 && <List items={piece.caveats} />}
          <Pieces pieces={piece.pieces} />
          <Facts facts={piece.facts} />
        </details>
      );
    case "table":
      return <Rows table={piece.table} />;
  }
}

/** All that the report tells beyond the card; each part is made when it is opened. */
export function More({ of }: { of: Place }) {
  const ask = { file: of.file, loop: of.loop, from: of.from, to: of.to };
  const key = JSON.stringify(ask);
  const [folds, setFolds] = useState<{ key: string; names: string[]; wrong?: string } | null>(null);
  const [open, setOpen] = useState(false);
  const [inside, setInside] = useState<Record<string, Piece[] | string>>({});
  useEffect(() => {
    if (!open || folds?.key === key) return;
    const gone = new AbortController();
    const later = setTimeout(() => {
      call("recordings/details", { of: ask }, gone.signal)
        .then((found) => setFolds({ key, names: found.folds }))
        .catch((wrong: Wrong) => !gone.signal.aborted && setFolds({ key, names: [], wrong: wrong.message }));
    }, 300);
    setInside({});
    return () => {
      clearTimeout(later);
      gone.abort();
    };
  }, [open, key]);
  const load = (fold: number) => {
    const slot = `${key}${fold}`;
    if (inside[slot]) return;
    call("recordings/details", { of: ask, fold })
      .then((found) => setInside((now) => ({ ...now, [slot]: found.pieces })))
      .catch((wrong: Wrong) => setInside((now) => ({ ...now, [slot]: wrong.message })));
  };
  const fresh = folds?.key === key;
  return (
    <details class="card more" onToggle={(event) => setOpen((event.currentTarget as HTMLDetailsElement).open)}>
      <summary>{w.more}</summary>
      {folds?.wrong && fresh && <p class="wrong">{folds.wrong}</p>}
      {open && !fresh && <p class="soft">{w.working}</p>}
      {fresh &&
        folds.names.map((name, fold) => {
          const pieces = inside[`${key}${fold}`];
          return (
            <details
              key={`${key}${name}`}
              class="fold"
              onToggle={(event) => (event.currentTarget as HTMLDetailsElement).open && load(fold)}
            >
              <summary>{name}</summary>
              {pieces === undefined && <p class="soft">{w.working}</p>}
              {typeof pieces === "string" && <p class="wrong">{pieces}</p>}
              {Array.isArray(pieces) && <Pieces pieces={pieces} />}
            </details>
          );
        })}
    </details>
  );
}

/** A stretch in a few words. */
export function named(place: Place, clock: Clock | null): string {
  if (place.from === null && place.to === null) return `${place.loop}, ${w.whole}`;
  const [a, b] = [place.from ?? 0, place.to ?? 0];
  return `${place.loop}, ${clock ? clock.span(a, b) : `${lasting(a)} – ${lasting(b)}`}`;
}
