// How the columns of a file were read, and saying otherwise.
import { useState } from "preact/hooks";
import { type Answer, call, type Wrong } from "../../api";
import { t } from "../../texts";
import { Rows } from "./verdict";

const w = t.recordings.columns;
export type Opened = Answer<"recordings/open">;
type Mapping = Opened["mapping"];
type OfLoop = NonNullable<Mapping["loop"]>[string];
type Range = [number, number] | null | undefined;

function RangeInput(props: { label: string; value: Range; onValue(value: Range): void }) {
  const [low, high] = props.value ?? ["", ""];
  const [ends, setEnds] = useState<[string, string]>([String(low), String(high)]);
  const change = (k: 0 | 1) => (event: Event) => {
    const next: [string, string] = [...ends];
    next[k] = (event.target as HTMLInputElement).value;
    setEnds(next);
    const both = next.map(Number) as [number, number];
    props.onValue(next.every((text) => text.trim() !== "") && both.every(Number.isFinite) ? both : null);
  };
  return (
    <label class="range">
      {props.label}{" "}
      <span>
        <input type="number" step="any" aria-label={`${props.label}, 0 %`} placeholder="0 %" value={ends[0]} onInput={change(0)} />
        <input type="number" step="any" aria-label={`${props.label}, 100 %`} placeholder="100 %" value={ends[1]} onInput={change(1)} />
      </span>
    </label>
  );
}

/** What is told of a mapping that a file was read by. */
function outcome(read: Opened, save: boolean): string {
  const path = read.mapping_file ?? "";
  if (!save) return read.is_saved ? w.readSo : w.notSaved;
  return read.mapping_toml === "" ? w.removed(path) : w.saved(path);
}

