// The paper, figure by figure; each opens in the room where it moves.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { call, type Answer } from "../api";
import { t } from "../texts";
import "./paper.css";

type Figure = NonNullable<Answer<"paper/figure">>;

export function Paper() {
  const figures = useSignal<readonly Figure[]>([]);
  const wrong = useSignal("");
  const done = useSignal(false);
  useEffect(() => {
    let stays = true;
    // One after the other, so that the first is there at once.
    void (async () => {
      try {
        for (let number = 0; stays; number++) {
          const figure = await call("paper/figure", { number });
          if (!figure) break;
          if (stays) figures.value = [...figures.value, figure];
        }
      } catch (error) {
        wrong.value = (error as Error).message;
      }
      if (stays) done.value = true;
    })();
    return () => void (stays = false);
  }, []);
  return (
    <>
      <h1>{t.paper.title}</h1>
      <p class="soft">{t.paper.intro}</p>
      {wrong.value && <p class="wrong" role="alert">{wrong.value}</p>}
      <div class="figures" aria-busy={!done.value}>
        {figures.value.map((each) => (
          <article key={each.heading} class="card">
            <h2>{each.heading}</h2>
            <img alt={each.caption} src={`data:image/svg+xml;charset=utf-8,${encodeURIComponent(each.svg)}`} />
            <p>{each.caption}</p>
            <p class="row">
              <a class="button" href={`#/loop?${each.state}`}>
                {t.paper.open}
              </a>
            </p>
            <details>
              <summary>{t.paper.settings}</summary>
              <dl class="facts">
                {each.parameters.map(([name, value, unit]) => [
                  <dt key={name}>{name}</dt>,
                  <dd key={`${name}=`}>
                    {value} {unit}
                  </dd>,
                ])}
              </dl>
              <p>
                <code>{each.command}</code>
              </p>
            </details>
          </article>
        ))}
      </div>
      {!done.value && <p class="soft">{t.paper.wait}</p>}
    </>
  );
}
