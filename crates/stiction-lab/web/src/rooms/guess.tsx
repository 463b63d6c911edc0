import { t } from "../texts";

export function Guess() {
  return <h1>{t.rooms.guess}</h1>;
}
