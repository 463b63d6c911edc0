import { t } from "../texts";

export function LoopRoom() {
  return <h1>{t.rooms.loop}</h1>;
}
