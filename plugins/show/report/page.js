// Of every page: what scripts say, folding, sorting of tables.
"use strict";
// Texts, decimal sign and unit where a page is not in English and millimetres; script_data.cpp writes them.
const spoken = JSON.parse(document.getElementById("spoken")?.textContent ?? "{}");
const fromBytes = text => { try { return decodeURIComponent(escape(text)); } catch { return text; } };
const texts = Object.fromEntries(Object.entries(spoken.texts ?? {}).map(([k, v]) => [fromBytes(k), fromBytes(v)]));
const tell = (text, ...values) => (texts[text] ?? text).replace(/\{(\d)\}/g, (_, k) => values[k]);
const decimal = text => spoken.decimal ? text.replace(".", spoken.decimal) : text;
const lengthUnit = fromBytes(spoken.unit ?? "mm");
// Of a length in mm: inches have two digits more.
const lengthText = (length, digits) => decimal(spoken.unit ? (length / 25.4).toFixed(digits + 2) : length.toFixed(digits));
(() => {
  // What is folded here is open without this script, and on paper.
  const folds = () => document.querySelectorAll("details");
  for (const fold of document.querySelectorAll("details.fold")) fold.open = false;
  let before = [];
  addEventListener("beforeprint", () => { before = [...folds()].map(d => [d, d.open]); for (const d of folds()) d.open = true; });
  addEventListener("afterprint", () => { for (const [d, open] of before) d.open = open; });
  const key = cell => {
    const text = cell ? cell.textContent.trim() : "";
    const plain = text.replace("\u2212", "-").replace(/[<>\u00a0 ]/g, "");
    const number = parseFloat(spoken.decimal ? plain.replace(spoken.decimal, ".") : plain);
    const verdicts = ["fail", "undecided", "not measured", "pass"].map(word => tell(word)), rank = verdicts.indexOf(text);
    if (rank >= 0) return rank;
    // A name that begins with a digit is no number.
    return Number.isNaN(number) || /^[A-Za-z]/.test(text) || (cell && cell.tagName === "TH" && !/^[-+0-9.,\u2212]+$/.test(text)) ? text : number;
  };
  // Rows of anchors and panels: those that are asked for, and of many the first.
  const filter = document.getElementById("filter"), placed = [...document.querySelectorAll("tr[data-floor]")];
  const tables = [...new Set(placed.map(row => row.closest("table")))], shown = 200, all = new Set();
  const kinds = new RegExp("^(" + tell("Anchor") + "|" + tell("Panel") + ") ");
  const choice = name => { const box = document.getElementById("filter-" + name); return box ? box.value : ""; };
  const sift = () => {
    const name = choice("name").trim().toLowerCase(), asked = ["facade", "floor", "verdict"].map(key => [key, choice(key)]);
    const any = name !== "" || asked.some(([, value]) => value !== "");
    const found = new Set();
    for (const table of tables) {
      let n = 0;
      for (const row of table.tBodies[0].rows) {
        const fits = (name === "" || row.cells[0].textContent.toLowerCase().includes(name)) &&
          asked.every(([key, value]) => value === "" || row.dataset[key] === value);
        if (fits) found.add(row.cells[0].textContent.replace(kinds, ""));
        row.hidden = !fits;
        row.classList.toggle("later", fits && ++n > shown && !all.has(table));
      }
      const button = more.get(table);
      button.hidden = n <= shown || all.has(table);
      button.textContent = tell("Show all {0} rows", n);
      const fold = table.closest("details.fold");
      if (any && fold && n > 0) fold.open = true;
    }
    document.getElementById("filter-count").textContent = any ? tell("{0} found", found.size) : "";
  };
  const more = new Map(tables.map(table => {
    const button = document.createElement("button");
    button.className = "more screen"; button.hidden = true;
    button.addEventListener("click", () => { all.add(table); sift(); });
    table.parentElement.after(button);
    return [table, button];
  }));
  if (filter && placed.length > 20) {
    filter.hidden = false;
    filter.addEventListener("input", sift);
    sift();
  }
  document.documentElement.classList.remove("waiting");  // filter_section.cpp: sift() says which rows are shown now
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
        if (more.has(table) && filter && !filter.hidden) sift();
      };
      head.addEventListener("click", sort);
      head.addEventListener("keydown", event => { if (event.key === "Enter") sort(); });
    });
  }
})();
