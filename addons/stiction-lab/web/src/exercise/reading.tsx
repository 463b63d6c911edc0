// What the test says, beside the guess of who made it, and then the truth.
import type { Answer } from "../api";
import { clock } from "../chart";
import { t } from "../texts";

const w = t.exercise;

export type Read = { of: Answer<"exercise/read">; at: number };
export type Truth = Answer<"exercise/reveal">;

export function Reading(props: { read: Read; guess: number | null; truth: Truth | null; reveal: () => void }) {
  const { of, at } = props.read;
  const { truth, guess } = props;
  const { test } = of;
  return (
    <section class="card" role="status">
      <h2>{w.reading(clock(at))}</h2>
      <p class="row">
        <span class={`badge ${test.class.replaceAll(" ", "-")}`}>{test.class}</span>
        <span>
          {t.verdict.probability} <strong>{of.probability}</strong>
        </span>
      </p>
      <table>
        <thead>
          <tr>
            <td />
            <th scope="col">{w.byTest}</th>
            <th scope="col">{w.yours}</th>
            {truth && <th scope="col">{w.truth}</th>}
          </tr>
        </thead>
        <tbody>
          <tr>
            <th scope="row">S</th>
            <td>{of.S ?? (of.S_below ? w.below(of.S_below) : "–")}</td>
            <td>{guess === null ? "–" : `${guess} %`}</td>
            {truth && <td>{truth.S} %</td>}
          </tr>
          <tr>
            <th scope="row">J</th>
            <td>{of.J ?? "–"}</td>
            <td>–</td>
            {truth && <td>{truth.J} %</td>}
          </tr>
        </tbody>
      </table>
      {truth ? (
        <p>
          {truth.sticks ? w.sticks : w.healthy} {truth.sticks && guess !== null && w.off(Math.round(100 * (guess / truth.S - 1)))}
        </p>
      ) : (
        <p>
          <button class="main" onClick={props.reveal}>
            {w.reveal}
          </button>
        </p>
      )}
      <h3>{t.verdict.why}</h3>
      <ul>
        {test.reasons.map((each) => (
          <li key={each}>{each}</li>
        ))}
      </ul>
      {test.advice && <p>{test.advice}</p>}
      <img alt={w.figure} src={`data:image/svg+xml;charset=utf-8,${encodeURIComponent(of.svg)}`} />
    </section>
  );
}