export function Columns(props: {
  opened: Opened;
  roles: string[];
  types: string[];
  /** What came of the last mapping: reading by it makes these columns anew. */
  said: string;
  onRead(opened: Opened, said: string): void;
}) {
  const { opened } = props;
  const { summary } = opened;
  const [mapping, setMapping] = useState<Mapping>(opened.mapping);
  const [wrong, setWrong] = useState("");
  const [busy, setBusy] = useState(false);
  const loops = summary?.loops.map((each) => each.name) ?? [];
  const changed = JSON.stringify(mapping) !== JSON.stringify(opened.mapping);
  const columns = mapping.columns ?? {};

  const give = (column: string, role: string, loop: string) => {
    const next = { ...columns };
    if (role === "") delete next[column];
    else next[column] = loop.trim() ? `${loop.trim()}.${role}` : role;
    setMapping({ ...mapping, columns: next });
  };
  const ofLoop = (name: string, more: Partial<OfLoop>) => {
    const all = mapping.loop ?? {};
    setMapping({ ...mapping, loop: { ...all, [name]: { ...all[name], ...more } } });
  };
  const send = async (wanted: Mapping, save: boolean) => {
    setBusy(true);
    setWrong("");
    try {
      const read = await call("recordings/mapping", { file: opened.id, mapping: wanted, save });
      setMapping(read.mapping);
      props.onRead(read, outcome(read, save));
    } catch (error) {
      setWrong((error as Wrong).message);
    }
    setBusy(false);
  };
  const download = () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([opened.mapping_toml], { type: "application/toml" }));
    link.download = `${opened.id.replace(/^dropped-\d+:/, "")}.mapping.toml`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  const text = (key: "zone" | "time_format", label: string, hint: string) => (
    <label>
      {label}{" "}
      <input
        type="text"
        placeholder={hint}
        value={mapping[key] ?? ""}
        onInput={(event) => setMapping({ ...mapping, [key]: (event.target as HTMLInputElement).value.trim() || null })}
      />
    </label>
  );

  return (
    <details class="card columns" open={summary === null || props.said !== ""}>
      <summary>
        {w.title}
        {summary && <span class="soft"> {summary.layout}</span>}
      </summary>
      {opened.failure && <p class="wrong">{opened.failure}</p>}
      {opened.fixed && <p class="wrong">{opened.fixed}</p>}
      {opened.understood.map((table) => (
        <Rows key={table.caption} table={table} />
      ))}
      <div class="rows" tabIndex={0} role="region" aria-label={w.title}>
        <table>
          <thead>
            <tr>
              <th scope="col">{w.column}</th>
              <th scope="col">{w.role}</th>
              <th scope="col">{w.loop}</th>
              <th scope="col">{w.why}</th>
            </tr>
          </thead>
          <tbody>
            {opened.columns.map((column, k) => {
              const given = columns[column] ?? "";
              const cut = given.lastIndexOf(".");
              const [role, loop] = [given.slice(cut + 1), cut < 0 ? "" : given.slice(0, cut)];
              const recognised = summary?.columns[k];
              return (
                <tr key={`${k}${column}`}>
                  <th scope="row">{recognised?.part ? `${recognised.part}.${column}` : column}</th>
                  <td>
                    <select
                      aria-label={w.roleOf(column)}
                      value={role}
                      disabled={!!opened.fixed}
                      onChange={(event) => give(column, (event.target as HTMLSelectElement).value, loop)}
                    >
                      <option value="">{recognised ? (role === "" ? recognised.role : w.recognise) : w.tell}</option>
                      {props.roles.map((each) => (
                        <option key={each} value={each}>
                          {w.roles[each as keyof typeof w.roles] ?? each}
                        </option>
                      ))}
                    </select>
                  </td>
                  <td>
                    {role !== "" ? (
                      <input
                        type="text"
                        size={10}
                        aria-label={w.loopOf(column)}
                        placeholder={w.anyLoop}
                        value={loop}
                        onInput={(event) => give(column, role, (event.target as HTMLInputElement).value)}
                      />
                    ) : (
                      (recognised?.loop ?? "")
                    )}
                  </td>
                  <td class="soft">{given ? w.byHand : recognised?.why}</td>
                </tr>
              );
            })}
          </tbody>
        </table>
      </div>
      <fieldset disabled={!!opened.fixed}>
        <legend>{w.times}</legend>
        <div class="row">
          {text("zone", w.zone, "Europe/Berlin")}
          {text("time_format", w.timeFormat, "day-first")}
          <label>
            {w.sampleTime}{" "}
            <input
              type="number"
              step="any"
              min="0"
              value={mapping.sample_time ?? ""}
              onInput={(event) => setMapping({ ...mapping, sample_time: Number((event.target as HTMLInputElement).value) || null })}
            />
          </label>
        </div>
      </fieldset>
      {loops.slice(0, 12).map((name) => {
        const own: OfLoop = mapping.loop?.[name] ?? {};
        const found = summary?.loops.find((each) => each.name === name);
        return (
          <fieldset key={`${opened.id}${name}`} disabled={!!opened.fixed}>
            <legend>{name}</legend>
            <div class="row">
              <label>
                {w.type}{" "}
                <select value={own.type ?? ""} onChange={(event) => ofLoop(name, { type: (event.target as HTMLSelectElement).value || null })}>
                  <option value="">{own.type ? w.recognise : found?.type}</option>
                  {props.types.map((each) => (
                    <option key={each}>{each}</option>
                  ))}
                </select>
              </label>
              <RangeInput label={w.pvRange} value={own.pv_range as Range} onValue={(value) => ofLoop(name, { pv_range: value ?? null })} />
              <RangeInput label={w.opRange} value={own.op_range as Range} onValue={(value) => ofLoop(name, { op_range: value ?? null })} />
            </div>
          </fieldset>
        );
      })}
      {summary && summary.notes.length > 0 && (
        <ul>
          {summary.notes.map((note) => (
            <li key={note}>{note}</li>
          ))}
        </ul>
      )}
      <div class="row">
        <button type="button" class="main" disabled={busy || !changed} onClick={() => void send(mapping, false)}>
          {w.read}
        </button>
        {opened.mapping_file ? (
          <button
            type="button"
            disabled={busy || !!opened.fixed || (opened.is_saved && !changed)}
            onClick={() => void send(mapping, true)}
          >
            {w.save}
          </button>
        ) : (
          <button type="button" disabled={opened.mapping_toml === ""} onClick={download}>
            {w.download}
          </button>
        )}
        <button type="button" disabled={busy || !!opened.fixed || (opened.mapping_toml === "" && !changed)} onClick={() => void send({}, false)}>
          {w.forget}
        </button>
        <span role="status">{changed ? "" : props.said}</span>
        {wrong && (
          <span class="wrong" role="alert">
            {wrong}
          </span>
        )}
      </div>
      {opened.mapping_toml && (
        <details>
          <summary>{w.asFile}</summary>
          <pre tabIndex={0}>{opened.mapping_toml}</pre>
        </details>
      )}
      {opened.command && (
        <p class="soft">
          {w.command} <code>{opened.command}</code>
        </p>
      )}
    </details>
  );
}
