// What is shown, to take away: a link, a command, a scenario, a script, data, a picture.
import { useSignal } from "@preact/signals";
import type uPlot from "uplot";
import { style } from "../chart";
import { t } from "../texts";
import type { Engine } from "./engine";
import { asked } from "./knobs";

/** Gives a file to keep. */
export function download(name: string, what: Blob | string, kind = "text/plain"): void {
  const blob = typeof what === "string" ? new Blob([what], { type: kind }) : what;
  const url = URL.createObjectURL(blob);
  const a = document.createElement("a");
  a.href = url;
  a.download = name;
  a.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

function command(): string {
  const set = (asked.value.set ?? []).map((each) => ` --set ${each}`).join("");
  return `stiction simulate ${asked.value.scenario}${set} --plot run.svg`;
}

function python(): string {
  const set = (asked.value.set ?? []).map((each) => {
    const [key = "", to = ""] = each.split("=", 2);
    return `    ${JSON.stringify(key)}: ${Number.isFinite(Number(to)) ? to : JSON.stringify(to)},\n`;
  });
  const settings = set.length ? `, {\n${set.join("")}}` : "";
  return `import stiction\n\nrun = stiction.simulate(${JSON.stringify(asked.value.scenario)}${settings})\nprint(run.period_s)\n`;
}

function csv(engine: Engine): string {
  const { t: times, sp, pv, op, signal, vp } = engine.kept;
  const rows = times.map((time, k) => [Number(time.toPrecision(12)), sp[k], pv[k], op[k], signal[k], vp[k]].join(","));
  return `t,sp,pv,op,signal,vp\n${rows.join("\n")}\n`;
}

function picture(plots: uPlot[]): Promise<Blob | null> {
  const canvases = plots.map((each) => each.ctx.canvas);
  const all = document.createElement("canvas");
  all.width = Math.max(1, ...canvases.map((each) => each.width));
  all.height = canvases.reduce((sum, each) => sum + each.height, 0) + 1;
  const c = all.getContext("2d");
  if (c) {
    c.fillStyle = style("paper");
    c.fillRect(0, 0, all.width, all.height);
    let y = 0;
    for (const each of canvases) {
      c.drawImage(each, 0, y);
      y += each.height;
    }
  }
  return new Promise((done) => all.toBlob(done));
}

export function Share(props: { engine: Engine; toml: () => string; plots: () => uPlot[] }) {
  const said = useSignal("");
  const copy = async (words: string) => {
    try {
      await navigator.clipboard.writeText(words);
      said.value = t.share.copied;
    } catch {
      said.value = words;
    }
    setTimeout(() => (said.value = ""), 6000);
  };
  return (
    <details class="menu">
      <summary>{t.share.open}</summary>
      <div>
        <button onClick={() => void copy(location.href)}>{t.share.link}</button>
        <button onClick={() => void copy(command())}>{t.share.command}</button>
        <button onClick={() => void copy(python())}>{t.share.python}</button>
        <button onClick={() => download("loop.toml", props.toml())}>{t.share.toml}</button>
        <button onClick={() => download("loop.csv", csv(props.engine), "text/csv")}>{t.share.csv}</button>
        <button onClick={() => void picture(props.plots()).then((blob) => blob && download("loop.png", blob))}>{t.share.png}</button>
        <p role="status">{said.value && <code>{said.value}</code>}</p>
      </div>
    </details>
  );
}
