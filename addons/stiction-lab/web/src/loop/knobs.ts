// The settings of the loop that runs: a scenario and what is changed of it, in the words of the command. The address,
// the questions to the server and every export are made of them.
import { batch, computed, signal } from "@preact/signals";
import type { Answer, Ask } from "../api";

export type Scenario = Answer<"scenarios">["scenarios"][number];

/** A knob: a setting that is turned. */
export interface Knob {
  id: "S" | "J" | "kc" | "ti" | "sp" | "load" | "noise" | "gain" | "tau" | "delay";
  key: string;
  min: number;
  max: number;
  /** Whether equal ways on the slider are equal factors. */
  log: boolean;
  /** Shown on request only. */
  more: boolean;
}

/** What there is to choose from, as the server tells it. */
export const choices = signal<Answer<"scenarios"> | null>(null);
/** The name of the scenario. */
export const scenario = signal("lab/flow");
/** What is changed of it, by key. */
export const changes = signal<Readonly<Record<string, string>>>({});
/** The physical stem in place of the model. */
export const stem = signal(false);
/** The compensator that is on. */
export const compensator = signal("");
/** What the valve receives in manual mode. */
export const manual = signal<number | null>(null);

/** A valve that is not told: S and J follow from this number, and the address does not name them. */
export const secret = signal<string | null>(null);

/** S and J of a valve that is not told. */
function told(of: string): Record<string, string> {
  // Numbers between 0 and 1 that look like chance, the same for the same seed.
  const share = (k: number) => {
    let h = 2166136261 ^ k;
    for (const c of `${of}/${k}`) h = Math.imul(h ^ c.charCodeAt(0), 16777619) >>> 0;
    h = Math.imul(h ^ (h >>> 15), 2246822519) >>> 0;
    return ((h ^ (h >>> 13)) >>> 0) / 2 ** 32;
  };
  const s = 3 + 7 * share(1);
  return { "valve.S": s.toFixed(1), "valve.J": (s * (0.25 + 0.6 * share(2))).toFixed(1) };
}

/** The scenario as the server describes it. */
export const chosen = computed<Scenario | null>(
  () => choices.value?.scenarios.find((each) => each.name === scenario.value) ?? null,
);

/** Whether it is a loop, and not a valve on a test signal. */
export const isLoop = computed(() => chosen.value?.is_loop ?? true);

/** The value of a key in the scenario itself. */
export function base(key: string): string | undefined {
  const of = chosen.value?.settings.find((each) => each.key === key);
  return of?.value.replace(/^"|"$/g, "");
}

/** The unit of a key. */
export function unit(key: string): string {
  return chosen.value?.settings.find((each) => each.key === key)?.unit ?? "";
}

/** The value of a key now. */
export function value(key: string): number {
  return Number(changes.value[key] ?? base(key) ?? 0);
}

/** The value of a key now, as a text. */
export function text(key: string): string {
  return changes.value[key] ?? base(key) ?? "";
}

/** A number with as many digits as a knob has. */
export function rounded(x: number, digits = 4): number {
  return Number(x.toPrecision(digits));
}

/** Changes a setting. */
export function turn(key: string, to: number | string): void {
  const words = typeof to === "number" ? String(rounded(to)) : to;
  const next: Record<string, string> = { ...changes.value, [key]: words };
  if (words === base(key)) delete next[key];
  // A slip jump beyond S is a valve that overshoots, which is another thing to learn.
  if (key === "valve.S" && value("valve.J") > Number(words)) next["valve.J"] = words;
  if (key === "valve.J" && value("valve.S") < Number(words)) next["valve.S"] = words;
  changes.value = next;
}

/** Where the load is that the knob turns: a constant of its own. */
const load = computed(() => {
  const tables = new Set<string>();
  for (const { key } of chosen.value?.settings ?? []) {
    const [, number, name] = /^load\.(\d+)\.(\w+)$/.exec(key) ?? [];
    if (number === undefined) continue;
    tables.add(number);
    if (name === "value") return key;
  }
  return `load.${tables.size}.value`;
});

/** The knobs of the scenario. */
export const knobs = computed<Knob[]>(() => {
  if (!chosen.value) return [];
  const of = (key: string) => Number(base(key));
  const factor = (id: Knob["id"], key: string, by: number, more = false): Knob[] => {
    const at = of(key);
    return at > 0 ? [{ id, key, min: rounded(at / by), max: rounded(at * by), log: true, more }] : [];
  };
  const sp = base("set_point.value") === undefined ? of("operating_point.pv") || 0 : of("set_point.value");
  const noise = of("noise.sd") || 0.05;
  return [
    { id: "S", key: "valve.S", min: 0, max: 15, log: false, more: false },
    { id: "J", key: "valve.J", min: 0, max: 15, log: false, more: false },
    ...factor("kc", "controller.kc", 10),
    ...factor("ti", "controller.ti", 10),
    ...(!isLoop.value ? [] : [{ id: "sp", key: "set_point.value", min: sp - 15, max: sp + 15, log: false, more: false },
    { id: "load", key: load.value, min: -10, max: 10, log: false, more: false },
    { id: "noise", key: "noise.sd", min: 0, max: rounded(20 * noise), log: false, more: true }] as Knob[]),
    ...factor("gain", "process.gain", 4, true),
    ...factor("tau", "process.tau", 4, true),
    ...(base("process.delay") === undefined
      ? []
      : [{ id: "delay", key: "process.delay", min: 0, max: rounded(4 * Math.max(of("process.delay"), 0.5)), log: false, more: true } as Knob]),
  ];
});

/** The loop as the server is asked for it. */
export const asked = computed<Ask<"cycle">>(() => ({
  scenario: scenario.value,
  set: Object.entries(changes.value).map(([key, to]) => `${key}=${to}`),
}));

/** All that runs. */
export const running = computed<Ask<"live/begin">>(() => ({
  loop: asked.value,
  stem: stem.value,
  ...(compensator.value ? { compensator: compensator.value } : {}),
  ...(manual.value === null ? {} : { manual: manual.value }),
}));

/** As the address has it. */
export function toAddress(): [string, string][] {
  const all: [string, string][] = [["scenario", scenario.value]];
  if (secret.value !== null) all.push(["secret", secret.value]);
  for (const each of asked.value.set ?? [])
    if (secret.value === null || !/^valve\.[SJ]=/.test(each)) all.push(["set", each]);
  if (stem.value) all.push(["stem", "1"]);
  if (compensator.value) all.push(["compensator", compensator.value]);
  if (manual.value !== null) all.push(["manual", String(manual.value)]);
  return all;
}

/** Takes what an address says. */
export function fromAddress(state: URLSearchParams): void {
  batch(() => taken(state));
}

function taken(state: URLSearchParams): void {
  scenario.value = state.get("scenario") ?? "lab/flow";
  const set: Record<string, string> = {};
  for (const each of state.getAll("set")) {
    const at = each.indexOf("=");
    if (at > 0) set[each.slice(0, at)] = each.slice(at + 1);
  }
  secret.value = state.get("secret");
  changes.value = secret.value === null ? set : { ...set, ...told(secret.value) };
  stem.value = state.get("stem") === "1";
  compensator.value = state.get("compensator") ?? "";
  const by = state.get("manual");
  manual.value = by === null || !Number.isFinite(Number(by)) ? null : Number(by);
}
