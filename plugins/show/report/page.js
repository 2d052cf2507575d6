// Of every page: folding, sorting of tables.
"use strict";
(() => {
  // What is folded here is open without this script, and on paper.
  const folds = () => document.querySelectorAll("details");
  for (const fold of document.querySelectorAll("details.fold")) fold.open = false;
  let before = [];
  addEventListener("beforeprint", () => { before = [...folds()].map(d => [d, d.open]); for (const d of folds()) d.open = true; });
  addEventListener("afterprint", () => { for (const [d, open] of before) d.open = open; });
  const key = cell => {
    const text = cell ? cell.textContent.trim() : "";
    const number = parseFloat(text.replace("\u2212", "-").replace(/[<>\u00a0 ]/g, ""));
    const verdicts = ["fail", "undecided", "not measured", "pass"], rank = verdicts.indexOf(text);
    if (rank >= 0) return rank;
    // A name that begins with a digit is no number.
    return Number.isNaN(number) || /^[A-Za-z]/.test(text) || (cell && cell.tagName === "TH" && !/^[-+0-9.\u2212]+$/.test(text)) ? text : number;
  };
  for (const table of document.querySelectorAll("table.sortable")) {
    const heads = [...table.tHead.rows[0].cells], body = table.tBodies[0];
    heads.forEach((head, column) => {
      head.dataset.sortable = ""; head.tabIndex = 0;
      const sort = () => {
        const up = head.getAttribute("aria-sort") !== "ascending";
        heads.forEach(other => other.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", up ? "ascending" : "descending");
        const rows = [...body.rows].sort((a, b) => {
          const x = key(a.cells[column]), y = key(b.cells[column]);
          const order = typeof x === "number" && typeof y === "number" ? x - y
            : String(x).localeCompare(String(y), "en", {numeric: true});
          return up ? order : -order;
        });
        body.append(...rows);
      };
      head.addEventListener("click", sort);
      head.addEventListener("keydown", event => { if (event.key === "Enter") sort(); });
    });
  }
})();
