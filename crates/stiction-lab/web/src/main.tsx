// The lab: its head, and the room that the address names.
import { render } from "preact";
import "uplot/dist/uPlot.min.css";
import { link, room, ROOMS, type Room } from "./address";
import { Exercise } from "./rooms/exercise";
import { Guess } from "./rooms/guess";
import { LoopRoom } from "./rooms/loop";
import { Paper } from "./rooms/paper";
import { Plant } from "./rooms/plant";
import { Recordings } from "./rooms/recordings";
import "./style.css";
import { t } from "./texts";

const VIEWS: Record<Room, () => preact.JSX.Element> = {
  loop: LoopRoom,
  exercise: Exercise,
  guess: Guess,
  paper: Paper,
  recordings: Recordings,
  plant: Plant,
};

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
        <View />
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
