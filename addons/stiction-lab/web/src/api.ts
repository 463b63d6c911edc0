// Questions to the server, and its answers, by the types that it declares.
import { known, was } from "./token";
import type { Calls } from "./types";

/** A call's name. */
export type Name = keyof Calls;
export type Ask<N extends Name> = Calls[N]["ask"];
export type Answer<N extends Name> = Calls[N]["answer"];

/** Why there is no answer, in a sentence. */
export class Wrong extends Error {
  constructor(
    readonly status: number,
    message: string,
  ) {
    super(message);
  }
}

async function asked(path: string, init: RequestInit): Promise<Response> {
  let response: Response;
  const token = await known();
  try {
    response = await fetch(path, { ...init, headers: { authorization: `Bearer ${token}` } });
  } catch (error) {
    if (init.signal?.aborted) throw error;
    throw new Wrong(0, "The lab does not answer. Is `stiction lab` still running?");
  }
  if (was(token, response.status !== 401)) return asked(path, init);
  if (response.ok) return response;
  const text = await response.text();
  let words = text.trim();
  try {
    words = (JSON.parse(text) as { error: string }).error;
  } catch {
    // It is plain text.
  }
  throw new Wrong(response.status, words || `${response.status} ${response.statusText}`);
}

/** Asks the server. Throws `Wrong` if there is no answer, and an `AbortError` if `signal` says so. */
export async function call<N extends Name>(name: N, ask: Ask<N>, signal?: AbortSignal): Promise<Answer<N>> {
  const init: RequestInit = { method: "POST", body: JSON.stringify(ask) };
  if (signal) init.signal = signal;
  return (await (await asked(`/api/${name}`, init)).json()) as Answer<N>;
}

/** Bytes from the server. */
export async function bytes(path: string, init: RequestInit = {}): Promise<ArrayBuffer> {
  return (await asked(path, init)).arrayBuffer();
}

/** Sends bytes, such as a file, and gets JSON. */
export async function send<T>(path: string, body: Blob): Promise<T> {
  return (await (await asked(path, { method: "POST", body })).json()) as T;
}

/**
 * Only the last question of its kind counts: a new one ends the one before, and while one is under way the next waits.
 * So a slider that is dragged asks as often as the server can answer, and no more.
 */
export class Latest<N extends Name> {
  private busy = false;
  private next: Ask<N> | undefined;

  constructor(
    private readonly name: N,
    private readonly then: (answer: Answer<N>, ask: Ask<N>) => void,
    private readonly failed: (wrong: Error) => void,
  ) {}

  ask(ask: Ask<N>): void {
    this.next = ask;
    if (!this.busy) void this.work();
  }

  private async work(): Promise<void> {
    this.busy = true;
    while (this.next !== undefined) {
      const ask = this.next;
      this.next = undefined;
      try {
        const answer = await call(this.name, ask);
        // What was asked meanwhile is newer, but something to look at is better than nothing.
        this.then(answer, ask);
      } catch (error) {
        this.failed(error as Error);
      }
    }
    this.busy = false;
  }
}
