// The room of recordings: what is open, the trend, a stretch of it, and the verdict that follows.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { go, link, remember, state } from "../address";
import { type Answer, bytes, call, Latest, send, type Wrong } from "../api";
import { t } from "../texts";
import "./recordings.css";
import { Columns, type Opened } from "./recordings/columns";
import { PvOverOp } from "./recordings/map";
import { Override } from "./recordings/override";
import { Clock, lasting, place, type Samples, samplesOf } from "./recordings/samples";
import { ends, type Span, Trend } from "./recordings/trend";
import { Card, Compare, Evidence, type Judgement, type Kept, More, named, type Place } from "./recordings/verdict";

const w = t.recordings;
type List = Answer<"recordings">;
type Entry = List["files"][number];

/** Files that are opened unasked, so that their loops can be listed. */
const UNASKED = 60;
/** From so many on the list is searched. */
const SEARCHED = 8;
const MOST_KEPT = 4;

function number(text: string | null): number | null {
  const value = text === null || text === "" ? NaN : Number(text);
  return Number.isFinite(value) ? value : null;
}

function span(params: URLSearchParams, a: string, b: string): Span | null {
  const [from, to] = [number(params.get(a)), number(params.get(b))];
  return from !== null && to !== null && from < to ? [from, to] : null;
}

function keptIn(params: URLSearchParams): Place[] {
  try {
    const found: unknown = JSON.parse(params.get("with") ?? "[]");
    return Array.isArray(found) ? (found as Place[]).slice(0, MOST_KEPT) : [];
  } catch {
    return [];
  }
}

export function Recordings() {
  const [list, setList] = useState<List | null>(null);
  const [wrong, setWrong] = useState("");
  const [busy, setBusy] = useState("");
  const [over, setOver] = useState(false);
  const [kept, setKept] = useState<Kept[]>([]);
  const params = state.value;
  const file = params.get("file") ?? list?.files.find((each) => !each.failure)?.id ?? list?.files[0]?.id ?? null;

  const refresh = () =>
    call("recordings", {})
      .then((found) => (setList(found), found))
      .catch((error: Wrong) => (setWrong(error.message), null));

  // What is open; then, one by one, what is in it.
  useEffect(() => {
    let gone = false;
    void (async () => {
      const found = await refresh();
      const unread = found?.files.filter((each) => !each.loops && !each.failure).slice(0, UNASKED) ?? [];
      if (unread.length < 2) return;
      for (const each of unread) {
        if (gone) return;
        await call("recordings/open", { file: each.id }).catch(() => undefined);
      }
      if (!gone) await refresh();
    })();
    return () => {
      gone = true;
    };
  }, []);

  // Verdicts that the address says are kept.
  useEffect(() => {
    for (const each of keptIn(params)) {
      call("recordings/diagnose", { file: each.file, loop: each.loop, from: each.from, to: each.to })
        .then((judgement) =>
          setKept((now) => (now.some((k) => JSON.stringify(k.place) === JSON.stringify(each)) ? now : [...now, { place: each, judgement }])),
        )
        .catch((error: Wrong) => setWrong(error.message));
    }
  }, []);

  const take = async (files: Iterable<File>) => {
    setWrong("");
    let last: Entry | null = null;
    for (const each of files) {
      if (list && each.size > list.most_dropped) {
        setWrong(w.tooLarge(each.name, Math.round(list.most_dropped / 1048576)));
        continue;
      }
      setBusy(w.opening(each.name));
      try {
        last = await send<Entry>(`/api/recordings/upload?name=${encodeURIComponent(each.name)}`, each);
        await call("recordings/open", { file: last.id }).catch(() => undefined);
      } catch (error) {
        setWrong((error as Wrong).message);
      }
    }
    setBusy("");
    await refresh();
    if (last) go("recordings", [["file", last.id]]);
  };
  const taking = useRef(take);
  taking.current = take;
  useEffect(() => {
    const drag = (event: DragEvent) => {
      if (!event.dataTransfer?.types.includes("Files")) return;
      event.preventDefault();
      setOver(true);
    };
    const leave = (event: DragEvent) => {
      if (event.relatedTarget === null) setOver(false);
    };
    const drop = (event: DragEvent) => {
      setOver(false);
      if (!event.dataTransfer?.files.length) return;
      event.preventDefault();
      void taking.current([...event.dataTransfer.files]);
    };
    addEventListener("dragover", drag);
    addEventListener("dragleave", leave);
    addEventListener("drop", drop);
    return () => {
      removeEventListener("dragover", drag);
      removeEventListener("dragleave", leave);
      removeEventListener("drop", drop);
    };
  }, []);
  const example = async () => {
    try {
      const entry = await call("recordings/example", {});
      await call("recordings/open", { file: entry.id });
      await refresh();
      go("recordings", [["file", entry.id]]);
    } catch (error) {
      setWrong((error as Wrong).message);
    }
  };
  const choose = (
    <label class="button choose">
      {w.choose}
      <input
        type="file"
        multiple
        accept=".csv,.tsv,.txt,.parquet,.pq,.mat,.h5,.xlsx,.xlsm,.xlsb,.xls,.ods,.gz"
        onChange={(event) => {
          const input = event.currentTarget as HTMLInputElement;
          void take([...(input.files ?? [])]).then(() => (input.value = ""));
        }}
      />
    </label>
  );
  const messages = (
    <>
      {busy && <p role="status">{busy}</p>}
      {wrong && (
        <p class="wrong" role="alert">
          {wrong}
        </p>
      )}
    </>
  );

  if (!list) return <>{messages || <p class="soft">{w.reading}</p>}</>;
  if (list.files.length === 0) {
    return (
      <div class={`recordings first-use ${over ? "over" : ""}`}>
        <h1>{w.title}</h1>
        <div class="dropzone">
          <p class="large">{w.drop}</p>
          <div class="row">
            {choose}
            <button type="button" class="main" onClick={() => void example()}>
              {w.example}
            </button>
          </div>
          {messages}
          <p class="soft">{w.needs}</p>
          <p class="soft">
            {w.orStart} <code>stiction lab FIC101.csv plant/</code>
          </p>
          <p class="soft">{w.stays}</p>
        </div>
      </div>
    );
  }
  const drop = (id: string) => {
    call("recordings/close", { file: id })
      .then((found) => {
        setList(found);
        if (id === file) go("recordings");
      })
      .catch((error: Wrong) => setWrong(error.message));
  };
  return (
    <div class={`recordings ${over ? "over" : ""}`}>
      <aside>
        <Open list={list} file={file} loop={params.get("loop")} onClose={drop} />
        <div class="row">{choose}</div>
        <p class="soft">{w.dropMore}</p>
        {messages}
      </aside>
      {file && <OfFile key={file} file={file} list={list} kept={kept} setKept={setKept} onRead={() => void refresh()} />}
    </div>
  );
}

