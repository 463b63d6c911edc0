// The valve, drawn and moving: actuator, spring, packing, stem, plug; and how far the signal is from breaking it away.
import { t } from "../texts";

/** What of it moves, for who moves it. */
export interface Moving {
  stem: SVGGElement | null;
  spring: SVGPathElement | null;
  mark: SVGGElement | null;
  packing: SVGGElement | null;
  words: HTMLElement | null;
  position: SVGTextElement | null;
}

const TRAVEL = 46;

/** Shows the valve as it is: position, signal, and what holds it, all in percent of span. */
export function move(of: Moving, vp: number, signal: number, fs: number, moves: boolean): void {
  const up = Math.max(-5, Math.min(105, vp));
  const y = -((up - 50) / 100) * TRAVEL;
  of.stem?.setAttribute("transform", `translate(0 ${y.toFixed(2)})`);
  // A spring from the lid to the plate, which goes up with the stem.
  const top = 18;
  const bottom = 70 + y;
  const turns = 6;
  let d = `M110 ${top}`;
  for (let k = 0; k < turns; k++) {
    const at = top + ((k + 0.5) / turns) * (bottom - top);
    d += ` L${k % 2 ? 92 : 128} ${at.toFixed(1)}`;
  }
  of.spring?.setAttribute("d", `${d} L110 ${bottom.toFixed(1)}`);
  const off = fs > 0 ? Math.max(-1, Math.min(1, (signal - vp) / fs)) : 0;
  of.mark?.setAttribute("transform", `translate(${(110 + 80 * off).toFixed(1)} 0)`);
  of.packing?.setAttribute("class", moves ? "packing moves" : "packing stuck");
  if (of.position) of.position.textContent = `VP ${vp.toFixed(1)} %`;
  if (of.words) of.words.textContent = fs > 0 ? (moves ? t.loop.moves : t.loop.stuck) : t.loop.free;
}

export function Valve(props: { moving: Moving; band: number }) {
  const { moving } = props;
  return (
    <figure class="valve">
      <svg viewBox="0 0 220 300" role="img" aria-label={t.loop.valveLabel}>
        {/* The actuator: air below the diaphragm lifts, the spring above closes. */}
        <path class="body" d="M50 92 V40 Q50 14 110 14 Q170 14 170 40 V92 Q170 112 110 112 Q50 112 50 92 Z" />
        <path class="spring" ref={(e) => void (moving.spring = e)} d="M110 18 V70" />
        <path class="body" d="M84 112 V150 M136 112 V150" />
        <g class="packing stuck" ref={(e) => void (moving.packing = e)}>
          <rect x="92" y="148" width="36" height="30" rx="3" />
          <path d="M92 158 H128 M92 168 H128" />
        </g>
        {/* The body, with its seat. */}
        <path class="body" d="M18 216 H70 Q80 216 86 204 V178 H134 V204 Q140 216 150 216 H202 V262 H150 Q140 262 134 268 H86 Q80 262 70 262 H18 Z" />
        <path class="seat" d="M72 239 H94 M126 239 H148" />
        <g ref={(e) => void (moving.stem = e)}>
          <path class="plate" d="M58 70 H162" />
          <path class="stem" d="M110 70 V212" />
          <path class="plug" d="M95 206 H125 L116 238 H104 Z" />
        </g>
        <text class="label" x="176" y="60" ref={(e) => void (moving.position = e)} text-anchor="middle">
          VP
        </text>
      </svg>
      <svg viewBox="0 0 220 44" role="img" aria-label={t.loop.barLabel} class="bar">
        <rect x="30" y="8" width="160" height="14" rx="3" class="band" />
        <rect x={110 - 80 * props.band} y="8" width={160 * props.band} height="14" class="dead" />
        <path d="M30 4 V26 M190 4 V26 M110 8 V22" class="edge" />
        <g ref={(e) => void (moving.mark = e)} transform="translate(110 0)">
          <path d="M0 3 V27" class="mark" />
        </g>
        <text x="4" y="40">−{t.loop.breakaway}</text>
        <text x="216" y="40" text-anchor="end">+{t.loop.breakaway}</text>
      </svg>
      <figcaption>
        <strong ref={(e) => void (moving.words = e)}>{t.loop.stuck}</strong>{" "}
        <span class="soft">{t.loop.bar}</span>
      </figcaption>
    </figure>
  );
}
