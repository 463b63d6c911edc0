// What is shown is in the address: the room, and its state. So a link, a reload and the back key all work.
import { signal } from "@preact/signals";

export type Room = "loop" | "guess" | "paper" | "recordings" | "plant";
export const ROOMS: readonly Room[] = ["loop", "guess", "paper", "recordings", "plant"];

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

let last = now.state.toString();
let timer = 0;

addEventListener("hashchange", () => {
  const next = parsed();
  if (next.room === room.value && next.state.toString() === last) return;
  // What was to be written is of where one was.
  clearTimeout(timer);
  last = next.state.toString();
  room.value = next.room;
  state.value = next.state;
});

/** The link to a room in a state. */
export function link(to: Room, params: Iterable<[string, string]> = []): string {
  const query = new URLSearchParams([...params]).toString();
  return `#/${to}${query ? `?${query}` : ""}`;
}

/** Writes the state of the room that is shown to the address, a moment later. */
export function remember(params: Iterable<[string, string]>): void {
  const to = link(room.value, params);
  clearTimeout(timer);
  const written = room.value;
  timer = window.setTimeout(() => {
    if (room.value !== written) return;
    last = new URLSearchParams([...params]).toString();
    history.replaceState(null, "", to);
  }, 250);
}

/** Goes to a room in a state, as a link does. */
export function go(to: Room, params: Iterable<[string, string]> = []): void {
  clearTimeout(timer);
  location.hash = link(to, params);
}
