// A sketch of each kind of fault: OP and PV, idealised, over two and a half cycles.

type Wave = (x: number) => number;

const sine: Wave = (x) => Math.sin(2 * Math.PI * x);
const triangle: Wave = (x) => 4 * Math.abs(((x + 0.75) % 1) - 0.5) - 1;
const square: Wave = (x) => Math.tanh(8 * sine(x));
const late = (of: Wave, by: number): Wave => (x) => of(x + 1 - by);
const clipped = (of: Wave, at: number): Wave => (x) => Math.max(-at, Math.min(at, of(x)));
const drift: Wave = (x) => 0.5 * sine(0.31 * x) + 0.2 * sine(1.7 * x) + 0.1 * sine(4.3 * x);
const step: Wave = (x) => (x < 0.8 ? -0.7 : x < 1.7 ? 0.7 : -0.1);

/** OP and PV by kind. */
const SKETCHES: Record<string, [Wave, Wave]> = {
  "sticky valve": [triangle, late(square, 0.25)],
  "stuck valve": [(x) => 0.8 * x - 1, () => 0],
  "normal operation": [late(drift, 0.2), drift],
  "sine disturbance": [sine, late(sine, 0.3)],
  "aggressive tuning": [(x) => sine(2.4 * x), (x) => late(sine, 0.25)(2.4 * x)],
  "quantised PV": [triangle, (x) => Math.round(1.4 * late(sine, 0.25)(x)) / 1.4],
  saturation: [(x) => Math.min(0.3, sine(0.6 * x)), (x) => -Math.max(0, sine(0.6 * x) - 0.3)],
  "dead zone elsewhere": [triangle, clipped(late(sine, 0.25), 0.5)],
  "set-point changes": [(x) => step(x) + 0.3 * Math.exp(-8 * ((x + 0.1) % 0.9)), (x) => step(x - 0.08)],
  "process nonlinearity": [sine, (x) => Math.exp(1.2 * late(sine, 0.25)(x)) / 1.8 - 0.9],
  "external wave": [late(sine, 0.1), triangle],
  "sticking neighbour": [late(sine, 0.2), (x) => 0.7 * sine(x) + 0.3 * square(x)],
};

const [WIDTH, HEIGHT, POINTS] = [72, 26, 60];

function path(of: Wave): string {
  const at = (k: number) => [(WIDTH * k) / POINTS, HEIGHT / 2 - (HEIGHT / 2 - 2) * Math.max(-1, Math.min(1, of((2.5 * k) / POINTS)))];
  return Array.from({ length: POINTS + 1 }, (_, k) => at(k).map((each) => each.toFixed(1)).join()).join(" ");
}

/** The sketch of a kind. */
export function Sketch(props: { kind: string }) {
  const waves = SKETCHES[props.kind];
  return (
    <svg class="sketch" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} width={WIDTH} height={HEIGHT} aria-hidden="true">
      {waves?.map((wave, k) => <polyline key={k} class={k === 0 ? "op" : "pv"} points={path(wave)} />)}
    </svg>
  );
}
