// What people say of a loop: entered in the plant's log.
import { useState } from "preact/hooks";
import { call, type Answer } from "../../api";
import { t } from "../../texts";
import { entered, lookNow, status } from "./state";

const w = t.plant.forms;
type Kind = keyof typeof w.kinds;
const KINDS = Object.keys(w.kinds) as Kind[];

export function Forms(props: { loop: string; day: string }) {
  const [kind, setKind] = useState<Kind>("note");
  const [text, setText] = useState("");
  const [by, setBy] = useState(status.value?.user ?? "");
  const [day, setDay] = useState("");
  const [until, setUntil] = useState("");
  const [verdict, setVerdict] = useState("");
  const [done, setDone] = useState("");
  const [wrong, setWrong] = useState("");
  const verdicts = status.value?.words.verdicts ?? [];
  const takesBack = verdicts[verdicts.length - 1] ?? "";
  const send = async (): Promise<Answer<"plant/note">> => {
    const own = { loop: props.loop, by: by || null };
    if (kind === "snooze") return call("plant/snooze", { ...own, until, text });
    if (kind === "override") {
      return call("plant/override", { ...own, verdict: verdict || (verdicts[0] ?? ""), reason: text, until: until || null });
    }
    return call("plant/note", { ...own, kind, text, day: day || null });
  };
  const enter = async (event: Event) => {
    event.preventDefault();
    setDone("");
    setWrong("");
    try {
      const said = await send();
      setDone(w.entered(said.words));
      setText("");
      entered.value++;
      await lookNow();
    } catch (error) {
      setWrong((error as Error).message);
    }
  };
  return (
    <form class="said" onSubmit={enter}>
      <fieldset>
        <legend>{w.legend}</legend>
        <div class="row kinds" role="radiogroup" aria-label={w.what}>
          {KINDS.map((each) => (
            <label key={each} class="kind">
              <input type="radio" name="kind" value={each} checked={kind === each} onChange={() => setKind(each)} />
              {w.kinds[each]}
            </label>
          ))}
        </div>
        <p class="soft">{w.hints[kind]}</p>
        <div class="fields">
          {kind === "override" ? (
            <label>
              {w.verdict}
              <select value={verdict || verdicts[0]} onChange={(event) => setVerdict(event.currentTarget.value)}>
                {verdicts.map((word) => (
                  <option key={word} value={word}>
                    {word === takesBack ? `${word} (${w.takesBack})` : word}
                  </option>
                ))}
              </select>
            </label>
          ) : null}
          <label class="wide">
            {kind === "override" ? w.reason : w.text}
            <input
              type="text"
              maxLength={4000}
              required={kind !== "repair" && kind !== "snooze"}
              value={text}
              onInput={(event) => setText(event.currentTarget.value)}
            />
          </label>
          {kind === "snooze" || kind === "override" ? (
            <label>
              {kind === "snooze" ? w.until : w.untilMaybe}
              <input type="date" required={kind === "snooze"} value={until} onInput={(event) => setUntil(event.currentTarget.value)} />
            </label>
          ) : (
            <label>
              {w.day}
              <input type="date" value={day || (status.value?.today ?? "")} onInput={(event) => setDay(event.currentTarget.value)} />
            </label>
          )}
          <label>
            {w.by}
            <input type="text" maxLength={200} value={by} autoComplete="name" onInput={(event) => setBy(event.currentTarget.value)} />
          </label>
          <button type="submit" class="main">
            {w.enter}
          </button>
        </div>
        <p role="status" class={wrong ? "wrong" : "good"}>
          {wrong || done}
        </p>
      </fieldset>
    </form>
  );
}
