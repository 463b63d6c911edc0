"use strict";
// The search and the buttons that copy. Without this script every page can still be read.
(() => {
  const own = document.currentScript;
  const top = own.dataset.top;
  const input = document.getElementById("search");
  const found = document.getElementById("found");
  /** Rows that are shown, and signs around what was found. */
  const MOST = 12, AROUND = 60;

  // The index is loaded when it is first asked for.
  let loading;
  const index = () => loading ||= new Promise((done) => {
    const script = document.createElement("script");
    script.src = own.dataset.index;
    script.onload = () => done(window.searchIndex.map((row) => ({
      page: row[0], heading: row[1], address: row[2], text: row[3],
      high: `${row[0]} ${row[1]}`.toLowerCase(), low: row[3].toLowerCase(),
    })));
    document.head.append(script);
  });

  const worth = (row, words, whole) => {
    let sum = 0;
    for (const word of words) {
      const high = row.high.includes(word), low = row.low.includes(word);
      if (!high && !low) return 0;
      sum += high ? 4 : 1;
    }
    if (row.heading.toLowerCase() === whole) sum += 40;
    else if (row.high.includes(whole)) sum += 20;
    else if (row.low.includes(whole)) sum += 10;
    return sum;
  };

  /** Text with the words marked. */
  const marked = (text, words) => {
    const all = document.createElement("span");
    const low = text.toLowerCase();
    let at = 0;
    while (at < text.length) {
      let next = -1, length = 0;
      for (const word of words) {
        const place = low.indexOf(word, at);
        if (place >= 0 && (next < 0 || place < next)) [next, length] = [place, word.length];
      }
      if (next < 0) break;
      const mark = document.createElement("mark");
      mark.textContent = text.slice(next, next + length);
      all.append(text.slice(at, next), mark);
      at = next + length;
    }
    all.append(text.slice(at));
    return all;
  };

  const excerpt = (row, words, whole) => {
    let place = row.low.indexOf(whole);
    if (place < 0) place = Math.max(0, row.low.indexOf(words[0]));
    const from = Math.max(0, place - AROUND);
    const part = row.text.slice(from, place + 2 * AROUND);
    return (from > 0 ? "…" : "") + part + (from + part.length < row.text.length ? "…" : "");
  };

  const show = async () => {
    const whole = input.value.trim().toLowerCase();
    const words = whole.split(/\s+/).filter(Boolean);
    if (!words.length) { found.hidden = true; return; }
    const rows = (await index())
      .map((row, place) => ({ row, place, worth: worth(row, words, whole) }))
      .filter((each) => each.worth > 0)
      .sort((a, b) => b.worth - a.worth || a.place - b.place)
      .slice(0, MOST);
    found.replaceChildren(...rows.map(({ row }) => {
      const item = document.createElement("li"), link = document.createElement("a");
      const head = document.createElement("b");
      head.textContent = row.heading === row.page ? row.page : `${row.page}: ${row.heading}`;
      link.href = top + row.address;
      link.append(head, marked(excerpt(row, words, whole), words));
      item.append(link);
      return item;
    }));
    if (!rows.length) {
      const item = document.createElement("li"), none = document.createElement("p");
      none.textContent = "No page contains all these words.";
      item.append(none);
      found.append(item);
    }
    found.hidden = false;
  };

  input.disabled = false;
  input.placeholder = "Search ( / )";
  input.addEventListener("input", show);
  input.addEventListener("focus", () => { index(); if (input.value) show(); });
  found.addEventListener("click", () => { found.hidden = true; });
  document.addEventListener("click", (event) => { if (!event.target.closest(".search")) found.hidden = true; });
  document.addEventListener("keydown", (event) => {
    const links = [...found.querySelectorAll("a")];
    const place = links.indexOf(document.activeElement);
    const inside = !found.hidden && (place >= 0 || document.activeElement === input);
    if (event.key === "/" && !event.target.closest("input")) { event.preventDefault(); input.focus(); }
    else if (event.key === "Escape" && !found.hidden) { found.hidden = true; input.focus(); }
    else if (inside && event.key === "ArrowDown") { event.preventDefault(); links[Math.min(place + 1, links.length - 1)]?.focus(); }
    else if (inside && event.key === "ArrowUp") { event.preventDefault(); (links[place - 1] || input).focus(); }
    else if (inside && event.key === "Enter" && place < 0 && links.length) { event.preventDefault(); links[0].click(); }
  });

  // Where the list of contents is longer than the screen, it shows where we are.
  const list = document.getElementById("contents"), here = list.querySelector(".above");
  if (here) list.scrollTop = here.offsetTop - list.clientHeight / 2;

  for (const block of document.querySelectorAll("main pre")) {
    const frame = document.createElement("div"), button = document.createElement("button");
    frame.className = "code";
    button.className = "copy";
    button.type = "button";
    button.textContent = "Copy";
    button.addEventListener("click", async () => {
      const text = block.textContent;
      try {
        await navigator.clipboard.writeText(text);
      } catch {
        // Where a page from the disk may not use the clipboard, a selection may.
        const selection = getSelection();
        selection.selectAllChildren(block);
        document.execCommand("copy");
        selection.removeAllRanges();
      }
      button.textContent = "Copied";
      setTimeout(() => { button.textContent = "Copy"; }, 1500);
    });
    block.replaceWith(frame);
    frame.append(block, button);
  }
})();
