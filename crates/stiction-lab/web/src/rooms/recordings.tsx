import { t } from "../texts";

export function Recordings() {
  return <h1>{t.rooms.recordings}</h1>;
}
