import { t } from "../texts";

export function Paper() {
  return <h1>{t.rooms.paper}</h1>;
}
