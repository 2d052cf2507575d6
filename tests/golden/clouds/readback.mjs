// readback.mjs LISTING FOLDER...: reads the clouds in the folders with laz-perf (LAS) and web-e57 (E57) and holds number, box and
// mean of their points against what our reader found, which LISTING has. Packages are those of the working folder.
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';

const require = createRequire(path.join(process.cwd(), 'package.json'));
const { createLazPerf } = require('laz-perf');
const { convertE57 } = await import(pathToFileURL(path.join(process.cwd(), 'node_modules/web-e57/e57.js')).href);
const lazPerf = await createLazPerf();

// laz-perf gives records as they are in the file; scale and offset are the header's.
function lasPoints(bytes) {
  const header = new DataView(bytes.buffer, bytes.byteOffset);
  const at = lazPerf._malloc(bytes.length);
  lazPerf.HEAPU8.set(bytes, at);
  const reader = new lazPerf.LASZip();
  reader.open(at, bytes.length);
  const record = lazPerf._malloc(reader.getPointLength());
  const points = [];
  for (let i = 0, count = reader.getCount(); i < count; ++i) {
    reader.getPoint(record);
    const view = new DataView(lazPerf.HEAPU8.buffer, record);
    points.push([0, 1, 2].map(a => view.getInt32(4 * a, true) * header.getFloat64(131 + 8 * a, true) + header.getFloat64(155 + 8 * a, true)));
  }
  reader.delete();
  return points;
}

const e57Points = bytes => convertE57(new Uint8Array(bytes), 'XYZ').trim().split('\n').filter(line => line)
  .map(line => line.trim().split(/[\s,;]+/).slice(0, 3).map(Number)).filter(point => point.every(Number.isFinite));

const [listing, ...folders] = process.argv.slice(2);
const ours = new Map(JSON.parse(fs.readFileSync(listing)).map(entry => [entry.file, entry]));
let failures = 0, compared = 0;
const fail = text => { console.log('FAILED ' + text); ++failures; };
for (const folder of folders)
  for (const name of fs.readdirSync(folder).filter(file => /\.(las|e57)$/.test(file)).sort()) {
    const found = ours.get(name);
    if (!found) { fail(`${name}: not in the listing`); continue; }
    let points = [], refused = '';
    try {
      const bytes = fs.readFileSync(path.join(folder, name));
      points = name.endsWith('.las') ? lasPoints(bytes) : e57Points(bytes);
    } catch (error) { refused = String(error); }
    if (points.length === 0) {  // nobody finds a point in it
      if (!found.refused) fail(`${name}: the other reader has no point (${refused}), ours ${found.points}`); else ++compared;
      continue;
    }
    if (found.refused) { fail(`${name}: the other reader has ${points.length} points, ours says ${found.refused}`); continue; }
    if (points.length !== found.points) fail(`${name}: ${points.length} points, ours ${found.points}`);
    const within = 1e-6;  // [m]
    for (let a = 0; a < 3; ++a) {
      const values = points.map(point => point[a]);
      for (const [what, value] of [['low', values.reduce((p, v) => Math.min(p, v))], ['high', values.reduce((p, v) => Math.max(p, v))],
        ['mean', values.reduce((sum, v) => sum + v, 0) / values.length]])
        if (!(Math.abs(value - found[what][a]) <= within)) fail(`${name}: ${what} of axis ${a} is ${value}, ours ${found[what][a]}`);
    }
    ++compared;
  }
console.log(`${compared} clouds compared, ${failures} failures`);
process.exit(failures || compared < 20 ? 1 : 0);
