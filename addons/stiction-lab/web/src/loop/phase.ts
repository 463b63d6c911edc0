// One signal over another, on a canvas: the last of it strong, what was before faint.
import { style } from "../chart";

interface Axis {
  low: number;
  high: number;
}

/** Round numbers within a range, about `count` of them. */
export function ticks(low: number, high: number, count: number): number[] {
  const raw = (high - low) / Math.max(1, count);
  const unit = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * unit).find((each) => each >= raw) ?? raw;
  const all: number[] = [];
  for (let x = Math.ceil(low / step - 1e-9) * step; x <= high + 1e-9 * step; x += step) all.push(Number(x.toPrecision(12)));
  return all;
}

/** A canvas as sharp as the screen, cleared; with its size. */
export function cleared(canvas: HTMLCanvasElement): [CanvasRenderingContext2D, number, number] | null {
  const [w, h] = [canvas.clientWidth, canvas.clientHeight];
  const sharp = devicePixelRatio || 1;
  if (canvas.width !== Math.round(w * sharp) || canvas.height !== Math.round(h * sharp)) {
    canvas.width = Math.round(w * sharp);
    canvas.height = Math.round(h * sharp);
  }
  const c = canvas.getContext("2d");
  if (!c || w === 0) return null;
  c.setTransform(sharp, 0, 0, sharp, 0, 0);
  c.clearRect(0, 0, w, h);
  c.font = "12px system-ui, sans-serif";
  return [c, w, h];
}

/** Keeps a range that does not tremble: it grows at once, and shrinks when it is much too wide. */
export class Steady {
  private now: Axis | null = null;

  of(low: number, high: number, least: number): Axis {
    const middle = (low + high) / 2;
    const half = Math.max((high - low) / 2, least / 2) * 1.12;
    const wanted = { low: middle - half, high: middle + half };
    const { now } = this;
    const fits = now && low >= now.low && high <= now.high && now.high - now.low < 2.6 * half * 1.12;
    if (!fits) this.now = wanted;
    return this.now ?? wanted;
  }

  forget(): void {
    this.now = null;
  }
}

export class Phase {
  private readonly x = new Steady();
  private readonly y = new Steady();

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly colour: string,
    private readonly labels: [string, string],
    private readonly diagonal: boolean,
  ) {}

  draw(xs: readonly number[], ys: readonly number[], from: number, end: number): void {
    const got = cleared(this.canvas);
    if (!got || end - from < 2) return;
    const [c, w, h] = got;
    let [xl, xh, yl, yh] = [Infinity, -Infinity, Infinity, -Infinity];
    for (let k = from; k < end; k++) {
      const [x, y] = [xs[k] as number, ys[k] as number];
      if (x < xl) xl = x;
      if (x > xh) xh = x;
      if (y < yl) yl = y;
      if (y > yh) yh = y;
    }
    const [ax, ay] = [this.x.of(xl, xh, 1), this.y.of(yl, yh, 1)];
    const [left, top, right, bottom] = [46, 8, w - 10, h - 36];
    const px = (x: number) => left + ((x - ax.low) / (ax.high - ax.low)) * (right - left);
    const py = (y: number) => bottom - ((y - ay.low) / (ay.high - ay.low)) * (bottom - top);
    c.strokeStyle = style("line");
    c.fillStyle = style("soft");
    c.lineWidth = 1;
    c.textAlign = "center";
    for (const x of ticks(ax.low, ax.high, (right - left) / 60)) {
      c.beginPath();
      c.moveTo(px(x), top);
      c.lineTo(px(x), bottom);
      c.stroke();
      c.fillText(String(x), px(x), bottom + 15);
    }
    c.textAlign = "right";
    for (const y of ticks(ay.low, ay.high, (bottom - top) / 40)) {
      c.beginPath();
      c.moveTo(left, py(y));
      c.lineTo(right, py(y));
      c.stroke();
      c.fillText(String(y), left - 5, py(y) + 4);
    }
    c.textAlign = "center";
    c.fillText(this.labels[0], (left + right) / 2, h - 5);
    c.save();
    c.translate(11, (top + bottom) / 2);
    c.rotate(-Math.PI / 2);
    c.fillText(this.labels[1], 0, 0);
    c.restore();
    c.save();
    c.beginPath();
    c.rect(left, top, right - left, bottom - top);
    c.clip();
    if (this.diagonal) {
      c.setLineDash([4, 4]);
      c.strokeStyle = style("soft");
      c.beginPath();
      c.moveTo(px(ax.low), py(ax.low));
      c.lineTo(px(ax.high), py(ax.high));
      c.stroke();
      c.setLineDash([]);
    }
    c.strokeStyle = style(this.colour);
    c.lineJoin = "round";
    const parts = 6;
    for (let part = 0; part < parts; part++) {
      const [a, b] = [from + ((end - from) * part) / parts, from + ((end - from) * (part + 1)) / parts];
      c.globalAlpha = 0.18 + (0.82 * (part + 1)) / parts;
      c.lineWidth = 1 + (part + 1) / parts;
      c.beginPath();
      for (let k = Math.floor(a); k <= Math.min(end - 1, Math.ceil(b)); k++) c.lineTo(px(xs[k] as number), py(ys[k] as number));
      c.stroke();
    }
    c.globalAlpha = 1;
    c.fillStyle = style(this.colour);
    c.beginPath();
    c.arc(px(xs[end - 1] as number), py(ys[end - 1] as number), 4, 0, 7);
    c.fill();
    c.restore();
  }
}
