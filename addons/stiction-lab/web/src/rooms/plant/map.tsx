// The plant on a map: a tile a loop, as large as it weighs, in the colour and with the letter of what to do.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../../texts";
import { at, letter, page, percent, status, walk } from "./state";
import { Tile } from "./words";

const w = t.plant;

export function PlantMap() {
  const box = useRef<HTMLDivElement>(null);
  const narrow = useSignal(false);
  const focused = useSignal(-1);
  useEffect(() => {
    const of = box.current;
    if (!of) return;
    const sized = new ResizeObserver(() => (narrow.value = of.clientWidth < 640));
    sized.observe(of);
    return () => sized.disconnect();
  }, []);
  const of = page.value?.maps[narrow.value ? 1 : 0];
  const rows = page.value?.loops ?? [];
  if (!of) return null;
  const tiles = of.areas.flatMap((area) => area.loops);
  const marked = tiles.find(({ place }) => place === focused.value || (focused.value < 0 && rows[place]?.loop === at.value.loop))?.tile;
  const start = tiles.some(({ place }) => place === focused.value) ? focused.value : (tiles[0]?.place ?? 0);
  const step = (event: KeyboardEvent) => {
    const turn = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowDown: [0, 1], ArrowUp: [0, -1] }[event.key];
    const own = tiles.find(({ place }) => place === start);
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      walk({ loop: rows[start]?.loop ?? "", day: "" });
    }
    if (!turn || !own) return;
    event.preventDefault();
    const [dx = 0, dy = 0] = turn;
    const middle = ({ tile }: { tile: { x: number; y: number; w: number; h: number } }) => [tile.x + tile.w / 2, tile.y + tile.h / 2] as const;
    const [x, y] = middle(own);
    let best: { place: number; far: number } | undefined;
    for (const tile of tiles) {
      const [u, v] = middle(tile);
      const along = (u - x) * dx + (v - y) * dy;
      const across = Math.abs((u - x) * dy) + Math.abs((v - y) * dx);
      if (along <= 1) continue;
      const far = along + 3 * across;
      if (!best || far < best.far) best = { place: tile.place, far };
    }
    if (!best) return;
    focused.value = best.place;
    box.current?.querySelector<SVGElement>(`[data-k="${best.place}"]`)?.focus();
  };
  return (
    <div class="plant-map" ref={box}>
      <p class="key">
        <span class="soft">{w.map.hint}</span>{" "}
        {status.value?.words.actions.map((word) => (
          <span key={word.name} class="named">
            <Tile action={word.name} /> {word.name}
          </span>
        ))}
      </p>
      <svg class="map" viewBox={`0 0 ${of.width} ${of.height}`} role="group" aria-label={w.map.label} onKeyDown={step}>
        {of.areas.map((area) => (
          <g key={area.area}>
            <text class="area" x={area.tile.x + 2} y={area.tile.y + 12}>
              {area.area.slice(0, Math.max(0, Math.floor(area.tile.w / 7.5)))}
            </text>
            {area.loops.map(({ place, tile }) => {
              const row = rows[place];
              if (!row) return null;
              const sign = letter(row.action);
              const words = `${row.loop}, ${area.area}: ${row.action}${row.grade ? `, ${row.grade}` : ""}${
                row.probability == null ? "" : `, ${percent(row.probability)} %`
              }`;
              return (
                <g
                  key={row.loop}
                  class={`${sign}${row.loop === at.value.loop ? " open" : ""}`}
                  data-k={place}
                  role="button"
                  tabindex={place === start ? 0 : -1}
                  aria-label={words}
                  onClick={() => walk({ loop: row.loop, day: "" })}
                  onFocus={() => (focused.value = place)}
                >
                  <title>{words}</title>
                  <rect x={tile.x} y={tile.y} width={Math.max(0.5, tile.w)} height={Math.max(0.5, tile.h)} />
                </g>
              );
            })}
            <g aria-hidden="true">
              {area.loops.map(({ place, tile }) => {
                const row = rows[place];
                if (!row || tile.w < 9 || tile.h < 11) return null;
                return (
                  <text key={place} x={tile.x + tile.w / 2} y={tile.y + tile.h / 2 + 4}>
                    {tile.w >= 7 * row.loop.length && tile.h >= 16 ? row.loop : letter(row.action)}
                  </text>
                );
              })}
            </g>
          </g>
        ))}
        {marked ? <rect class="marked" x={marked.x} y={marked.y} width={marked.w} height={marked.h} aria-hidden="true" /> : null}
      </svg>
    </div>
  );
}
