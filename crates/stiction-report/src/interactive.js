// Reads values off the figures of a report, and zooms its time trends. Without it the figures are
// plain pictures. Every <figure data-live> holds an SVG and, as JSON, the frames, axes and samples of
// its panels; panels of one group within one [data-scope] share their crosshair and zoom.
"use strict";
(() => {
  const panels = [];
  const tip = document.createElement("div");
  tip.className = "tip";
  tip.setAttribute("role", "status");
  tip.hidden = true;
  document.body.append(tip);

  // ---- numbers and times ------------------------------------------------------------------------

  const two = (n) => String(n).padStart(2, "0");
  const MONTHS = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
  const number = (value, decimals) => value.toFixed(decimals).replace("-", "\u2212");
  const decimalsOf = (step) => Math.min(9, Math.max(0, Math.ceil(-Math.log10(Math.abs(step)) - 1e-6)));

  // A value with as many digits as its list resolves; in lists of logarithms, four.
  function written(value, step) {
    const size = Math.abs(value);
    if (step === null && size >= 1e-4 && size < 1e9) return String(Number(value.toPrecision(4)));
    if (size !== 0 && (size < 1e-4 || size >= 1e9)) return value.toExponential(3).replace("-", "\u2212");
    return number(value, decimalsOf(step));
  }

  function clock(value) {
    return new Date(Math.round(value * 10) * 100).toISOString().replace("T", " ").replace(/(\.0)?00Z$|Z$/, "");
  }

  // A value of an axis, or of a quantity along a series.
  function textOf(quantity, value, step) {
    if (quantity.names) return quantity.names[Math.round(value)] ?? "";
    return quantity.scale === "clock" ? clock(value) : written(value, step) + " " + quantity.unit;
  }

  // A list as the report packs it; on logarithmic axes, of logarithms.
  function unpack({ from, step, n, d }, scale) {
    let sum = 0;
    const values = d
      ? Float64Array.from(d, (each) => from + step * (sum += each))
      : Float64Array.from({ length: n }, (_, i) => from + step * i);
    return scale === "log" ? { step: null, values: values.map((v) => 10 ** v) } : { step, values };
  }

  // Index of the value nearest to x in an ascending list.
  function nearest(values, x) {
    let [low, high] = [0, values.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (values[middle] < x) low = middle; else high = middle;
    }
    return x - values[low] <= values[high] - x ? low : high;
  }

  // ---- panels -----------------------------------------------------------------------------------

  const position = (scale) => (scale === "log" ? (v) => Math.log10(v) : (v) => v);

  class Panel {
    constructor(svg, node, data, scope) {
      Object.assign(this, data, { svg, node });
      this.key = data.group === null ? null : scope + "/" + data.group;
      this.range = [data.x.lo, data.x.hi];
      // What stands for ticks, grid and words while the panel is zoomed.
      this.own = [];
      for (const series of this.series) {
        series.x = unpack(series.x, this.x.scale);
        series.y = unpack(series.y, this.y.scale);
        if (series.along) series.along.values = unpack(series.along.values, series.along.scale);
      }
      this.lead = this.series.find((series) => series.kind === "trend");
      this.hover = this.draw("g", { class: "hover", "pointer-events": "none" });
      svg.append(this.hover);
    }
    draw(name, attributes, content) {
      const element = document.createElementNS(this.svg.namespaceURI, name);
      for (const key in attributes) element.setAttribute(key, attributes[key]);
      if (content !== undefined) element.textContent = content;
      return element;
    }
    px(x) {
      const [at, lo, hi] = [x, ...this.range].map(position(this.x.scale));
      return this.frame[0] + ((at - lo) / (hi - lo)) * this.frame[2];
    }
    py(y) {
      const [at, lo, hi] = [y, this.y.lo, this.y.hi].map(position(this.y.scale));
      return this.frame[1] + (1 - (at - lo) / (hi - lo)) * this.frame[3];
    }
    // Data coordinate under a place on paper.
    at(px) {
      const [lo, hi] = this.range.map(position(this.x.scale));
      const at = lo + ((px - this.frame[0]) / this.frame[2]) * (hi - lo);
      return this.x.scale === "log" ? 10 ** at : at;
    }
    holds(px, py) {
      const [x, y, w, h] = this.frame;
      return px >= x && px <= x + w && py >= y - 24 && py <= y + h + 6;
    }
    linked() {
      return this.key === null ? [this] : panels.filter((panel) => panel.key === this.key);
    }
    xText(x, step) {
      return textOf(this.x, x, step);
    }
    // Crosshair at x; returns the lines of the tooltip.
    cross(x) {
      const px = this.px(x);
      const [left, top, width, height] = this.frame;
      if (px < left - 0.5 || px > left + width + 0.5) return [];
      this.hover.append(this.draw("line", { x1: px, x2: px, y1: top, y2: top + height }));
      const lines = [];
      const span = this.spans.find(([from, to]) => x >= from && x <= to);
      if (span) lines.push({ name: this.strip, value: span[2] });
      for (const series of this.series) {
        if (series.kind === "map") continue;
        const i = nearest(series.x.values, x);
        const [vx, vy] = [series.x.values[i], series.y.values[i]];
        if (series.kind === "points" && Math.abs(this.px(vx) - px) > 6) continue;
        // Beyond its ends, or the outer edges of its bars, a series has no value.
        const { values } = series.x;
        const beside = values.length > 1 ? Math.abs(this.px(values[1]) - this.px(values[0])) / 2 : 0;
        if (Math.abs(this.px(vx) - px) > Math.max(1, beside) && (i === 0 || i === values.length - 1)) continue;
        if (lines.some((line) => line.name === series.name)) continue;
        this.dot(vx, vy, series);
        const value = textOf(this.y, vy, series.y.step);
        lines.push({ name: series.name, value, colour: series.colour });
      }
      return lines;
    }
    dot(x, y, series) {
      const [cx, cy] = [this.px(x), this.py(y)];
      this.hover.append(this.draw("circle", { cx, cy, r: 4, stroke: series.colour }));
    }
    // The sample nearest to a place on paper, of any series.
    closest(px, py) {
      let best = { distance: Infinity };
      for (const series of this.series) {
        for (let i = 0; i < series.x.values.length; i++) {
          const x = series.x.values[i], y = series.y.values[i];
          const distance = Math.hypot(this.px(x) - px, this.py(y) - py);
          if (distance < best.distance) best = { distance, series, x, y, i };
        }
      }
      return best;
    }
    // Shows the range [from, to] of x.
    zoom(from, to) {
      const { lo, hi } = this.x;
      this.range = [from, to];
      const whole = from === lo && to === hi;
      const [left, , width] = this.frame;
      const k = (hi - lo) / (to - from);
      const shift = left - k * (left + ((from - lo) / (hi - lo)) * width);
      for (const part of this.node.querySelectorAll(".moving")) {
        part.setAttribute("transform", `matrix(${k} 0 0 1 ${shift} 0)`);
        part.classList.toggle("zoomed", !whole);
      }
      for (const note of this.node.querySelectorAll(".note")) {
        const anchor = Number(note.dataset.x);
        const to = k * anchor + shift;
        note.setAttribute("transform", `translate(${to - anchor} 0)`);
        note.style.visibility = to < left || to > left + width ? "hidden" : "";
      }
      const still = this.node.querySelectorAll(".x-grid, .x-ticks, .words");
      for (const part of still) part.style.display = whole ? "" : "none";
      for (const part of this.own) part.remove();
      this.own = [];
      if (!whole) this.letter();
    }
    letter() {
      const [left, top, width, height] = this.frame;
      // The grid lies below the curves, what is written above them.
      const grid = this.draw("g", { class: "own-grid" });
      const group = this.draw("g", { class: "own-ticks" });
      const make = this.x.scale === "clock" ? clockTicks : linearTicks;
      for (const { at, label } of make(...this.range, Math.max(2, Math.min(8, width / 90)))) {
        const x = this.px(at);
        if (x < left - 0.5 || x > left + width + 0.5) continue;
        grid.append(this.draw("line", { x1: x, x2: x, y1: top, y2: top + height }));
        group.append(this.draw("line", { x1: x, x2: x, y1: top + height, y2: top + height + 4 }));
        if (!this.lettered) continue;
        const y = top + height + 17.6;
        group.append(this.draw("text", { x, y, "text-anchor": "middle", "font-size": 12 }, label));
      }
      // The words of the strip, in the middle of what can be seen of their spans.
      for (const [from, to, word] of this.spans) {
        const [a, b] = [Math.max(this.px(from), left), Math.min(this.px(to), left + width)];
        if (b - a < 7 * word.length) continue;
        const middle = { x: (a + b) / 2, y: this.base, "text-anchor": "middle", "font-size": 11 };
        group.append(this.draw("text", middle, word));
      }
      this.node.prepend(grid);
      this.node.append(group);
      this.own = [grid, group];
    }
  }

  function linearTicks(lo, hi, count) {
    const least = (hi - lo) / count;
    const power = 10 ** Math.floor(Math.log10(least));
    const step = [1, 2, 5, 10].map((digit) => digit * power).find((each) => each >= least * 0.999);
    const ticks = [];
    for (let i = Math.ceil(lo / step); i * step <= hi; i++) {
      ticks.push({ at: i * step, label: number(i * step, decimalsOf(step)) });
    }
    return ticks;
  }

  function clockTicks(lo, hi, count) {
    const least = (hi - lo) / count;
    const day = 86400;
    const steps = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10800, 21600, 43200, day];
    const step = steps.find((each) => each >= least) || Math.ceil(least / day) * day;
    const ticks = [];
    for (let at = Math.ceil(lo / step) * step; at <= hi; at += step) {
      const t = new Date(at * 1000);
      const seconds = step < 60 ? ":" + two(t.getUTCSeconds()) : "";
      const label = at % day === 0
        ? `${t.getUTCDate()} ${MONTHS[t.getUTCMonth()]}`
        : `${two(t.getUTCHours())}:${two(t.getUTCMinutes())}${seconds}`;
      ticks.push({ at, label });
    }
    return ticks;
  }

  // ---- what is under the pointer ----------------------------------------------------------------

  function clear() {
    for (const panel of panels) panel.hover.replaceChildren();
    tip.hidden = true;
  }

  function show(title, lines, svg, px, py) {
    tip.replaceChildren();
    const head = document.createElement("b");
    head.textContent = title;
    tip.append(head);
    for (const { name, value, colour } of lines) {
      const line = document.createElement("div");
      const key = document.createElement("i");
      if (colour) key.style.background = colour;
      line.append(key, `${name}: ${value}`);
      tip.append(line);
    }
    tip.hidden = false;
    const box = svg.getBoundingClientRect();
    const scale = box.width / svg.viewBox.baseVal.width;
    const [x, y] = [box.left + px * scale, box.top + py * scale];
    const room = document.documentElement.clientWidth;
    const left = x + 16 + tip.offsetWidth > room ? x - 16 - tip.offsetWidth : x + 16;
    tip.style.left = Math.max(4, left) + scrollX + "px";
    tip.style.top = Math.max(4, y - tip.offsetHeight / 2) + scrollY + "px";
  }

  // Points at a place on paper of a panel.
  function point(panel, px, py) {
    clear();
    if (panel.lead) {
      const values = panel.lead.x.values;
      return pick(panel, values[nearest(values, panel.at(px))], py);
    }
    const { series, x, y, i } = panel.closest(px, py);
    if (!series) return;
    panel.dot(x, y, series);
    const across = { name: panel.x.name, value: panel.xText(x, series.x.step) };
    const up = { name: panel.y.name, value: textOf(panel.y, y, series.y.step) };
    const lines = [across, up];
    if (series.along) {
      const { name, values } = series.along;
      lines.push({ name, value: textOf(series.along, values.values[i], values.step) });
    }
    panel.place = [px, py];
    show(series.name, lines, panel.svg, panel.px(x), panel.py(y));
  }

  // Points at x of a panel, and of those linked with it.
  function pick(panel, x, py) {
    clear();
    panel.cursor = x;
    const lines = panel.linked().flatMap((each) => each.cross(x));
    const title = `${panel.x.name} ${panel.xText(x, panel.lead.x.step)}`;
    const [, top, , height] = panel.frame;
    show(title, lines, panel.svg, panel.px(x), py ?? top + height / 2);
  }

  function zoom(panel, from, to) {
    const { lo, hi } = panel.x;
    const least = (hi - lo) / 2000;
    if (to - from < least) return;
    for (const each of panel.linked()) {
      // A linked panel of another range shows what it can.
      const whole = from <= lo && to >= hi;
      each.zoom(...(whole ? [each.x.lo, each.x.hi] : [from, to]));
    }
  }

  const canZoom = (panel) => panel.key !== null && panel.x.scale !== "log";
  const reset = (panel) => zoom(panel, panel.x.lo, panel.x.hi);

  // ---- pointers and keys ------------------------------------------------------------------------

  function attend(svg, own) {
    let drag = null;
    const place = (event) => {
      const box = svg.getBoundingClientRect();
      const scale = svg.viewBox.baseVal.width / box.width;
      return [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
    };
    const under = (px, py) => own.find((panel) => panel.holds(px, py));
    const inFrame = (panel, px) => Math.min(Math.max(px, panel.frame[0]), panel.frame[0] + panel.frame[2]);

    svg.addEventListener("pointermove", (event) => {
      const [px, py] = place(event);
      if (drag) {
        const [left, top, , height] = drag.panel.frame;
        const [a, b] = [drag.from, inFrame(drag.panel, px)].sort((a, b) => a - b);
        drag.to = inFrame(drag.panel, px);
        clear();
        drag.panel.hover.append(
          drag.panel.draw("rect", { x: a, y: top, width: b - a, height, class: "selection" }));
        return;
      }
      const panel = under(px, py);
      if (panel) point(panel, px, py); else clear();
    });
    svg.addEventListener("pointerdown", (event) => {
      const [px, py] = place(event);
      const panel = under(px, py);
      if (!panel) return;
      point(panel, px, py);
      if (!canZoom(panel) || event.button !== 0) return;
      drag = { panel, from: inFrame(panel, px), to: inFrame(panel, px) };
      try { svg.setPointerCapture(event.pointerId); } catch { /* the pointer is gone */ }
    });
    const end = (event) => {
      if (!drag) return;
      const { panel, from, to } = drag;
      drag = null;
      if (event.type === "pointerup" && Math.abs(to - from) > 8) {
        clear();
        zoom(panel, ...[panel.at(from), panel.at(to)].sort((a, b) => a - b));
      }
    };
    svg.addEventListener("pointerup", end);
    svg.addEventListener("pointercancel", end);
    svg.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && !drag && clear());
    svg.addEventListener("dblclick", (event) => {
      const panel = under(...place(event));
      if (panel && canZoom(panel)) reset(panel);
    });

    // Keys: arrows move the crosshair, up and down change the panel, + and - zoom about it.
    let current = own[0];
    svg.setAttribute("tabindex", "0");
    svg.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      const turn = { ArrowDown: 1, ArrowUp: -1 }[event.key];
      const grow = { "+": 0.5, "=": 0.5, "-": 2 }[event.key];
      if (event.key === "Escape") {
        clear();
        for (const panel of own) if (canZoom(panel)) reset(panel);
      } else if (turn && own.length > 1) {
        const next = (own.indexOf(current) + turn + own.length) % own.length;
        const x = current.cursor;
        current = own[next];
        if (current.lead && x !== undefined && current.px(x) >= 0) pick(current, x);
      } else if (step && current.lead) {
        const values = current.lead.x.values;
        const middle = (current.range[0] + current.range[1]) / 2;
        const at = nearest(values, current.cursor ?? middle);
        const next = Math.min(Math.max(at + step * (event.shiftKey ? 10 : 1), 0), values.length - 1);
        pick(current, values[next]);
      } else if (grow && canZoom(current)) {
        const [lo, hi] = current.range;
        const about = current.cursor ?? (lo + hi) / 2;
        zoom(current, Math.max(current.x.lo, about - (about - lo) * grow),
          Math.min(current.x.hi, about + (hi - about) * grow));
      } else {
        return;
      }
      event.preventDefault();
    });
    svg.addEventListener("blur", clear);
  }

  for (const figure of document.querySelectorAll("figure[data-live]")) {
    const svg = figure.querySelector("svg");
    const data = JSON.parse(figure.querySelector("script").textContent);
    const scope = figure.closest("[data-scope]")?.id ?? "";
    const nodes = svg.querySelectorAll(".panel");
    const own = data.panels.map((panel, i) => new Panel(svg, nodes[i], panel, scope));
    panels.push(...own);
    attend(svg, own);
    svg.classList.add("live");
    if (own.some(canZoom)) figure.classList.add("zoomable");
  }

  // Buttons that show the last cycles of the figure after them.
  for (const spans of document.querySelectorAll("[data-cycle]")) {
    const svg = spans.nextElementSibling.querySelector("svg");
    const panel = panels.find((each) => each.svg === svg);
    const buttons = [...spans.querySelectorAll("button")];
    for (const button of buttons) {
      button.addEventListener("click", () => {
        const { lo, hi } = panel.x;
        const cycles = Number(button.dataset.cycles) || Infinity;
        zoom(panel, Math.max(lo, hi - cycles * Number(spans.dataset.cycle)), hi);
        for (const each of buttons) each.setAttribute("aria-pressed", each === button);
      });
    }
  }

  // On paper figures are unzoomed; what is folded stays so.
  addEventListener("beforeprint", () => {
    clear();
    for (const panel of panels) if (canZoom(panel)) reset(panel);
  });
})();
