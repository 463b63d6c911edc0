// The token of the lab. It comes behind the # of the printed address, which no browser sends. It stays in the session
// storage of this tab, which is bound to the origin with its port, and goes into a header of every question.
import { signal } from "@preact/signals";

const KEY = "token";

/** Whether the lab answers this page; not without its token. */
export const locked = signal(false);

let token = "";
/** Whether the lab has answered with this token. */
let sure = false;

try {
  token = sessionStorage.getItem(KEY) ?? "";
} catch {
  // Where nothing can be stored it lasts until the page is left.
}

function keep(other: string): void {
  token = other;
  locked.value = false;
  try {
    sessionStorage.setItem(KEY, other);
  } catch {
    // As above.
  }
}

/** Tabs of this origin give each other the token: a link, or a bookmark, opens without it. */
const tabs = new BroadcastChannel("token");
let found = () => {};
const others = new Promise<void>((done) => {
  found = done;
});
tabs.onmessage = (event: MessageEvent<{ token?: string }>) => {
  const given = event.data.token;
  if (given === undefined) {
    if (token && sure) tabs.postMessage({ token });
  } else if (!sure) {
    keep(given);
    found();
  }
};

/** Takes the token out of an address, such as the printed one, or of nothing else but itself. */
export function enter(address: string): boolean {
  const given = /(?:^|#token=)([0-9a-f]{32})/.exec(address.trim())?.[1];
  if (!given) return false;
  keep(given);
  tabs.postMessage({ token: given });
  return true;
}

/** Takes the token out of the address of this page, and leaves the rest. */
export function arrive(): void {
  if (!location.hash.startsWith("#token=")) return;
  enter(location.hash);
  history.replaceState(null, "", `#${location.hash.replace(/^#token=[0-9a-f]*/, "")}`);
}
arrive();

if (!token) tabs.postMessage({});

/** The token; without one it is waited a moment for the other tabs. */
export async function known(): Promise<string> {
  if (!token) await Promise.race([others, new Promise((done) => setTimeout(done, 300))]);
  return token;
}

/** The lab has, or has not, answered a question with that token. Whether to ask again, with another one. */
export function was(used: string, good: boolean): boolean {
  if (used !== token) return !good;
  if (good) sure = true;
  else {
    sure = false;
    locked.value = true;
    tabs.postMessage({});
  }
  return false;
}
