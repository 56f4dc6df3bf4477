// The table of runs: sorted by any column, filtered by words, stage and outcome.
(() => {
  "use strict";

  const controls = document.querySelector('.controls[data-for="runs-table"]');
  if (!controls) {
    return;
  }
  const table = document.getElementById("runs-table");
  const body = table.tBodies[0];
  const rows = [...body.rows];
  const texts = rows.map((row) => row.textContent.toLowerCase());
  const count = controls.querySelector("[data-count]");

  const filter = () => {
    const wanted = Object.fromEntries(
      [...controls.querySelectorAll("[data-filter]")].map((input) => [
        input.dataset.filter,
        input.value.trim().toLowerCase(),
      ]),
    );
    const words = wanted.text.split(/\s+/).filter(Boolean);
    let shown = 0;
    rows.forEach((row, i) => {
      const fits =
        (!wanted.stage || row.dataset.stage === wanted.stage) &&
        (!wanted.outcome || row.dataset.outcome === wanted.outcome) &&
        words.every((word) => texts[i].includes(word));
      row.hidden = !fits;
      shown += fits ? 1 : 0;
    });
    count.textContent = shown === rows.length ? "" : `${shown} of ${rows.length} shown`;
  };
  controls.addEventListener("input", filter);
  // A link leads to a row that a filter may have hidden.
  addEventListener("hashchange", () => {
    const row = location.hash.startsWith("#run-") && document.getElementById(location.hash.slice(1));
    if (row) {
      controls.querySelectorAll("[data-filter]").forEach((input) => {
        input.value = "";
      });
      filter();
      row.scrollIntoView({ block: "center" });
    }
  });

  const keyOf = (row, column) => {
    const cell = row.cells[column];
    if (cell.dataset.value !== undefined) {
      return Number(cell.dataset.value);
    }
    // Rows without a number come last, in both directions.
    return cell.classList.contains("number") ? null : cell.textContent.trim();
  };
  const compare = (a, b) =>
    typeof a === "string" ? a.localeCompare(b) : a - b;

  const sort = (header) => {
    const column = header.cellIndex;
    const descending = header.getAttribute("aria-sort") === "ascending";
    for (const other of table.tHead.rows[0].cells) {
      other.removeAttribute("aria-sort");
    }
    header.setAttribute("aria-sort", descending ? "descending" : "ascending");
    const sign = descending ? -1 : 1;
    const keyed = rows.map((row) => [keyOf(row, column), row]);
    keyed.sort(([a], [b]) => {
      if (a === null || b === null) {
        return (a === null) - (b === null);
      }
      return sign * compare(a, b);
    });
    body.append(...keyed.map(([, row]) => row));
  };
  table.tHead.addEventListener("click", (event) => {
    const header = event.target.closest("button")?.closest("th");
    if (header) {
      sort(header);
    }
  });
})();
