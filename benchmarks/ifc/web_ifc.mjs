// web-ifc on the same files: opens each and writes it again with one property set on every of 300 elements.
// node web_ifc.mjs NODE_MODULES FILE...
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';

const [modules, ...files] = process.argv.slice(2);
const require = createRequire(path.join(path.resolve(modules), 'index.js'));
const W = require('web-ifc');
const api = new W.IfcAPI();
await api.Init();
api.SetLogLevel(W.LogLevel.LOG_LEVEL_OFF);
const cpu = () => { const c = process.cpuUsage(); return 1e-6 * (c.user + c.system); };
for (const file of files) {
  const bytes = readFileSync(file), before = process.memoryUsage().rss;
  let t = cpu();
  const model = api.OpenModel(new Uint8Array(bytes));
  const opened = cpu() - t;
  console.log(`| web-ifc: opened | ${api.GetAllLines(model).size()} | ${opened.toFixed(3)} s | ${(1e-6 * bytes.length / opened).toFixed(0)} MB/s | ` +
    `${((process.memoryUsage().rss - before) / bytes.length).toFixed(3)} | |`);
  t = cpu();
  const lines = api.GetAllLines(model), elements = [];
  for (let i = 0; i < lines.size() && elements.length < 300; ++i)
    if (api.IsIfcElement(api.GetLineType(model, lines.get(i)))) elements.push(lines.get(i));
  for (const id of elements) {
    const label = api.CreateIfcType(model, W.IFCLABEL, 'PASS');
    const name = api.CreateIfcType(model, W.IFCIDENTIFIER, 'Verdict');
    const property = api.CreateIfcEntity(model, W.IFCPROPERTYSINGLEVALUE, name, null, label, null);
    const guid = () => api.CreateIFCGloballyUniqueId(model);
    const set = api.CreateIfcEntity(model, W.IFCPROPERTYSET, guid(), null, api.CreateIfcType(model, W.IFCLABEL, 'ASB_Test'), null, [property]);
    api.WriteLine(model, api.CreateIfcEntity(model, W.IFCRELDEFINESBYPROPERTIES, guid(), null, null, null, [new W.Handle(id)], set));
  }
  const written = api.SaveModel(model), seconds = opened + cpu() - t;
  console.log(`| web-ifc: opened, ${elements.length} sets added, saved: bytes | ${written.length} | ${seconds.toFixed(3)} s | ` +
    `${(1e-6 * bytes.length / seconds).toFixed(0)} MB/s | ${((process.memoryUsage().rss - before) / bytes.length).toFixed(3)} | |`);
  api.CloseModel(model);
}
