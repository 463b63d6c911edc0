import { t } from "../texts";

export function Plant() {
  return <h1>{t.rooms.plant}</h1>;
}
