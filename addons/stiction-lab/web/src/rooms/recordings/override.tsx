// What a person concluded of a valve, beside what was computed.
import { useState } from "preact/hooks";
import { call, type Wrong } from "../../api";
import { t } from "../../texts";
import type { Place } from "./verdict";

const w = t.recordings.override;

export function Override(props: { place: Place; verdicts: string[]; dropped: boolean; overruled: boolean; onDone(): void }) {
  const { file, loop } = props.place;
  const [verdict, setVerdict] = useState(props.verdicts[0] ?? "");
  const [reason, setReason] = useState("");
  const [by, setBy] = useState(localStorage.getItem("stiction-by") ?? "");
  const [all, setAll] = useState(false);
  const [until, setUntil] = useState("");
  const [said, setSaid] = useState("");
  const [wrong, setWrong] = useState("");
  const send = async (ask: Parameters<typeof call<"recordings/override">>[1]) => {
    setSaid("");
    setWrong("");
    try {
      setSaid((await call("recordings/override", ask)).said);
      localStorage.setItem("stiction-by", by);
      props.onDone();
    } catch (error) {
      setWrong((error as Wrong).message);
    }
  };
  const submit = (event: Event) => {
    event.preventDefault();
    void send({ file, loop, verdict, reason, by: by || null, all_recordings: all, until: all ? until : null });
  };
  return (
    <details class="card override">
      <summary>{w.title}</summary>
      {props.dropped ? (
        <p>{w.dropped}</p>
      ) : (
        <form onSubmit={submit}>
          <p class="soft">{w.explains}</p>
          <label>
            {w.verdict}{" "}
            <select value={verdict} onChange={(event) => setVerdict((event.target as HTMLSelectElement).value)}>
              {props.verdicts.map((each) => (
                <option key={each}>{each}</option>
              ))}
            </select>
          </label>
          <label>
            {w.reason}
            <textarea required rows={2} placeholder={w.reasonHint} value={reason} onInput={(event) => setReason((event.target as HTMLTextAreaElement).value)} />
          </label>
          <label>
            {w.by} <input type="text" autocomplete="name" value={by} onInput={(event) => setBy((event.target as HTMLInputElement).value)} />
          </label>
          <label class="check">
            <input type="checkbox" checked={all} onChange={(event) => setAll((event.target as HTMLInputElement).checked)} /> {w.all}
          </label>
          {all && (
            <label>
              {w.until} <input type="date" required value={until} onInput={(event) => setUntil((event.target as HTMLInputElement).value)} />
            </label>
          )}
          <div class="row">
            <button class="main">{w.keep}</button>
            {props.overruled && (
              <button type="button" onClick={() => void send({ file, loop, all_recordings: all })}>
                {w.remove}
              </button>
            )}
          </div>
        </form>
      )}
      <p role="status">{said}</p>
      {wrong && (
        <p class="wrong" role="alert">
          {wrong}
        </p>
      )}
    </details>
  );
}
