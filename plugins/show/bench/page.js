'use strict';
// Draws what the page's data hold; without it the verdicts, the table and the failures are still there.
const data = JSON.parse(document.getElementById('data').textContent);
const palette = ['#0b6e8f', '#d1661a', '#1b7f4b', '#8b4bb0', '#b3372c', '#7a6a10', '#3d5fc4', '#b0447c', '#4b8c8c', '#6b6b6b'];
const names = [...new Set(data.rows.map(r => r.name))];
const colour = name => palette[names.indexOf(name) % palette.length];
const places = [...new Set(data.rows.map(r => r.place))];
const known = x => typeof x === 'number' && isFinite(x);
const mm = x => known(x) ? 1e3 * x : null;
const escaped = t => String(t).replace(/[&<>"]/g, c => ({'&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;'}[c]));
const shown = x => !known(x) ? '–' : Math.abs(x) >= 100 ? x.toFixed(0) : Math.abs(x) >= 10 ? x.toFixed(1) : Math.abs(x) >= 0.1 || x === 0 ? x.toFixed(2) : x.toPrecision(2);
const placeName = p => p || 'all trials';

function ticks(low, high, wanted) {
  const raw = (high - low) / wanted, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map(k => k * power).find(s => s >= raw);
  const list = [];
  for (let t = Math.ceil(low / step - 1e-9) * step; t <= high + 1e-9 * step; t += step) list.push(Math.abs(t) < 1e-12 ? 0 : t);
  return list;
}

// A frame with axes; x and y map values to places. Logarithmic axes have ticks at 1, 2, 5.
class Plot {
  constructor(options) {
    Object.assign(this, {width: 860, height: 340, left: 62, right: 16, top: 12, bottom: 44}, options);
    this.parts = [];
    for (const axis of ['x', 'y']) {
      let [low, high] = this[axis + 'Range'];
      if (!(high > low)) { const pad = Math.abs(low) * 0.1 || 1; low -= pad; high += pad; }
      if (this[axis + 'Log'] && !(low > 0)) low = high / 1000;
      this[axis + 'Range'] = [low, high];
    }
    this.axes();
  }
  scale(v, [low, high], log) { return log ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low); }
  x(v) { return this.left + this.scale(v, this.xRange, this.xLog) * (this.width - this.left - this.right); }
  y(v) { return this.height - this.bottom - this.scale(v, this.yRange, this.yLog) * (this.height - this.top - this.bottom); }
  list([low, high], log, wanted) {
    if (!log) return ticks(low, high, wanted);
    const all = [];
    for (let p = Math.floor(Math.log10(low)); p <= Math.ceil(Math.log10(high)); ++p)
      for (const k of high / low > 300 ? [1] : [1, 2, 5]) if (k * 10 ** p >= low * 0.999 && k * 10 ** p <= high * 1.001) all.push(k * 10 ** p);
    return all.length > 1 ? all : ticks(low, high, 4);
  }
  axes() {
    for (const t of this.xTicks || this.list(this.xRange, this.xLog, 8)) {
      this.add(`<line class="grid" x1="${this.x(t)}" x2="${this.x(t)}" y1="${this.top}" y2="${this.height - this.bottom}"/>`);
      this.add(`<text x="${this.x(t)}" y="${this.height - this.bottom + 16}" text-anchor="middle">${+t.toPrecision(4)}</text>`);
    }
    if (!this.bare) for (const t of this.list(this.yRange, this.yLog, 6)) {
      this.add(`<line class="grid" x1="${this.left}" x2="${this.width - this.right}" y1="${this.y(t)}" y2="${this.y(t)}"/>`);
      this.add(`<text x="${this.left - 6}" y="${this.y(t) + 4}" text-anchor="end">${+t.toPrecision(4)}</text>`);
    }
    this.add(`<text class="soft" x="${(this.left + this.width - this.right) / 2}" y="${this.height - 8}" text-anchor="middle">${escaped(this.xLabel)}</text>`);
    if (this.yLabel) this.add(`<text class="soft" transform="translate(14 ${this.height / 2}) rotate(-90)" text-anchor="middle">${escaped(this.yLabel)}</text>`);
  }
  add(part) { this.parts.push(part); }
  line(points, stroke, more = '') { this.add(`<polyline fill="none" stroke="${stroke}" stroke-width="2" ${more} points="${points.map(([a, b]) => this.x(a).toFixed(1) + ',' + this.y(b).toFixed(1)).join(' ')}"/>`); }
  dot(a, b, fill, title, r = 4, opacity = 1) { this.add(`<circle cx="${this.x(a).toFixed(1)}" cy="${this.y(b).toFixed(1)}" r="${r}" fill="${fill}" fill-opacity="${opacity}"><title>${escaped(title)}</title></circle>`); }
  put(id) { document.getElementById(id).innerHTML = `<svg viewBox="0 0 ${this.width} ${this.height}" role="img">${this.parts.join('')}</svg>`; }
}

function legend(id, list) {
  document.getElementById(id).innerHTML = list.map(n => `<span><i style="background:${colour(n)}"></i>${escaped(n || 'the pipeline')}</span>`).join('');
}
function choices(id, list, draw, text = placeName) {
  const select = document.getElementById(id);
  select.innerHTML = list.map((v, i) => `<option value="${i}">${escaped(text(v))}</option>`).join('');
  select.onchange = () => draw(list[select.value]);
  if (list.length < 2) select.hidden = true;
  if (list.length) draw(list[0]);
}
const range = (list, pad = 0.06) => { const a = Math.min(...list), b = Math.max(...list), d = (b - a) * pad; return [a - d, b + d]; };
function nothing(id, why) { document.getElementById(id).innerHTML = `<p class="soft">${escaped(why)}</p>`; }

// Intervals, one a line: differences, efficiency, NEES.
function forest(id, lines, label, marks, band) {
  if (!lines.length) return nothing(id, 'Nothing to show here.');
  const all = lines.flatMap(l => [l.low, l.high, l.value, ...(l.band || [])]).filter(known).concat(marks, band || []);
  const left = Math.min(430, 20 + 7.3 * Math.max(...lines.map(l => l.name.length)));
  const plot = new Plot({height: 60 + 20 * lines.length, left, top: 6, xRange: range(all), yRange: [0, lines.length], xLabel: label, bare: true});
  if (band) plot.add(`<rect x="${plot.x(band[0])}" width="${plot.x(band[1]) - plot.x(band[0])}" y="${plot.top}" height="${plot.height - plot.top - plot.bottom}" fill="var(--good)" fill-opacity=".13"/>`);
  for (const m of marks) plot.add(`<line class="axis" x1="${plot.x(m)}" x2="${plot.x(m)}" y1="${plot.top}" y2="${plot.height - plot.bottom}"/>`);
  lines.forEach((l, i) => {
    const y = lines.length - i - 0.5, at = plot.y(y);
    const cut = l.name.length > 64 ? l.name.slice(0, 62) + '…' : l.name;
    plot.add(`<text x="${left - 8}" y="${at + 4}" text-anchor="end" ${l.strong ? 'font-weight="600"' : ''}>${escaped(cut)}<title>${escaped(l.title)}</title></text>`);
    if (l.band) plot.add(`<line x1="${plot.x(l.band[0])}" x2="${plot.x(l.band[1])}" y1="${at}" y2="${at}" stroke="var(--good)" stroke-opacity=".25" stroke-width="12"/>`);
    if (known(l.low) && known(l.high)) plot.add(`<line x1="${plot.x(l.low)}" x2="${plot.x(l.high)}" y1="${at}" y2="${at}" stroke="${l.colour}" stroke-width="2.5"/>`);
    if (known(l.value)) plot.dot(l.value, y, l.colour, l.title, 4.5);
  });
  plot.put(id);
}

function drawDifferences(group) {
  const tint = {'first better': 'var(--good)', 'second better': 'var(--good)', 'equal': 'var(--same)', 'undecided': 'var(--soft)'};
  const drawn = data.duels.filter(d => d.group === group && d.shown && !d.refused && known(d.difference[1]));
  const pair = d => `${d.first} − ${d.second}`, headed = new Set(drawn.filter(d => d.overall).map(pair));
  const lines = drawn.map(d => ({  // places stand below the line of their pair over all places
    name: d.overall ? `${pair(d)}, all places` : headed.has(pair(d)) ? placeName(d.place) : `${pair(d)}${d.place ? ', ' + d.place : ''}`, value: mm(d.difference[0]), low: mm(d.difference[1]), high: mm(d.difference[2]),
    colour: tint[d.verdict] || 'var(--soft)', title: d.words, strong: d.overall}));
  forest('differences', lines, 'difference of RMSE [mm]; left: the first is better' + (data.rope ? '; shaded: rope' : ''), [0], data.rope ? [-mm(data.rope), mm(data.rope)] : null);
}

function drawPairs(duel) {
  const pairs = [];
  const without = r => JSON.stringify([r.place, Object.entries(r.choices).filter(([g]) => g !== duel.group)]);
  for (const a of data.rows.filter(r => r.choices[duel.group] === duel.first && (duel.overall || r.place === duel.place)))
    for (const b of data.rows.filter(r => r.choices[duel.group] === duel.second && without(r) === without(a))) {
      const of = new Map(b.seeds.map((s, i) => [s, b.errors[i]]));
      a.seeds.forEach((s, i) => { if (of.has(s)) pairs.push([mm(a.errors[i]), mm(of.get(s)), `${placeName(a.place)}, seed ${s}`]); });
    }
  if (!pairs.length) return nothing('pairs', 'No trial that both finished.');
  const positive = pairs.flat().filter(v => known(v) && v > 0), limits = range(positive, 0);
  const log = limits[1] / limits[0] > 8, pad = log ? [limits[0] / 1.15, limits[1] * 1.15] : range(positive);
  const plot = new Plot({width: 560, height: 420, xRange: pad, yRange: pad, xLog: log, yLog: log, xLabel: `${duel.first}: error of a trial [mm]`, yLabel: `${duel.second} [mm]`});
  plot.line([[plot.xRange[0], plot.xRange[0]], [plot.xRange[1], plot.xRange[1]]], 'var(--soft)', 'stroke-dasharray="4 4"');
  for (const [x, y, title] of pairs) plot.dot(x, y, 'var(--accent)', `${title}: ${shown(x)} and ${shown(y)} mm`, 3, 0.55);
  plot.put('pairs');
}

function drawProfile(place) {
  const rows = data.rows.filter(r => r.place === place && r.trials > 0);
  const values = rows.flatMap(r => r.worst).filter(known).map(mm);
  if (!values.length) return nothing('profile', 'The largest error of a trial is not measured (measure: worst).');
  const high = Math.max(...values, ...data.tolerances.map(mm)), low = Math.max(Math.min(...values), high / 2000);
  const plot = new Plot({xRange: [low / 1.1, high * 1.05], yRange: [0, 1], xLog: true, xLabel: 'largest error of a trial is at most … [mm]', yLabel: 'share of trials'});
  for (const tau of data.tolerances.map(mm)) plot.add(`<line x1="${plot.x(tau)}" x2="${plot.x(tau)}" y1="${plot.top}" y2="${plot.height - plot.bottom}" stroke="var(--soft)" stroke-dasharray="2 4"><title>tolerance ${tau} mm</title></line>`);
  for (const [index, r] of rows.entries()) {
    const sorted = r.worst.map(mm).filter(known).sort((a, b) => a - b), points = [[plot.xRange[0], 0]], cells = Math.max(r.trials, sorted.length);  // seeds that all gave the same are one trial
    sorted.forEach((v, i) => { const x = Math.max(v, plot.xRange[0]); points.push([x, i / cells], [x, (i + 1) / cells]); });
    points.push([plot.xRange[1], sorted.length / cells]);
    // What is the same lies on top of each other: the first is the widest, so that all are seen.
    plot.line(points, colour(r.name), `style="stroke-width:${Math.min(9, 2 + 2 * (rows.length - 1 - index))}"`);
  }
  plot.put('profile');
}

function drawBreakdown(variable) {
  const others = r => placeName(r.place.split(', ').filter(p => !p.startsWith(variable.name + '=')).join(', '));
  const rest = [...new Set(data.rows.map(others))];
  choices('breakdown-place', rest, where => {
    const rows = data.rows.filter(r => others(r) === where && known(r.rmse[0]) && known(+r.values[variable.name]));
    if (!rows.length) return nothing('breakdown', 'No finished trials here.');
    const xs = [...new Set(variable.values.map(Number))].sort((a, b) => a - b);
    const all = rows.flatMap(r => r.rmse).filter(known).map(mm), top = Math.max(...all), bottom = Math.min(...all), log = top / bottom > 12;
    const plot = new Plot({xRange: range(xs, 0.03), xTicks: xs, yRange: log ? [bottom / 1.2, top * 1.2] : [0, top * 1.05], yLog: log, xLabel: variable.name, yLabel: 'RMSE [mm], with its interval'});
    for (const name of names) {
      const mine = rows.filter(r => r.name === name).sort((a, b) => a.values[variable.name] - b.values[variable.name]);
      if (!mine.length) continue;
      const band = mine.filter(r => known(r.rmse[1])), edge = k => band.map(r => [+r.values[variable.name], Math.max(mm(r.rmse[k]), plot.yRange[0])]);
      if (band.length > 1) plot.add(`<polygon fill="${colour(name)}" fill-opacity=".12" points="${edge(1).concat(edge(2).reverse()).map(([a, b]) => plot.x(a) + ',' + plot.y(b)).join(' ')}"/>`);
      plot.line(mine.map(r => [+r.values[variable.name], mm(r.rmse[0])]), colour(name));
      for (const r of mine) plot.dot(+r.values[variable.name], mm(r.rmse[0]), colour(name), `${name}, ${variable.name}=${r.values[variable.name]}: ${shown(mm(r.rmse[0]))} mm, ${r.failures} of ${r.trials} failed`);
    }
    plot.put('breakdown');
  });
}

function drawTimes(place) {
  const rows = data.rows.filter(r => r.place === place && known(r.seconds) && r.seconds > 0 && known(r.rmse[0]));
  if (!rows.length) return nothing('times', 'No times here: what the alternatives change was taken from the store.');
  const xs = rows.map(r => 1e3 * r.seconds), top = Math.max(...rows.map(r => mm(known(r.rmse[2]) ? r.rmse[2] : r.rmse[0])));
  const plot = new Plot({xRange: [Math.min(...xs) / 1.4, Math.max(...xs) * 1.4], xLog: true, yRange: [0, top * 1.08], xLabel: 'median time of what the alternatives change [ms]', yLabel: 'RMSE [mm]'});
  for (const r of rows) {
    const x = 1e3 * r.seconds;
    if (known(r.rmse[1])) plot.line([[x, mm(r.rmse[1])], [x, mm(r.rmse[2])]], colour(r.name));
    plot.dot(x, mm(r.rmse[0]), colour(r.name), `${r.name}: ${shown(x)} ms, ${shown(mm(r.rmse[0]))} mm`, 5);
  }
  plot.put('times');
}

function drawLimits(place) {
  const rows = data.rows.filter(r => r.place === place);
  const bound = rows.filter(r => known(r.efficiency[0]));
  if (bound.length) forest('bound', bound.map(r => ({name: r.name, value: r.efficiency[0], low: r.efficiency[1], high: r.efficiency[2], colour: colour(r.name), title: `${r.name}: ${shown(r.efficiency[0])}`})), 'Cramér–Rao bound² / MSE; 1 is the best possible without bias', [1]);
  else nothing('bound', 'The bound is not measured here (measure: bound).');
  const nees = rows.filter(r => known(r.nees));
  if (nees.length) forest('nees', nees.map(r => ({name: r.name, value: r.nees, band: r.band, colour: known(r.band[0]) && (r.nees < r.band[0] || r.nees > r.band[1]) ? 'var(--bad)' : 'var(--good)', title: `${r.name}: ${shown(r.nees)}, band ${shown(r.band[0])} to ${shown(r.band[1])}`})), 'NEES per degree of freedom; shaded: where an honest covariance puts it', [1]);
  else nothing('nees', 'NEES is not measured here (measure: nees, freedom).');
}

function table() {
  const box = document.getElementById('filter'), body = document.querySelector('#rows tbody'), lines = [...body.rows];
  box.oninput = () => {
    const words = box.value.toLowerCase().split(/\s+/).filter(Boolean);
    let left = 0;
    for (const line of lines) { const fits = words.every(w => line.textContent.toLowerCase().includes(w)); line.hidden = !fits; left += fits; }
    document.getElementById('count').textContent = `${left} of ${lines.length} rows`;
  };
  box.oninput();
  document.querySelectorAll('#rows th').forEach((head, column) => head.onclick = () => {
    const up = head.getAttribute('aria-sort') !== 'ascending';
    document.querySelectorAll('#rows th').forEach(h => h.removeAttribute('aria-sort'));
    head.setAttribute('aria-sort', up ? 'ascending' : 'descending');
    const value = line => { const cell = line.cells[column], n = cell.dataset.v; return n === undefined ? cell.textContent : n === '' ? Infinity : +n; };
    lines.sort((a, b) => { const x = value(a), y = value(b); return (x < y ? -1 : x > y ? 1 : 0) * (up ? 1 : -1); }).forEach(l => body.append(l));
  });
}

table();
const groups = [...new Set(data.duels.map(d => d.group))];
if (groups.length) {
  choices('differences-group', groups, drawDifferences, g => g);
  choices('pairs-duel', data.duels.filter(d => !d.refused && d.pairs > 0), drawPairs, d => `${d.first} and ${d.second}, ${d.overall ? 'all places' : placeName(d.place)}`);
} else for (const id of ['paired']) document.getElementById(id).hidden = true;
choices('profile-place', places, drawProfile);
const numeric = data.variables.filter(v => v.values.length > 2 && v.values.every(x => x !== '' && known(+x)));
if (numeric.length) choices('breakdown-variable', numeric, drawBreakdown, v => v.name);
else document.getElementById('breakdown-section').hidden = true;
choices('times-place', places, drawTimes);
choices('limits-place', places, drawLimits);
for (const id of ['legend-profile', 'legend-breakdown', 'legend-times']) legend(id, names);
window.addEventListener('beforeprint', () => document.querySelectorAll('details').forEach(d => { d.open = true; }));
