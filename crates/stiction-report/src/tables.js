// Sorts the rows of every <table data-sortable> by the column whose head is pressed, and shows only the
// rows that hold all words of a field above it. Without it the tables are plain.
"use strict";
(() => {
  // Numbers before words; a cell begins with its number, and a dash stands for none.
  const number = (text) => Number.parseFloat(text.replace("\u2212", "-"));
  const words = new Intl.Collator("en", { numeric: true });

  function sort(body, column, direction) {
    const keyed = [...body.rows].map((row, at) => {
      const cell = row.cells[column];
      const text = cell.dataset.value ?? cell.textContent.trim();
      return { row, at, text, value: number(text) };
    });
    const compare = (a, b) => {
      const [numberA, numberB] = [a.value, b.value].map((v) => !Number.isNaN(v));
      if (numberA && numberB) return direction * (a.value - b.value) || a.at - b.at;
      if (numberA !== numberB) return numberA ? -1 : 1;
      return direction * words.compare(a.text, b.text) || a.at - b.at;
    };
    body.append(...keyed.sort(compare).map((each) => each.row));
  }

  for (const table of document.querySelectorAll("table[data-sortable]")) {
    const body = table.tBodies[0];
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const ascending = head.getAttribute("aria-sort") !== "ascending";
        for (const each of heads) each.removeAttribute("aria-sort");
        head.setAttribute("aria-sort", ascending ? "ascending" : "descending");
        sort(body, column, ascending ? 1 : -1);
      });
    });

    const label = document.createElement("label");
    label.className = "filter";
    const field = document.createElement("input");
    field.type = "search";
    field.placeholder = "words in any column";
    const count = document.createElement("span");
    count.setAttribute("role", "status");
    label.append("Show", field, count);
    // Cells are told apart, so that words do not run from one into the next.
    const text = (row) => [...row.cells].map((cell) => cell.textContent.toLowerCase().replace(/\s+/g, " ")).join(" | ");
    // A number belongs to the word before it, and is a whole number: "group 1" is not "group 12".
    const holds = (text, term) => {
      for (let at = text.indexOf(term); at >= 0; at = text.indexOf(term, at + 1)) {
        if (!/ \d+$/.test(term) || !/\d/.test(text[at + term.length] ?? "")) return true;
      }
      return false;
    };
    const rows = [...body.rows].map((row) => ({ row, text: text(row) }));
    // Buttons: each shows the rows whose attribute of its name holds its word, among others parted by "|". Of one name
    // any counts, of several names all; none pressed shows all. A box shows the first row of each valve only.
    const buttons = [...document.querySelectorAll("[data-chips] [data-only]")];
    const first = document.querySelector("[data-chips] [data-first]");
    const filter = () => {
      const wanted = field.value.toLowerCase().trim().replace(/\s+/g, " ").match(/\S+(?: \d+(?!\S))*/g) ?? [];
      const only = {};
      for (const { dataset } of buttons.filter((each) => each.getAttribute("aria-pressed") === "true")) {
        (only[dataset.by ?? "grade"] ??= []).push(dataset.only);
      }
      const fits = ({ dataset }, only) => Object.entries(only).every(([by, words]) =>
        dataset[by] === undefined || words.some((word) => dataset[by].split("|").includes(word)));
      const left = rows.filter(({ row, text }) =>
        wanted.every((word) => holds(text, word)) && !(first?.checked && "later" in row.dataset));
      const shows = (only) => left.filter(({ row }) => fits(row, only)).length;
      for (const { row } of rows) row.hidden = true;
      for (const { row } of left) row.hidden = !fits(row, only);
      count.textContent = `${shows(only)} of ${rows.length}`;
      // A button counts what the list shows with it in place of others of its name.
      for (const button of buttons) {
        const place = button.querySelector("[data-count]");
        if (place) place.textContent = shows({ ...only, [button.dataset.by ?? "grade"]: [button.dataset.only] });
      }
    };
    field.addEventListener("input", filter);
    first?.addEventListener("change", filter);
    for (const button of buttons) {
      button.addEventListener("click", () => {
        button.setAttribute("aria-pressed", button.getAttribute("aria-pressed") !== "true");
        filter();
      });
    }
    filter();
    (table.closest(".rows") ?? table).before(label);
  }
})();
