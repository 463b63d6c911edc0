// What is shown is in the address: the room, and its state. So a link, a reload and the back key all work.
import { signal } from "@preact/signals";
import { arrive } from "./token";

export type Room = "loop" | "exercise" | "guess" | "course" | "paper" | "recordings" | "plant";
export const ROOMS: readonly Room[] = ["loop", "exercise", "guess", "course", "paper", "recordings", "plant"];

function parsed(): { room: Room; state: URLSearchParams } {
  const [path = "", query = ""] = location.hash.replace(/^#\/?/, "").split("?", 2);
  const room = ROOMS.find((each) => each === path) ?? "loop";
  return { room, state: new URLSearchParams(query) };
}

const now = parsed();
/** The room that is shown. */
export const room = signal<Room>(now.room);
/** Its state, as the address has it; changes when the user follows a link or goes back, not by `remember`. */
export const state = signal<URLSearchParams>(now.state);

/** The address that was read or written last; another one is of a link that is being followed. */
let known = location.hash;
let timer = 0;
/** What is to be written to the address, if anything. */
let pending = "";

addEventListener("hashchange", () => {
  arrive();
  if (location.hash === known) return;
  // What was to be written is of where one was.
  pending = "";
  known = location.hash;
  const next = parsed();
  room.value = next.room;
  state.value = next.state;
});

/** Writes what is pending, unless one is on the way elsewhere already. */
function write(): void {
  clearTimeout(timer);
  const to = pending;
  pending = "";
  if (!to || location.hash !== known) return;
  history.replaceState(null, "", to);
  known = location.hash;
}
// Before a link is followed, so that the way back leads to what was seen.
addEventListener("click", write, true);

/** The link to a room in a state. */
export function link(to: Room, params: Iterable<[string, string]> = []): string {
  const query = new URLSearchParams([...params]).toString();
  return `#/${to}${query ? `?${query}` : ""}`;
}

/** Writes the state of the room that is shown to the address, a moment later: browsers count how often it changes. */
export function remember(params: Iterable<[string, string]>): void {
  pending = link(room.value, params);
  clearTimeout(timer);
  timer = window.setTimeout(write, 250);
}

/** Goes to a room in a state, as a link does. */
export function go(to: Room, params: Iterable<[string, string]> = []): void {
  write();
  location.hash = link(to, params);
}
