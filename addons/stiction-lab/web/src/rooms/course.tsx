// The course: six lessons, each with a task that the lab checks, and the table of a class.
import { signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { go, link, remember, state } from "../address";
import { call, type Answer } from "../api";
import { download } from "../loop/share";
import { t } from "../texts";
import "./course.css";
import { Plot } from "./guess";

const w = t.course;

type Lesson = Answer<"course/lesson">;

/** The student's name: for all lessons, as long as the page is open. */
const student = signal("");
/** How often the answers of a lesson and class were checked. */
const tries = new Map<string, number>();

function numberIn(name: string, most: number): number {
  const x = Number(state.value.get(name) ?? 1);
  return Number.isInteger(x) && x >= 1 && x <= most ? x : 1;
}

/** A number, with a comma as well. */
function parsed(text: string | undefined): number | null {
  const x = Number((text ?? "").trim().replace(",", "."));
  return text?.trim() && Number.isFinite(x) ? x : null;
}

function Questions(props: { of: Lesson; lesson: number; class: number }) {
  const said = useSignal<Readonly<Record<number, string>>>({});
  const checked = useSignal<Answer<"course/check"> | null>(null);
  const wrong = useSignal("");
  const copied = useSignal(false);
  const say = (k: number, to: string) => {
    said.value = { ...said.value, [k]: to };
    checked.value = null;
  };
  const check = async () => {
    const key = `${props.lesson}/${props.class}`;
    const count = (tries.get(key) ?? 0) + 1;
    wrong.value = "";
    copied.value = false;
    try {
      const answers = props.of.questions.map((_, k) => parsed(said.value[k]));
      checked.value = await call("course/check", { lesson: props.lesson, class: props.class, name: student.value, tries: count, answers });
      tries.set(key, count);
    } catch (error) {
      checked.value = null;
      wrong.value = (error as Error).message;
    }
  };
  const right = checked.value?.right;
  const line = checked.value?.line ?? "";
  return (
    <form
      class="card questions"
      onSubmit={(event) => {
        event.preventDefault();
        void check();
      }}
    >
      <h2>{w.answers}</h2>
      <ol>
        {props.of.questions.map((question, k) => {
          const mark = right && (
            <strong class={right[k] ? "done" : "wrong"}>{right[k] ? `✓ ${w.right}` : `✗ ${w.wrong}`}</strong>
          );
          return (
            <li key={k}>
              {question.choices.length === 0 ? (
                <label>
                  {question.ask}
                  <span class="row">
                    <input type="text" inputMode="decimal" autocomplete="off" value={said.value[k] ?? ""} onInput={(event) => say(k, event.currentTarget.value)} />
                    {question.unit} {mark}
                  </span>
                </label>
              ) : (
                <fieldset>
                  <legend>{question.ask}</legend>
                  {question.choices.map((choice, of) => (
                    <label key={choice} class="row">
                      <input type="radio" name={`q${k}`} checked={said.value[k] === String(of)} onChange={() => say(k, String(of))} />
                      {choice}
                    </label>
                  ))}
                  {mark}
                </fieldset>
              )}
            </li>
          );
        })}
      </ol>
      <p class="row screen">
        <label>
          {w.name} <input type="text" maxLength={80} autocomplete="name" value={student.value} onInput={(event) => (student.value = event.currentTarget.value)} />
        </label>
        <button class="main">{w.check}</button>
      </p>
      {wrong.value && <p class="wrong" role="alert">{wrong.value}</p>}
      <div role="status" class="screen">
        {right && (
          <>
            <p>{w.score(right.filter(Boolean).length, right.length)}</p>
            <p>{w.code}</p>
            <p class="row">
              <code class="line">{line}</code>
              <button
                type="button"
                onClick={async () => {
                  await navigator.clipboard.writeText(line);
                  copied.value = true;
                }}
              >
                {w.copy}
              </button>
              {copied.value && w.copied}
            </p>
            {props.lesson < props.of.titles.length && (
              <p>
                <a href={link("course", [["lesson", String(props.lesson + 1)], ["class", String(props.class)]])}>{w.onward}</a>
              </p>
            )}
          </>
        )}
      </div>
    </form>
  );
}

function LessonView(props: { lesson: number; class: number; titles: (titles: string[]) => void }) {
  const shown = useSignal<Lesson | null>(null);
  const wrong = useSignal("");
  useEffect(() => {
    call("course/lesson", { lesson: props.lesson, class: props.class }).then(
      (got) => {
        shown.value = got;
        props.titles(got.titles);
      },
      (error: Error) => (wrong.value = error.message),
    );
  }, []);
  const of = shown.value;
  if (wrong.value) return <p class="wrong" role="alert">{wrong.value}</p>;
  if (!of) return <p class="soft">{w.wait}</p>;
  return (
    <>
      <p class="sheet">
        <span>{w.nameLine}</span>
        <span>{w.dateLine}</span>
        <span>
          {w.classNumber} {props.class}
        </span>
      </p>
      <article class="text" dangerouslySetInnerHTML={{ __html: of.html }} />
      {of.room && (
        <p class="screen">
          <a class="button" href={`#/${of.room}`} target="_blank">
            {w.open}
          </a>{" "}
          <span class="soft">{w.openHint}</span>
        </p>
      )}
      {of.svg && <img class="sheet" alt={w.figure} src={`data:image/svg+xml;charset=utf-8,${encodeURIComponent(of.svg)}`} />}
      <div class="screen trends">
        {of.trends.map(({ title, signals }) => (
          <section key={title} class="card">
            <h2>{title}</h2>
            {(
              [
                [w.upper, ["SP", "PV"]],
                [w.percent, ["OP", "VP"]],
              ] as const
            ).map(([unit, names]) =>
              signals.some((each) => names.some((name) => name === each.name)) ? (
                <Plot key={unit} label={w.trendOf(title, names.join(", "))} unit={unit} of={signals} names={[...names]} read={title} />
              ) : null,
            )}
          </section>
        ))}
      </div>
      <Questions of={of} lesson={props.lesson} class={props.class} />
    </>
  );
}

function ClassView(props: { class: number }) {
  const lines = useSignal("");
  const table = useSignal<Answer<"course/read"> | null>(null);
  const answers = useSignal<Answer<"course/answers"> | null>(null);
  const wrong = useSignal("");
  const ask = async <T,>(asked: Promise<T>, then: (got: T) => void) => {
    wrong.value = "";
    try {
      then(await asked);
    } catch (error) {
      wrong.value = (error as Error).message;
    }
  };
  const rows = (table.value?.rows ?? []).map((row) => [
    row.student,
    t.course.lesson(row.lesson, row.title),
    String(row.class),
    w.table.right(row.right.filter(Boolean).length, row.right.length),
    row.right.map((right) => (right ? "✓" : "✗")).join(" "),
    w.table.checks(row.tries),
  ]);
  const save = () => {
    // A cell that begins like a formula would be one in a spreadsheet.
    const cell = (text: string) => `"${text.replace(/^(?=[=+\-@\t])/, "'").replaceAll('"', '""')}"`;
    const csv = [w.table.heads, ...rows].map((row) => `${row.map(cell).join(",")}\r\n`).join("");
    download("class.csv", `\ufeff${csv}`, "text/csv");
  };
  return (
    <>
      <h1>{w.table.title}</h1>
      <p>{w.table.about}</p>
      <p class="soft">{w.table.honest}</p>
      <form
        class="card"
        onSubmit={(event) => {
          event.preventDefault();
          void ask(call("course/read", { lines: lines.value }), (got) => (table.value = got));
        }}
      >
        <label>
          {w.table.lines}
          <textarea rows={8} spellcheck={false} placeholder={w.table.example} value={lines.value} onInput={(event) => (lines.value = event.currentTarget.value)} />
        </label>
        <p class="row">
          <button class="main">{w.table.read}</button>
          <button type="button" disabled={rows.length === 0} onClick={save}>
            {w.table.save}
          </button>
        </p>
      </form>
      {wrong.value && <p class="wrong" role="alert">{wrong.value}</p>}
      <div role="status">
        {table.value && rows.length === 0 && <p>{w.table.none}</p>}
        {table.value && table.value.refused.length > 0 && (
          <div class="card">
            <h2 class="wrong">{w.table.refused(table.value.refused.length)}</h2>
            <ul>
              {table.value.refused.map((each) => (
                <li key={each.line}>
                  {w.table.line(each.line, each.why)} <code>{each.text}</code>
                </li>
              ))}
            </ul>
          </div>
        )}
        {rows.length > 0 && (
          <div class="rows" tabIndex={0} role="region" aria-label={w.table.title}>
            <table>
              <thead>
                <tr>
                  {w.table.heads.map((head) => (
                    <th key={head} scope="col">{head}</th>
                  ))}
                </tr>
              </thead>
              <tbody>
                {rows.map((row, k) => (
                  <tr key={k}>
                    {row.map((cell, of) => (
                      <td key={of}>{cell}</td>
                    ))}
                  </tr>
                ))}
              </tbody>
            </table>
          </div>
        )}
      </div>
      <details class="card screen">
        <summary>
          <strong>{w.table.answers}</strong>
        </summary>
        <p>
          <button onClick={() => void ask(call("course/answers", { class: props.class }), (got) => (answers.value = got))}>{w.table.show}</button>
        </p>
        {answers.value && (
          <>
            <h2>{w.table.of(props.class)}</h2>
            {answers.value.map((each, k) => (
              <section key={k}>
                <h3>{w.lesson(k + 1, each.title)}</h3>
                <ol>
                  {each.answers.map((answer, of) => (
                    <li key={of}>{answer}</li>
                  ))}
                </ol>
              </section>
            ))}
          </>
        )}
      </details>
    </>
  );
}

export function Course() {
  const lesson = numberIn("lesson", 6);
  const number = numberIn("class", 9999);
  const table = state.value.get("view") === "class";
  const titles = useSignal<readonly string[]>([]);
  const to = (of: number | null, classNumber = number): [string, string][] => [
    of === null ? ["view", "class"] : ["lesson", String(of)],
    ["class", String(classNumber)],
  ];
  const here = table ? null : lesson;
  useEffect(() => {
    remember(to(here));
    if (titles.value.length === 0) void call("course/lesson", { lesson: 1, class: 1 }).then((got) => (titles.value = got.titles), () => {});
  }, [state.value]);
  return (
    <div class="course">
      <div class="row course-head screen">
        <nav aria-label={w.lessons}>
          {titles.value.map((title, k) => (
            <a key={title} href={link("course", to(k + 1))} aria-current={here === k + 1 ? "page" : undefined}>
              {k + 1}. {title}
            </a>
          ))}
          <a href={link("course", to(null))} aria-current={table ? "page" : undefined}>
            {w.classView}
          </a>
        </nav>
        <p class="row">
          <label title={w.classHint}>
            {w.classNumber}{" "}
            <input type="number" min="1" max="9999" value={number} onChange={(event) => go("course", to(here, Number(event.currentTarget.value) || 1))} />
          </label>
          {!table && <button onClick={() => print()}>{w.print}</button>}
        </p>
      </div>
      {table ? (
        <ClassView key={number} class={number} />
      ) : (
        <LessonView key={`${lesson}/${number}`} lesson={lesson} class={number} titles={(all) => (titles.value = all)} />
      )}
    </div>
  );
}
