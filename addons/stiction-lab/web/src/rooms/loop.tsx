// Valve and loop: drag S, and watch the loop begin to cycle.
import { effect, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type uPlot from "uplot";
import { remember, state } from "../address";
import { Latest, call, type Answer } from "../api";
import { Challenges } from "../loop/challenges";
import { Engine } from "../loop/engine";
import { Share } from "../loop/share";
import * as k from "../loop/knobs";
import { LoopMap } from "../loop/map";
import { measure, Numbers, type Measured } from "../loop/numbers";
import { Phase } from "../loop/phase";
import { Trend, type Drawn } from "../loop/trend";
import { move, Valve, type Moving } from "../loop/valve";
import { Verdict } from "../loop/verdict";
import { t } from "../texts";
import "./loop.css";

/** How fast a loop runs at first, and how much of it is shown, s; by its sample time. */
function pace(sampleTime: number): { speed: number; window: number } {
  if (sampleTime <= 0.02) return { speed: 1, window: 60 };
  if (sampleTime <= 0.5) return { speed: 10, window: 240 };
  return { speed: 100, window: sampleTime <= 1 ? 2400 : 4800 };
}

const SPEEDS = [1, 2, 5, 10, 20, 50, 100];

const PRESETS = ["lab/flow", "lab/level", "lab/temperature"];

function Slider(props: { knob: k.Knob; locked: boolean }) {
  const { knob } = props;
  const now = k.value(knob.key);
  const steps = 400;
  const at = knob.log
    ? (steps * Math.log(Math.max(now, 1e-12) / knob.min)) / Math.log(knob.max / knob.min)
    : (steps * (now - knob.min)) / (knob.max - knob.min);
  const of = (place: number) =>
    k.rounded(knob.log ? knob.min * (knob.max / knob.min) ** (place / steps) : knob.min + (place / steps) * (knob.max - knob.min), 3);
  const unit = knob.id === "S" || knob.id === "J" || knob.id === "load" ? "%" : knob.id === "ti" || knob.id === "tau" || knob.id === "delay" ? "s" : k.unit(knob.key);
  const name = t.loop.knobs[knob.id];
  return (
    <label class="knob" title={t.loop.about[knob.id]}>
      <span>
        {name} {unit && <span class="soft">{unit}</span>}
      </span>
      <input
        type="number"
        step="any"
        aria-label={`${name}, ${t.loop.byNumber}`}
        value={String(now)}
        disabled={props.locked}
        onChange={(event) => {
          const to = Number(event.currentTarget.value);
          if (event.currentTarget.value !== "" && Number.isFinite(to)) k.turn(knob.key, to);
        }}
      />
      <input
        type="range"
        min={0}
        max={steps}
        value={Math.max(0, Math.min(steps, at))}
        disabled={props.locked}
        aria-label={name}
        aria-valuetext={`${now} ${unit}`}
        data-knob={knob.id}
        onInput={(event) => k.turn(knob.key, of(Number(event.currentTarget.value)))}
      />
    </label>
  );
}

function Hand(props: { engine: Engine }) {
  const by = k.manual.value;
  const set = (to: number) => (k.manual.value = Math.max(0, Math.min(100, Math.round(to * 100) / 100)));
  const present = () => props.engine.kept.signal[props.engine.now()] ?? 50;
  return (
    <div class="card hand" hidden={by === null}>
      <h2>{t.loop.hand}</h2>
      <div
        role="slider"
        tabIndex={0}
        aria-label={t.loop.handLabel}
        aria-valuemin={0}
        aria-valuemax={100}
        aria-valuenow={by ?? present()}
        onKeyDown={(event) => {
          const step = event.shiftKey ? 1 : 0.1;
          const move = { ArrowUp: step, ArrowRight: step, ArrowDown: -step, ArrowLeft: -step, PageUp: 5, PageDown: -5 }[event.key];
          if (move === undefined) return;
          event.preventDefault();
          set((k.manual.value ?? present()) + move);
        }}
      >
        <output>{(by ?? 0).toFixed(1)} %</output>
        <p class="soft">{t.loop.handKeys}</p>
      </div>
      <p class="row">
        {[-1, -0.1, 0.1, 1].map((each) => (
          <button key={each} onClick={() => set((k.manual.value ?? present()) + each)}>
            {each > 0 ? `+${each}` : `−${-each}`}
          </button>
        ))}
      </p>
    </div>
  );
}

export function LoopRoom() {
  const engine = useRef<Engine | null>(null);
  engine.current ??= new Engine(() => k.running.peek());
  const e = engine.current;
  const cycles = useSignal<Answer<"cycle"> | null>(null);
  const wrong = useSignal("");
  const measured = useSignal<Measured | null>(null);
  const window_ = useSignal(240);
  const hideVp = useSignal(false);
  const locked = useSignal(false);
  const hidden = useSignal(false);
  const moving = useRef<Moving>({ stem: null, spring: null, mark: null, packing: null, words: null, position: null });
  const drawn = useRef<Drawn | null>(null);
  const opVp = useRef<HTMLCanvasElement>(null);
  const opPv = useRef<HTMLCanvasElement>(null);

  // What the address says, at first and whenever a link is followed.
  useEffect(() => {
    void call("scenarios", {}).then((got) => (k.choices.value = got), (error: Error) => (wrong.value = error.message));
  }, []);
  useEffect(() => {
    k.fromAddress(state.value);
    hidden.value = state.value.get("hidden") === "1";
    locked.value = state.value.get("locked") === "1";
    hideVp.value = state.value.get("vp") === "0";
  }, [state.value]);
  useEffect(
    () =>
      effect(() => {
        const all = k.toAddress();
        if (hidden.value) all.push(["hidden", "1"]);
        if (locked.value) all.push(["locked", "1"]);
        if (hideVp.value) all.push(["vp", "0"]);
        remember(all);
      }),
    [],
  );

  // The loop begins anew with another scenario, and goes on with other settings.
  const begin = () => {
    for (const each of phases.current) each.forget();
    void e.begin().then(() => {
      const p = pace(e.dt);
      e.speed.value = p.speed;
      window_.value = p.window;
    });
  };
  const phases = useRef<{ draw: () => void; forget: () => void }[]>([]);
  useEffect(() => {
    begin();
    return () => e.end();
  }, [k.scenario.value]);

  const latest = useRef<Latest<"cycle"> | null>(null);
  latest.current ??= new Latest(
    "cycle",
    (got) => {
      cycles.value = got;
      wrong.value = "";
    },
    (error) => {
      cycles.value = null;
      wrong.value = error.message;
    },
  );
  useEffect(() => {
    if (!k.chosen.value?.is_loop) return;
    const timer = setTimeout(() => latest.current?.ask(k.asked.value), 60);
    return () => clearTimeout(timer);
  }, [JSON.stringify(k.asked.value), k.chosen.value]);

  // Sixty times a second, and numbers four times.
  useEffect(() => {
    const [a, b] = [opVp.current, opPv.current];
    if (!a || !b) return;
    const [pa, pb] = [new Phase(a, "vp", [t.loop.opAxis, t.loop.vpAxis], true), new Phase(b, "pv", [t.loop.opAxis, "PV"], false)];
    let [last, told, frame] = [performance.now(), 0, 0];
    const periods = () => {
      const period = cycles.peek()?.cycles[0]?.period_s;
      return Math.min(window_.peek(), period ? 2.2 * period : window_.peek() / 2);
    };
    phases.current = [];
    const step = (now: number) => {
      e.tick((now - last) / 1000);
      last = now;
      const { op, pv, vp, signal } = e.kept;
      if (vp.length > 0) {
        drawn.current?.draw(window_.peek());
        const at = e.now();
        const bands = cycles.peek();
        const fs = bands ? (bands.S + bands.J) / 2 : 0;
        const before = vp[Math.max(0, at - Math.max(1, Math.round((e.speed.peek() * 0.05) / e.dt)))] as number;
        move(moving.current, vp[at] as number, signal[at] as number, fs || fsOf(), Math.abs((vp[at] as number) - before) > 1e-9);
        const [from, end] = e.shown(periods());
        if (!hideVp.peek()) pa.draw(signal, vp, from, end);
        if (pv.length > 0) pb.draw(op, pv, from, end);
        if (now - told > 250) {
          told = now;
          const period = cycles.peek()?.cycles[0]?.period_s;
          measured.value = measure(e, Math.min(window_.peek(), period ? 3.2 * period : window_.peek()));
        }
      }
      frame = requestAnimationFrame(step);
    };
    frame = requestAnimationFrame(step);
    return () => cancelAnimationFrame(frame);
  }, []);

  const choices = k.choices.value;
  const knobs = k.knobs.value;
  const [few, more] = [knobs.filter((each) => !each.more), knobs.filter((each) => each.more)];
  const isValve = (id: string) => id === "S" || id === "J";
  // Before the list of scenarios has come, it is not known what can be asked.
  const isLoop = k.chosen.value?.is_loop === true;
  const visible = (each: k.Knob) => !(hidden.value && isValve(each.id));
  const fd = (cycles.value ? (cycles.value.S - cycles.value.J) / 2 : 0);
  const fs = (cycles.value ? (cycles.value.S + cycles.value.J) / 2 : 0);
  return (
    <div class="loop-room">
      <h1 class="sr">{t.rooms.loop}</h1>
      <div class="row loop-bar">
        <div class="row" role="group" aria-label={t.loop.presets}>
          {PRESETS.map((each) => (
            <button key={each} aria-pressed={k.scenario.value === each} onClick={() => choose(each)}>
              {t.loop.preset[each]}
            </button>
          ))}
          <label>
            <span class="sr">{t.loop.scenario}</span>
            <select value={k.scenario.value} onChange={(event) => choose(event.currentTarget.value)}>
              {choices?.scenarios.map((each) => (
                <option key={each.name} value={each.name}>
                  {each.name}
                </option>
              ))}
            </select>
          </label>
        </div>
        <div class="row">
          <button class="main" onClick={() => (e.playing.value = !e.playing.value)}>
            {e.playing.value ? t.loop.pause : t.loop.play}
          </button>
          <button onClick={begin}>{t.loop.again}</button>
          <label>
            {t.loop.speed}{" "}
            <select value={String(e.speed.value)} onChange={(event) => (e.speed.value = Number(event.currentTarget.value))}>
              {SPEEDS.map((each) => (
                <option key={each} value={String(each)}>
                  {each}×
                </option>
              ))}
            </select>
          </label>
          <Share engine={e} toml={() => cycles.value?.toml ?? ""} plots={() => drawn.current?.plots() ?? ([] as uPlot[])} />
        </div>
      </div>
      <p class="soft hint">{t.loop.hint}</p>
      {(e.wrong.value || wrong.value) && (
        <p class="wrong" role="alert">
          {e.wrong.value || wrong.value}
        </p>
      )}
      <div class="loop">
        <div class="knobs">
          <Valve moving={moving.current} band={fs > 0 ? fd / fs : 0} />
          {few.filter(visible).map((each) => (
            <Slider key={each.id} knob={each} locked={locked.value && isValve(each.id)} />
          ))}
          <label class="row">
            <input type="checkbox" checked={k.manual.value !== null} onChange={(event) => (k.manual.value = event.currentTarget.checked ? Math.round(10 * (e.kept.signal[e.now()] ?? 50)) / 10 : null)} />
            {t.loop.manual}
          </label>
          <label hidden={!k.isLoop.value}>
            {t.loop.compensator}{" "}
            <select value={k.compensator.value} onChange={(event) => (k.compensator.value = event.currentTarget.value)}>
              <option value="">{t.loop.none}</option>
              {choices?.compensators.map((each) => (
                <option key={each.name} value={each.name} title={each.summary}>
                  {each.name}
                </option>
              ))}
            </select>
          </label>
          <details>
            <summary>{t.loop.more}</summary>
            <div class="knobs">
              {more.map((each) => (
                <Slider key={each.id} knob={each} locked={false} />
              ))}
              {!hidden.value && (
                <label>
                  {t.loop.model}{" "}
                  <select value={k.stem.value ? "stem" : k.text("valve.model")} disabled={locked.value} onChange={(event) => model(event.currentTarget.value)}>
                    {choices?.models.map((each) => (
                      <option key={each.name} value={each.name} title={each.summary}>
                        {each.name}
                      </option>
                    ))}
                    <option value="stem">{t.loop.stem}</option>
                  </select>
                </label>
              )}
              <label class="row">
                <input type="checkbox" checked={!hideVp.value} onChange={(event) => (hideVp.value = !event.currentTarget.checked)} />
                {t.loop.showVp}
              </label>
            </div>
          </details>
        </div>
        <div class="centre grid">
          <Trend engine={e} isLoop={k.isLoop.value} unit={t.loop.pvUnit[k.scenario.value] ?? ""} showVp={!hideVp.value} drawn={(of) => (drawn.current = of)} drag={(sp) => k.turn("set_point.value", k.rounded(sp, 4))} />
          <Hand engine={e} />
          <div class="phases">
            <figure hidden={hideVp.value}>
              <figcaption>{t.loop.opVp}</figcaption>
              <canvas ref={opVp} role="img" aria-label={t.loop.opVpLabel} />
            </figure>
            <figure hidden={!k.isLoop.value}>
              <figcaption>{t.loop.opPv}</figcaption>
              <canvas ref={opPv} role="img" aria-label={t.loop.opPvLabel} />
            </figure>
          </div>
          <div class="below">
            {!hidden.value && isLoop && <LoopMap locked={locked.value} />}
            <Challenges cycles={cycles.value} />
          </div>
        </div>
        <div class="side">
          {isLoop && <Verdict hidden={hidden.value} />}
          {!hidden.value && isLoop && <Numbers cycles={cycles.value} measured={measured.value} wrong={wrong.value} />}
        </div>
      </div>
    </div>
  );
}

/** Where the stem breaks away, as the knobs say it. */
function fsOf(): number {
  return (k.value("valve.S") + k.value("valve.J")) / 2;
}

/** Another scenario, as it is. */
function choose(name: string): void {
  k.changes.value = {};
  k.manual.value = null;
  k.scenario.value = name;
}

function model(name: string): void {
  k.stem.value = name === "stem";
  if (name !== "stem") k.turn("valve.model", name);
}
