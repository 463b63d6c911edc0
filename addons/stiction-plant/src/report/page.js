// A tile of the plant leads to its loop in the list.
"use strict";
for (const map of document.querySelectorAll("svg.map")) map.addEventListener("click", (event) => {
  const tile = event.target.closest("[data-k]");
  const row = tile && document.getElementById(`k${tile.dataset.k}`);
  if (!row) return;
  if (row.hidden) {
    for (const button of document.querySelectorAll("[data-chips] [aria-pressed=true]")) button.setAttribute("aria-pressed", false);
    const field = document.querySelector(".filter input");
    field.value = "";
    field.dispatchEvent(new Event("input"));
  }
  row.scrollIntoView({ block: "center" });
  row.querySelector("a")?.focus({ preventScroll: true });
  document.querySelector("tr.found")?.classList.remove("found");
  row.classList.add("found");
});
for (const tile of document.querySelectorAll("svg.map [data-k]")) {
  tile.addEventListener("pointerenter", () => {
    if (tile.querySelector("title")) return;
    const row = document.getElementById(`k${tile.dataset.k}`);
    const title = document.createElementNS("http://www.w3.org/2000/svg", "title");
    title.textContent = [...row.cells].slice(0, 5).map((cell) => cell.textContent.trim()).join(", ");
    tile.append(title);
  });
}
// On paper stand all orders with their actions, and the loops whose data are not good.
addEventListener("beforeprint", () => {
  for (const each of document.querySelectorAll("details[data-print]")) each.open = true;
});
