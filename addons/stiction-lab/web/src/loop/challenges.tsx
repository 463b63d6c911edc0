// Cards with something to find out, each with its own check.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { go } from "../address";
import { call, type Answer } from "../api";
import { t } from "../texts";
import { scenario, secret, value } from "./knobs";

type Id = keyof typeof t.challenges.cards;

/** A tuning that follows fast. */
const HASTY = ["controller.kc=0.9", "controller.ti=0.4"];

/** Where each begins. */
const STARTS: Record<Id, () => [string, string][]> = {
  halve: () => [["scenario", "lab/flow"], ...HASTY.map((each): [string, string] => ["set", each]), ["locked", "1"]],
  stop: () => [["scenario", "lab/flow"], ["locked", "1"]],
  jump: () => [["scenario", "lab/flow"], ["secret", seed()], ["hidden", "1"], ["vp", "0"]],
  stroke: () => [["scenario", "lab/flow"], ["secret", seed()], ["hidden", "1"], ["vp", "0"], ["set", "noise.sd=0.02"], ["manual", "50"]],
};

function seed(): string {
  return String(1 + Math.floor(Math.random() * 9999));
}

function Guessed(props: { of: "valve.S" | "valve.J"; label: string; done: (right: boolean) => void }) {
  const said = useSignal("");
  return (
    <form
      class="row"
      onSubmit={(event) => {
        event.preventDefault();
        const [guess, truth] = [Number(said.value), value(props.of)];
        if (said.value !== "") props.done(Math.abs(guess - truth) <= Math.max(0.2 * truth, 0.3));
      }}
    >
      <label>
        {props.label}{" "}
        <input type="number" step="any" min="0" value={said.value} onInput={(event) => (said.value = event.currentTarget.value)} /> %
      </label>
      <button type="submit">{t.challenges.check}</button>
    </form>
  );
}

export function Challenges(props: { cycles: Answer<"cycle"> | null }) {
  const open = useSignal<Id | null>(null);
  const result = useSignal<boolean | null>(null);
  const first = useSignal<number | null>(null);
  useEffect(() => {
    if (open.value !== "halve") return;
    void call("cycle", { scenario: "lab/flow", set: HASTY }).then((got) => (first.value = got.cycles[0]?.half_pp.pv ?? null));
  }, [open.value]);
  const id = open.value;
  const swing = props.cycles?.cycles[0]?.half_pp.pv;
  const halved = id === "halve" && scenario.value === "lab/flow" && first.value !== null && swing !== undefined && swing <= first.value / 2;
  const right = halved || result.value === true;
  return (
    <details class="card">
      <summary>
        <strong>{t.challenges.title}</strong>
      </summary>
      <div class="cards">
        <p class="row">
          {(Object.keys(t.challenges.cards) as Id[]).map((each) => (
            <button
              key={each}
              aria-pressed={id === each}
              onClick={() => {
                open.value = each;
                result.value = null;
                go("loop", STARTS[each]());
              }}
            >
              {t.challenges.cards[each].title}
            </button>
          ))}
        </p>
        {id && (
          <div>
            <p>{t.challenges.cards[id].text}</p>
            {id === "halve" && first.value !== null && (
              <p class="soft">{t.challenges.swing(first.value.toFixed(2), swing === undefined ? "–" : swing.toFixed(2))}</p>
            )}
            {id === "jump" && <Guessed key={secret.value} of="valve.J" label="J =" done={(ok) => (result.value = ok)} />}
            {id === "stroke" && <Guessed key={secret.value} of="valve.S" label="S =" done={(ok) => (result.value = ok)} />}
            {id === "stop" && (
              <p class="row">
                <button onClick={() => (result.value = false)}>{t.challenges.stopped}</button>
                <button onClick={() => (result.value = true)}>{t.challenges.cannot}</button>
              </p>
            )}
            <p role="status">
              {right ? (
                <span class="done">✓ {t.challenges.cards[id].why}</span>
              ) : (
                result.value === false && <span class="wrong">{t.challenges.no}</span>
              )}
              {(right || result.value === false) && secret.value !== null && (id === "jump" || id === "stroke") && (
                <> {t.challenges.truth(value("valve.S"), value("valve.J"))}</>
              )}
            </p>
          </div>
        )}
      </div>
    </details>
  );
}
