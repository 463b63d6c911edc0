// What the room of a plant shows: what the address says, and what the server knows.
import { computed, effect, signal } from "@preact/signals";
import { go, link, remember, room, state } from "../../address";
import { call, Wrong, type Answer } from "../../api";

export type Status = Answer<"plant/status">;
export type Page = Answer<"plant/page">;
export type Row = Page["loops"][number];
export type View = "loops" | "map" | "areas" | "groups" | "changes" | "orders" | "data";
export const VIEWS: readonly View[] = ["loops", "map", "areas", "groups", "changes", "orders", "data"];

/** What the address says. */
export type At = {
  week: string;
  view: View;
  loop: string;
  day: string;
  search: string;
  sort: string;
  down: boolean;
  action: string;
  change: string;
  list: string;
  area: string;
  unit: string;
  health: string;
};

export const NOTHING = {
  search: "",
  action: "",
  change: "",
  list: "open",
  area: "",
  unit: "",
  health: "",
} satisfies Partial<At>;
const START: At = { week: "", view: "loops", loop: "", day: "", sort: "", down: false, ...NOTHING };

function parsed(params: URLSearchParams): At {
  const at: At = { ...START };
  for (const [key, value] of params) {
    if (key === "down") at.down = value === "1";
    else if (key === "view") at.view = VIEWS.find((view) => view === value) ?? "loops";
    else if (key in at) (at as Record<string, unknown>)[key] = value;
  }
  return at;
}

function told(at: At): [string, string][] {
  return Object.entries(at)
    .filter(([key, value]) => value !== START[key as keyof At])
    .map(([key, value]) => [key, value === true ? "1" : String(value)]);
}

export const at = signal<At>(parsed(state.peek()));
effect(() => {
  const params = state.value;
  if (room.value === "plant") at.value = parsed(params);
});

/** Narrows down, sorts, chooses a day: no step for the back key. */
export function turn(change: Partial<At>): void {
  at.value = { ...at.value, ...change };
  remember(told(at.value));
}

/** Goes somewhere else in the room: a step for the back key. */
export function walk(change: Partial<At>): void {
  at.value = { ...at.value, ...change };
  go("plant", told(at.value));
}

/** The link to somewhere else in the room. */
export function way(change: Partial<At>): string {
  return link("plant", told({ ...at.value, ...change }));
}

export const status = signal<Status | null>(null);
export const page = signal<Page | null>(null);
/** Why there is nothing to see. */
export const wrong = signal("");
/** Counts what was entered, so that what depends on it is asked again. */
export const entered = signal(0);
/** Changes with what the server has to show; none before it is known. */
export const stamp = computed(() => status.value?.stamp ?? "");

export const byName = computed(() => new Map((page.value?.loops ?? []).map((row, place) => [row.loop, place])));
/** The row of the loop that is open. */
export const open = computed<Row | undefined>(() => {
  const place = byName.value.get(at.value.loop);
  return place === undefined ? undefined : page.value?.loops[place];
});

let asked = 0;
/** Asks for the week that is shown. */
async function load(week: string): Promise<void> {
  const own = ++asked;
  try {
    const answer = await call("plant/page", week ? { week } : {});
    if (own !== asked) return;
    page.value = answer;
    wrong.value = "";
  } catch (error) {
    if (own !== asked) return;
    wrong.value = (error as Error).message;
  }
}

/** Looks what goes on at the server, now and then; ends with what it gives. */
export function watch(): () => void {
  let timer = 0;
  let ended = false;
  let shown = "";
  const look = async () => {
    clearTimeout(timer);
    let next = 5000;
    try {
      if (document.visibilityState === "visible" || !status.value) {
        const now = await call("plant/status", {});
        if (ended) return;
        status.value = now;
        if (now.scan.running || (page.value && !page.value.groups && !page.value.groups_wrong)) next = 700;
      }
    } catch (error) {
      if (error instanceof Wrong && !ended) wrong.value = error.message;
    }
    if (!ended) timer = window.setTimeout(look, next);
  };
  const off = effect(() => {
    const now = status.value;
    const week = at.value.week;
    if (!now || now.weeks.length === 0) return;
    const next = `${week}\n${now.stamp}\n${entered.value}`;
    if (next === shown) return;
    shown = next;
    void load(week);
  });
  const seen = () => void look();
  document.addEventListener("visibilitychange", seen);
  lookNow = look;
  void look();
  return () => {
    ended = true;
    clearTimeout(timer);
    off();
    document.removeEventListener("visibilitychange", seen);
  };
}

/** Looks at once. */
export let lookNow: () => Promise<void> = async () => {};

/** A number that is known roughly: two digits. */
export function rough(value: number): string {
  const text = String(Number(value.toPrecision(2)));
  return text.replace("-", "−");
}

/** A probability in percent, never surer than 99. */
export function percent(p: number): string {
  if (p > 0.99) return "> 99";
  if (p < 0.01) return "< 1";
  return String(Math.round(100 * p));
}

/** A time as people say it. */
export function time(seconds: number): string {
  // As the report rounds.
  const [s, min] = [Math.round(seconds), seconds < 1800 ? Math.floor(seconds / 60) : Math.round(seconds / 60)];
  const h = Math.floor(min / 60);
  if (s < 120) return `${s} s`;
  if (h < 2) return `${min} min${s % 60 && min < 30 ? ` ${s % 60} s` : ""}`;
  if (h < 48) return `${h} h${min % 60 ? ` ${min % 60} min` : ""}`;
  return `${Math.floor(h / 24)} d${h % 24 ? ` ${h % 24} h` : ""}`;
}

/** The symbol and the class of a grade. */
export function graded(name: string | null | undefined): { symbol: string; tone: string } {
  const word = status.value?.words.grades.find((grade) => grade.name === name);
  return { symbol: word?.symbol ?? "", tone: word?.tone ?? "open" };
}

/** The limit of S that stands in place of an unknown S, where the valve is not suspected. */
export function limit(row: Row): number | null {
  return row.S == null && graded(row.grade).tone === "good" ? (row.S_below ?? null) : null;
}

/** The letter of an action. */
export function letter(action: string): string {
  return status.value?.words.actions.find((word) => word.name === action)?.symbol ?? "";
}