/** What is open. */
function Open(props: { list: List; file: string | null; loop: string | null; onClose(id: string): void }) {
  const [search, setSearch] = useState("");
  const rows = props.list.files.flatMap((file) =>
    (file.loops ?? [null]).map((loop) => ({ file, loop, alone: (file.loops ?? []).length < 2 })),
  );
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  const found = rows.filter(({ file, loop }) => {
    const text = `${loop ?? ""} ${file.name} ${file.folder}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
  const first = (id: string) => rows.find((row) => row.file.id === id)?.loop ?? null;
  return (
    <nav class="open" aria-label={w.open}>
      <h2>{w.openCount(rows.filter(({ file }) => !file.failure).length)}</h2>
      {rows.length > SEARCHED && (
        <input
          type="search"
          aria-label={w.search}
          placeholder={w.search}
          value={search}
          onInput={(event) => setSearch((event.target as HTMLInputElement).value)}
        />
      )}
      <ul>
        {found.map(({ file, loop, alone }) => {
          const name = loop ?? file.name;
          const here = file.id === props.file && (alone || (props.loop ?? first(file.id)) === loop);
          const to: [string, string][] = [["file", file.id]];
          if (loop !== null) to.push(["loop", loop]);
          return (
            <li key={`${file.id} ${loop}`}>
              <a href={link("recordings", to)} aria-current={here ? "true" : undefined} title={file.dropped ? file.name : file.id}>
                {name}
                {file.failure ? <span class="failed"> ({w.notRead})</span> : !file.name.startsWith(name) && <span class="soft"> {file.name}</span>}
              </a>
              {file.dropped && alone && (
                <button type="button" class="plain" aria-label={w.close(file.name)} title={w.close(file.name)} onClick={() => props.onClose(file.id)}>
                  ×
                </button>
              )}
            </li>
          );
        })}
      </ul>
      {found.length === 0 && <p class="soft">{w.noneFound}</p>}
    </nav>
  );
}

interface FileProps {
  file: string;
  list: List;
  kept: Kept[];
  setKept(next: (now: Kept[]) => Kept[]): void;
  onRead(): void;
}

function OfFile(props: FileProps) {
  const { file, list } = props;
  const [opened, setOpened] = useState<Opened | null>(null);
  const [wrong, setWrong] = useState("");
  const [said, setSaid] = useState("");
  const [version, setVersion] = useState(0);
  useEffect(() => {
    call("recordings/open", { file })
      .then((found) => {
        setOpened(found);
        props.onRead();
      })
      .catch((error: Wrong) => setWrong(error.message));
  }, [file]);
  if (wrong) {
    return (
      <p class="wrong" role="alert">
        {wrong}
      </p>
    );
  }
  if (!opened) return <p class="soft">{w.reading}</p>;
  const loops = opened.summary?.loops ?? [];
  const asked = state.value.get("loop");
  const of = loops.find((each) => each.name === asked) ?? loops[0];
  const entry = list.files.find((each) => each.id === file);
  const columns = (
    <Columns
      opened={opened}
      roles={list.roles}
      types={list.loop_types}
      said={said}
      onRead={(read, then) => {
        setOpened(read);
        setSaid(then);
        setVersion(version + 1);
        props.onRead();
      }}
    />
  );
  if (!of) return <div class="of">{columns}</div>;
  return (
    <OfLoop
      key={`${of.name} ${version}`}
      {...props}
      loop={of}
      dropped={entry?.dropped ?? false}
      columns={columns}
    />
  );
}

type LoopSummary = NonNullable<Opened["summary"]>["loops"][number];

function OfLoop(props: FileProps & { loop: LoopSummary; dropped: boolean; columns: preact.JSX.Element }) {
  const { file, loop, list, kept } = props;
  const tag = loop.name;
  const [samples, setSamples] = useState<Samples | null>(null);
  const [view, setView] = useState<Span>([0, 1]);
  const [stretch, setStretch] = useState<Span | null>(null);
  const [judged, setJudged] = useState<{ judgement: Judgement; place: Place } | null>(null);
  const [busy, setBusy] = useState(true);
  const [wrong, setWrong] = useState("");
  const [at, setAt] = useState<number | null>(null);

  const latest = useRef<Latest<"recordings/diagnose"> | null>(null);
  const wanted = useRef("");
  latest.current ??= new Latest(
    "recordings/diagnose",
    (judgement, ask) => {
      setJudged({ judgement, place: { file, loop: tag, from: ask.from ?? null, to: ask.to ?? null } });
      setWrong("");
      if (JSON.stringify(ask) === wanted.current) setBusy(false);
    },
    (error) => {
      // The verdict on another stretch is none on this one.
      setJudged(null);
      setWrong(error.message);
      setBusy(false);
    },
  );
  const ask = (of: Span | null) => {
    const question = { file, loop: tag, from: of ? of[0] : null, to: of ? of[1] : null };
    wanted.current = JSON.stringify(question);
    setBusy(true);
    latest.current?.ask(question);
  };

  useEffect(() => {
    const query = new URLSearchParams({ file, loop: tag });
    bytes(`/api/recordings/trend?${query}`)
      .then((buffer) => {
        const found = samplesOf(buffer);
        const all = ends(found);
        const params = state.value;
        setSamples(found);
        setView(span(params, "zoom", "until") ?? all);
        const of = span(params, "from", "to");
        setStretch(of);
        ask(of);
      })
      .catch((error: Wrong) => setWrong(error.message));
  }, []);

  // A link to another stretch of the same loop.
  const address = state.value;
  const first = useRef(true);
  useEffect(() => {
    if (first.current) {
      first.current = false;
      return;
    }
    if (!samples) return;
    const of = span(address, "from", "to");
    setStretch(of);
    setView(span(address, "zoom", "until") ?? ends(samples));
    ask(of);
  }, [address]);

  const choose = (of: Span | null) => {
    setStretch(of);
    ask(of);
  };
  useEffect(() => {
    if (!samples) return;
    const all = ends(samples);
    const out: [string, string][] = [["file", file], ["loop", tag]];
    if (stretch) out.push(["from", String(stretch[0])], ["to", String(stretch[1])]);
    if (view[0] > all[0] || view[1] < all[1]) out.push(["zoom", String(view[0])], ["until", String(view[1])]);
    if (kept.length > 0) out.push(["with", JSON.stringify(kept.map((each) => each.place))]);
    remember(out);
  }, [samples, stretch, view, kept]);

  const plantTime = judged?.judgement.diagnosis.plant_time;
  const start = loop.start_s ?? null;
  const clock = useMemo(
    () => new Clock(start, plantTime?.offset_s ?? 0, plantTime?.name ?? ""),
    [start, plantTime?.offset_s, plantTime?.name],
  );
  const clocks = (of: Place) => (of.file === file && of.loop === tag ? clock : null);
  const unit = loop.signals.pv?.unit ?? "";
  const present = judged && { place: judged.place, judgement: judged.judgement };
  const isKept = kept.some((each) => JSON.stringify(each.place) === JSON.stringify(present?.place));
  const keep = () => {
    if (present) props.setKept((now) => [...now, present].slice(-MOST_KEPT));
  };
  const goTo = (of: Place) => {
    const to: [string, string][] = [["file", of.file], ["loop", of.loop]];
    if (of.from !== null && of.to !== null) to.push(["from", String(of.from)], ["to", String(of.to)]);
    go("recordings", to);
  };
  const report = async (save: boolean) => {
    // A tab that is opened only when the report is there would be blocked as a popup.
    const tab = save ? null : window.open("", "_blank");
    try {
      const { address } = await call("recordings/report", { file, loop: tag, from: stretch?.[0] ?? null, to: stretch?.[1] ?? null });
      if (tab) {
        tab.opener = null;
        tab.location.replace(address);
      } else location.assign(`${address}?save=true`);
    } catch (error) {
      tab?.close();
      setWrong((error as Error).message);
    }
  };
  const all: Span = samples ? ends(samples) : [0, 1];
  // What was judged, which while a stretch is dragged is not yet what is selected.
  const [a, b] = [judged?.place.from ?? null, judged?.place.to ?? null];
  const inStretch = samples && a !== null && b !== null ? place(samples.time, b) - place(samples.time, a) : 0;
  const where =
    a !== null && b !== null
      ? w.stretchOf(clock.span(a, b), lasting(b - a), inStretch)
      : w.wholeOf(samples?.time.length ?? 0, lasting(all[1] - all[0]));
  // Which clock the plant has, the verdict tells.
  const waits = !samples || (start !== null && !plantTime && !wrong);

  return (
    <div class="of">
      <header class="about">
        <h1>
          {tag} <span class="soft">{loop.type === "unknown" ? "" : loop.type}</span>
        </h1>
        <p class="soft">{w.about}</p>
      </header>
      <div class="sides">
        <div class="left">
          {waits ? (
            <p class="soft placeholder">{w.reading}</p>
          ) : (
            samples && (
              <Trend
                name={tag}
                samples={samples}
                clock={clock}
                unit={unit}
                view={view}
                onView={setView}
                stretch={stretch}
                onStretch={choose}
                slips={judged?.judgement.slips ?? []}
                at={at}
                onAt={setAt}
              />
            )
          )}
        </div>
        <div class="right">
          {wrong && (
            <p class="wrong" role="alert">
              {wrong}
            </p>
          )}
          {judged ? <Card judgement={judged.judgement} where={where} busy={busy} /> : !wrong && <p class="soft placeholder">{w.judging}</p>}
          {judged && (
            <div class="row actions">
              <button type="button" onClick={keep} disabled={isKept || kept.length >= MOST_KEPT}>
                {w.compare}
              </button>
              <button type="button" onClick={() => void report(true)}>
                {w.saveReport}
              </button>
              <button type="button" onClick={() => void report(false)}>
                {w.openReport}
              </button>
            </div>
          )}
          {kept.length === 0 && judged && <p class="soft hint">{w.compareHint}</p>}
        </div>
        <div class="below">
          {!waits && samples?.signals.pv && (
            <PvOverOp samples={samples} stretch={stretch ?? [all[0], Infinity]} unit={unit} at={at} onAt={setAt} />
          )}
          {judged && <Evidence judgement={judged.judgement} />}
        </div>
      </div>
      {kept.length > 0 && (
        <Compare
          kept={kept}
          present={isKept ? null : present}
          name={(of) => named(of, clocks(of))}
          onGo={goTo}
          onDrop={(k) => props.setKept((now) => now.filter((_, each) => each !== k))}
        />
      )}
      {judged && <More of={judged.place} />}
      {judged && (
        <Override
          place={judged.place}
          verdicts={list.verdicts}
          dropped={props.dropped}
          overruled={judged.judgement.first_screen.overruled !== null}
          onDone={() => ask(stretch)}
        />
      )}
      {props.columns}
    </div>
  );
}
