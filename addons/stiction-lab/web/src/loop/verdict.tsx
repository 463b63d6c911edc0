// What the diagnosis says of what a plant would record of the loop: SP, PV and OP.
import { useSignal } from "@preact/signals";
import { Fragment } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { Latest, type Answer } from "../api";
import { t } from "../texts";
import { running, value } from "./knobs";

type Judgement = Answer<"verdict">;

/** The verdict of a diagnosis, in short. */
export function Short(props: { of: Judgement }) {
  const { verdict } = props.of.diagnosis;
  return (
    <>
      <p class="row">
        <span class={`badge ${verdict.class.replaceAll(" ", "-")}`}>{verdict.grade}</span>
        {props.of.probability && (
          <span>
            {t.verdict.probability} <strong>{props.of.probability}</strong>
          </span>
        )}
      </p>
      <p>{props.of.sentence}</p>
      <p class="soft">{props.of.data}</p>
    </>
  );
}

export function Verdict(props: { hidden: boolean }) {
  const found = useSignal<Judgement | null>(null);
  const wrong = useSignal("");
  const old = useSignal(false);
  const latest = useRef<Latest<"verdict"> | null>(null);
  latest.current ??= new Latest(
    "verdict",
    (answer) => {
      found.value = answer;
      old.value = false;
      wrong.value = "";
    },
    (error) => {
      // The verdict on other settings is none on these.
      found.value = null;
      wrong.value = error.message;
      old.value = false;
    },
  );
  const { manual: _, ...ask } = running.value;
  useEffect(() => {
    old.value = true;
    const timer = setTimeout(() => latest.current?.ask(ask), 500);
    return () => clearTimeout(timer);
  }, [JSON.stringify(ask)]);
  const now = found.value;
  return (
    <section class="card verdict" aria-busy={old.value}>
      <h2>{t.loop.verdict}</h2>
      <p class="soft">{t.loop.verdictOf}</p>
      {wrong.value && <p class="wrong">{wrong.value}</p>}
      {now && (
        <div class={old.value ? "old" : undefined}>
          <Short of={now} />
          <dl class="facts">
            {(["S", "J"] as const).map(
              (each) =>
                now[each] && (
                  <Fragment key={each}>
                    <dt>{each}</dt>
                    <dd>
                      {now[each]}
                      {!props.hidden && <span class="soft"> {t.loop.truth(value(`valve.${each}`))}</span>}
                    </dd>
                  </Fragment>
                ),
            )}
            {now.S_below && (
              <>
                <dt>{t.verdict.below}</dt>
                <dd>{now.S_below}</dd>
              </>
            )}
          </dl>
          <details>
            <summary>{t.verdict.why}</summary>
            <ul>
              {now.diagnosis.verdict.reasons.map((each) => (
                <li key={each}>{each}</li>
              ))}
              {now.diagnosis.verdict.contradictions.map((each) => (
                <li key={each} class="soft">
                  {t.verdict.against} {each}
                </li>
              ))}
            </ul>
          </details>
        </div>
      )}
    </section>
  );
}
