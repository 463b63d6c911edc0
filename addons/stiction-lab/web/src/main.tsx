// The lab: its head, and the room that the address names.
import { useSignal } from "@preact/signals";
import { render } from "preact";
import "uplot/dist/uPlot.min.css";
import { link, room, ROOMS, type Room } from "./address";
import { Course } from "./rooms/course";
import { Exercise } from "./rooms/exercise";
import { Guess } from "./rooms/guess";
import { LoopRoom } from "./rooms/loop";
import { Paper } from "./rooms/paper";
import { Plant } from "./rooms/plant";
import { Recordings } from "./rooms/recordings";
import "./signals.css";
import "./style.css";
import { t } from "./texts";
import { enter, locked } from "./token";

const VIEWS: Record<Room, () => preact.JSX.Element> = {
  loop: LoopRoom,
  exercise: Exercise,
  guess: Guess,
  course: Course,
  paper: Paper,
  recordings: Recordings,
  plant: Plant,
};

/** What there is without the token. */
function Locked() {
  const wrong = useSignal(false);
  return (
    <form
      class="card locked"
      onSubmit={(event) => {
        event.preventDefault();
        wrong.value = !enter(new FormData(event.currentTarget).get("address")?.toString() ?? "");
      }}
    >
      <h1>{t.locked.title}</h1>
      <p>{t.locked.how}</p>
      <p class="row">
        <label>
          {t.locked.address} <input type="text" name="address" autocomplete="off" spellcheck={false} />
        </label>
        <button class="main">{t.locked.open}</button>
      </p>
      {wrong.value && (
        <p class="wrong" role="alert">
          {t.locked.wrong}
        </p>
      )}
    </form>
  );
}

function Lab() {
  const View = VIEWS[room.value];
  document.title = `${t.rooms[room.value]} · ${t.name}`;
  return (
    <>
      <a class="skip" href="#room">
        {t.skip}
      </a>
      <header class="top">
        <strong class="mark">{t.name}</strong>
        <nav aria-label={t.roomsLabel}>
          {ROOMS.map((each) => (
            <a key={each} href={link(each)} aria-current={each === room.value ? "page" : undefined}>
              {t.rooms[each]}
            </a>
          ))}
        </nav>
      </header>
      <main id="room" tabIndex={-1} key={room.value}>
        {locked.value ? <Locked /> : <View />}
      </main>
    </>
  );
}

const root = document.getElementById("lab");
if (root) render(<Lab />, root);
// The link that skips the head must not change the room.
document.addEventListener("click", (event) => {
  const to = (event.target as Element | null)?.closest?.("a.skip");
  if (!to) return;
  event.preventDefault();
  document.getElementById("room")?.focus();
});
