#include "show/report/page_style.hpp"

namespace plumbline::report {

// Colours after Okabe and Ito (2008), darkened for text; every colour that means something comes with a shape or a
// word.
const char* const page_style = R"css(
:root{color-scheme:light dark;--bg:#fff;--fg:#1b1f24;--soft:#57606a;--line:#d5dae0;--panel:#f5f7f9;--link:#0b5cad;
--pass:#00795a;--pass-fill:#009e73;--undecided:#8f5d00;--undecided-fill:#e69f00;--fail:#b23a00;--fail-fill:#d55e00;
--blue:#0072b2;--band:#dcebf5;--band-edge:#8db8d6;--tol:#eef3ea}
@media (prefers-color-scheme:dark){:root{--bg:#14181d;--fg:#e6e9ec;--soft:#a0a9b3;--line:#39424c;--panel:#1d232a;--link:#7cb7f0;
--pass:#45c9a2;--pass-fill:#00a878;--undecided:#f0b440;--undecided-fill:#e69f00;--fail:#ff8f52;--fail-fill:#e0661a;
--blue:#5aaee0;--band:#1f3a4d;--band-edge:#43708d;--tol:#222b24}}
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%}
body{margin:0;background:var(--bg);color:var(--fg);font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans","DejaVu Sans",sans-serif;
font-variant-numeric:tabular-nums}
main{max-width:1120px;margin:0 auto;padding:28px 32px 64px}
h1{font-size:1.9rem;line-height:1.2;margin:0 0 2px;letter-spacing:-.01em}
h2{font-size:1.3rem;line-height:1.25;margin:0 0 10px}
h3{font-size:1rem;margin:22px 0 6px}
p{margin:0 0 10px;max-width:78ch}
a{color:var(--link)}
section{margin-top:40px}
.subtitle,.note,figcaption,.soft{color:var(--soft)}
.note,figcaption{font-size:.88rem}
nav{margin:14px 0 0;font-size:.9rem;display:flex;flex-wrap:wrap;gap:4px 16px}
.verdict{margin-top:22px;padding:18px 22px;border:1px solid var(--line);border-left:10px solid var(--soft);border-radius:6px;background:var(--panel);
display:flex;gap:20px;align-items:flex-start}
.verdict>svg{flex:none;margin-top:4px}
.verdict strong{display:block;font-size:1.35rem;line-height:1.3}
.verdict p{margin:6px 0 0;max-width:92ch}
.verdict.pass{border-left-color:var(--pass-fill)}.verdict.fail{border-left-color:var(--fail-fill)}.verdict.undecided{border-left-color:var(--undecided-fill)}
.tally{display:flex;flex-wrap:wrap;gap:6px 22px;margin-top:10px;font-size:1rem}
.warnings{margin-top:16px;padding:12px 22px;border:1px solid var(--undecided-fill);border-radius:6px}
.warnings h2{font-size:1rem;margin:0 0 4px}.warnings ul{margin:0;padding-left:20px}.warnings li{max-width:92ch}
.cards{display:grid;grid-template-columns:repeat(4,1fr);gap:12px}
.card{border:1px solid var(--line);border-radius:6px;padding:12px 14px}
.card .name{font-size:.85rem;color:var(--soft)}
.card .value{font-size:1.5rem;font-weight:600;line-height:1.3;white-space:nowrap}
.card .more{font-size:.82rem;color:var(--soft);line-height:1.4}
.wide{overflow-x:auto}.wide table{min-width:min(100%,max-content)}
table{border-collapse:collapse;width:100%;font-size:.9rem;margin:8px 0 4px}
th,td{padding:5px 9px;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap}
th{font-weight:600}
thead th{vertical-align:bottom;border-bottom:2px solid var(--soft);line-height:1.25;white-space:normal}
tbody th{font-weight:500}
td.text,th.text,tbody th,thead th:first-child{text-align:left}
td.words{white-space:normal;text-align:left}.whole{white-space:nowrap}.wide td.words{min-width:15em}
tbody tr:nth-child(even){background:var(--panel)}
thead th[data-sortable]{cursor:pointer}
thead th[aria-sort=ascending]::after{content:" ▲";font-size:.7em}thead th[aria-sort=descending]::after{content:" ▼";font-size:.7em}
.badge{white-space:nowrap;font-weight:600}.badge svg{vertical-align:-1px;margin-right:5px}.badge .symbol:not(.open){stroke:none}
.badge.pass{color:var(--pass)}.badge.undecided{color:var(--undecided)}.badge.fail{color:var(--fail)}.badge.unmeasured{color:var(--soft)}
figure{margin:14px 0 6px}
figure,.drawing{overflow-x:auto}figure>svg,.drawing>svg{display:block;max-width:100%;height:auto}
.pair{display:grid;grid-template-columns:1fr 1fr;gap:24px;align-items:start}.pair figure{margin-top:0}
.legend{display:flex;flex-wrap:wrap;gap:4px 20px;font-size:.86rem;color:var(--soft);margin:2px 0 4px}
.legend svg{vertical-align:-2px;margin-right:6px}
svg text{fill:var(--fg);font-size:12px;font-family:inherit}
svg .tick,svg .small{fill:var(--soft);font-size:12px}
svg .axis-title{fill:var(--soft);font-size:12.5px}
svg .mark{font-size:13px}
svg .strong{font-weight:600}
svg .halo{paint-order:stroke;stroke:var(--bg);stroke-width:4px;stroke-linejoin:round}
.grid{stroke:var(--line);stroke-width:1}.axis{stroke:var(--soft);stroke-width:1}
.zero{stroke:var(--fg);stroke-width:1}.tolerance{fill:var(--tol)}.tolerance-edge{stroke:var(--pass);stroke-width:1.2;stroke-dasharray:6 4}
.band{fill:var(--band)}.band-edge{stroke:var(--band-edge);fill:none}
.mean{stroke:var(--blue);fill:var(--blue);stroke-width:1.6}.drift{stroke:var(--fail-fill);fill:var(--fail-fill);stroke-width:1.6}
.curve{stroke:var(--blue);stroke-width:2;fill:none}.goal{stroke:var(--soft);stroke-width:1.2;stroke-dasharray:2 4}
.headline{stroke:var(--fg);stroke-width:1.2;stroke-dasharray:6 4}
.symbol{stroke-width:1.8;stroke:var(--bg);fill:var(--soft)}
.symbol.pass{fill:var(--pass-fill)}.symbol.undecided{fill:var(--undecided-fill)}.symbol.fail{fill:var(--fail-fill)}
.symbol.hollow{fill:var(--bg)}.symbol.hollow.pass{stroke:var(--pass-fill)}.symbol.hollow.undecided{stroke:var(--undecided-fill)}.symbol.hollow.fail{stroke:var(--fail-fill)}
.symbol.open{fill:none;stroke:var(--soft)}
.shaft{stroke:var(--fg);stroke-width:2}.head{fill:var(--fg)}
.moved.shaft{stroke:var(--fail-fill)}.moved.head{fill:var(--fail-fill)}
svg image{opacity:.75}.heat{opacity:.85}.heat polygon{stroke:none}
.quad{fill-opacity:.16;stroke-width:1.2}.quad.pass{fill:var(--pass-fill);stroke:var(--pass-fill)}.quad.undecided{fill:var(--undecided-fill);stroke:var(--undecided-fill);stroke-dasharray:6 3}
.quad.fail{fill:var(--fail-fill);stroke:var(--fail-fill);stroke-width:2.4}.quad.unmeasured{fill:none;stroke:var(--soft);stroke-dasharray:2 3}
.tasks td.words{min-width:14em;max-width:34em}.tally b{min-width:4.5em;font-weight:600}
#space .stack{position:relative}#space .stack[hidden]{display:none}#canvas{position:relative;display:block;width:100%;height:auto;touch-action:none;border:1px solid var(--line);border-radius:6px;cursor:grab}
#canvas-space{position:absolute;inset:1px;width:calc(100% - 2px);height:calc(100% - 2px)}#space label.tick[hidden]{display:none}#space label.tick input{flex:none;margin-right:6px}
.storey{stroke:var(--line);stroke-dasharray:3 5}
.ellipse{fill:var(--band);stroke:var(--blue);stroke-width:1.3;fill-opacity:.75}.bar{stroke:var(--blue);stroke-width:2}
.sight{fill:none;stroke:var(--line);stroke-width:1}.sight.suspect{stroke:var(--fail-fill);stroke-width:2.4}.station{fill:var(--fg)}.datum-ring{fill:none;stroke:var(--fg);stroke-width:1.4}.dot{fill:var(--fg)}
.slider{display:flex;flex-wrap:wrap;gap:8px 16px;align-items:center;padding:10px 14px;border:1px solid var(--line);border-radius:6px;background:var(--panel);margin:10px 0}
.symbol.thin{stroke-width:.5}.shaft.thin{stroke-width:.8;fill:none}
.filter{position:sticky;top:0;z-index:2}.filter input{flex:1 1 10em;min-width:0}.filter select{max-width:14em}
.more{margin:6px 0}@media screen{tr.later,tr[hidden]{display:none!important}}.slider[hidden]{display:none}.slider input{flex:1 1 260px;accent-color:var(--blue)}.slider output{font-weight:600}
details summary{cursor:pointer;color:var(--link);margin:8px 0}
code{font-size:.86em;overflow-wrap:anywhere}
.facts td{white-space:normal;text-align:left;overflow-wrap:anywhere}.facts th{text-align:left;vertical-align:top;width:16em}
@media screen and (max-width:920px){.pair{grid-template-columns:1fr}table{font-size:.82rem}th,td{padding:5px 6px}
figure>svg .tick,figure>svg .small,figure>svg .axis-title{font-size:15px}.pair figure>svg .small{font-size:12px}}
@media screen and (max-width:760px){figure>svg{max-width:none;min-width:760px}figure>svg text,figure>svg .tick,figure>svg .small,figure>svg .axis-title{font-size:14px}
.verdict{padding:12px;gap:10px}.verdict>svg{width:30px;height:30px}th,td{white-space:normal}
.tasks,.tasks tbody{display:block;min-width:0}.tasks thead{display:none}
.tasks tr{display:block;padding:8px 0;border-bottom:1px solid var(--line)}.tasks th,.tasks td,.tasks td.words{display:inline-block;min-width:0;max-width:none;border:0;padding:1px 8px 1px 0}
.tasks td.words{display:block}.tasks td[data-head]::before{content:attr(data-head) " "}.tasks .todo{font-weight:600}
main{padding:18px 16px 48px}.cards{grid-template-columns:1fr 1fr}}
@media print{
:root{color-scheme:light;--bg:#fff;--fg:#000;--soft:#444;--line:#c8cdd2;--panel:#f5f7f9;--link:#000;
--pass:#00664b;--pass-fill:#009e73;--undecided:#7a4f00;--undecided-fill:#e69f00;--fail:#a03400;--fail-fill:#d55e00;--blue:#0072b2;--band:#dcebf5;--band-edge:#8db8d6;--tol:#eef3ea}
@page{size:A4;margin:14mm 14mm 16mm}
body{font-size:10pt;-webkit-print-color-adjust:exact;print-color-adjust:exact}
main{max-width:none;padding:0}nav,.slider,.screen{display:none}figure>svg{max-width:100%;max-height:230mm}figure{overflow:visible}
section{margin-top:20pt}h2{break-after:avoid}h3{break-after:avoid}
figure,.card,.verdict,.warnings,tr{break-inside:avoid}thead{display:table-header-group}
html{font-size:12.5px}table{font-size:7.3pt}th,td{padding:2pt;white-space:normal;overflow-wrap:break-word}td:not(.text):not(.words){white-space:nowrap}.pair{gap:10px}.pair svg .mark{font-size:14px}.card .value{font-size:14pt}
.wide{overflow:visible}.wide td.words{min-width:0}.wide table{font-size:6.3pt}a{text-decoration:none}
details summary{font-weight:600;color:var(--fg);list-style:none}details::details-content{content-visibility:visible;display:block}
}
)css";

const char* const page_script = R"js(
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
  // Rows of anchors and panels: those that are asked for, and of many the first.
  const filter = document.getElementById("filter"), placed = [...document.querySelectorAll("tr[data-floor]")];
  const tables = [...new Set(placed.map(row => row.closest("table")))], shown = 200, all = new Set();
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
        if (fits) found.add(row.cells[0].textContent.replace(/^(Anchor|Panel) /, ""));
        row.hidden = !fits;
        row.classList.toggle("later", fits && ++n > shown && !all.has(table));
      }
      const button = more.get(table);
      button.hidden = n <= shown || all.has(table);
      button.textContent = "Show all " + n + " rows";
      const fold = table.closest("details.fold");
      if (any && fold && n > 0) fold.open = true;
    }
    document.getElementById("filter-count").textContent = any ? found.size + " found" : "";
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
)js";

}  // namespace plumbline::report
