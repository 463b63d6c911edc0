// Small things that are shown in many places.
import { graded, letter, way } from "./state";

/** The letter of what to do, in its colour. */
export function Tile(props: { action: string }) {
  const of = letter(props.action);
  return (
    <b class={`tile ${of}`} aria-hidden="true">
      {of}
    </b>
  );
}

/** A verdict: symbol, word, colour. */
export function Grade(props: { name: string }) {
  const { symbol, tone } = graded(props.name);
  return (
    <span class={`grade ${tone}`}>
      <span aria-hidden="true">{symbol}</span> {props.name}
    </span>
  );
}

/** The name of a loop, which opens it. */
export function Loop(props: { name: string }) {
  return <a href={way({ loop: props.name, day: "" })}>{props.name}</a>;
}
