// readback.mjs FOLDER : holds what make_as_built wrote against what web-ifc and ifc-lite, readers that are not ours, find in it.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';
const require = createRequire(path.join(process.cwd(), 'package.json'));
const WebIFC = require('web-ifc');

// A module that only `import` can load, from the folder of the test.
const ifcLite = await import(pathToFileURL(path.join(process.cwd(), 'node_modules/@ifc-lite/parser/dist/index.js')).href);
console.log = console.debug = console.info = () => {};  // it tells of every phase

const api = new WebIFC.IfcAPI();
await api.Init();
api.SetLogLevel?.(WebIFC.LogLevel?.LOG_LEVEL_OFF ?? 6);

function open(file) {
  return api.OpenModel(fs.readFileSync(file), { COORDINATE_TO_ORIGIN: false });
}

function lines(model, type, inherited = false) {
  const ids = api.GetLineIDsWithType(model, type, inherited);
  return Array.from({ length: ids.size() }, (_, i) => api.GetLine(model, ids.get(i)));
}

/// Boxes of the meshes in the project's axes [m] and their numbers of triangles, by express id.
function geometry(model) {
  const boxes = new Map(), triangles = new Map();
  api.StreamAllMeshes(model, (mesh) => {
    let count = 0;
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let k = 0; k < mesh.geometries.size(); ++k) {
      const placed = mesh.geometries.get(k), t = placed.flatTransformation;
      const shape = api.GetGeometry(model, placed.geometryExpressID);
      const v = api.GetVertexArray(shape.GetVertexData(), shape.GetVertexDataSize());
      count += shape.GetIndexDataSize() / 3;
      for (let i = 0; i < v.length; i += 6) {
        const p = [0, 1, 2].map((r) => t[r] * v[i] + t[4 + r] * v[i + 1] + t[8 + r] * v[i + 2] + t[12 + r]);
        const q = [p[0], -p[2], p[1]];  // web-ifc turns y up
        for (let r = 0; r < 3; ++r) low[r] = Math.min(low[r], q[r]), high[r] = Math.max(high[r], q[r]);
      }
    }
    boxes.set(mesh.expressID, [...low, ...high]);
    triangles.set(mesh.expressID, count);
  });
  return { boxes, triangles };
}

function guids(model) {
  return new Map(lines(model, WebIFC.IFCROOT, true).map((line) => [line.expressID, line.GlobalId.value]));
}

/// "guid of object/set/property" → property line.
function properties(model) {
  const found = new Map();
  for (const relation of lines(model, WebIFC.IFCRELDEFINESBYPROPERTIES)) {
    const set = api.GetLine(model, relation.RelatingPropertyDefinition.value);
    if (!set.HasProperties || !set.Name.value.startsWith('ASB_')) continue;
    for (const object of relation.RelatedObjects) {
      const guid = api.GetLine(model, object.value).GlobalId.value;
      for (const handle of set.HasProperties) {
        const property = api.GetLine(model, handle.value);
        found.set(`${guid}/${set.Name.value}/${property.Name.value}`, property);
      }
    }
  }
  return found;
}

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => a.map((v) => v / Math.hypot(...a));

/// Origin [file's unit] and axes x, y, z of an object placement, up its chain, after the definitions of IfcLocalPlacement
/// and IfcAxis2Placement3D; null for placements of another kind.
function placementOf(model, handle) {
  if (!handle) return { origin: [0, 0, 0], axes: [[1, 0, 0], [0, 1, 0], [0, 0, 1]] };
  const placement = api.GetLine(model, handle.value);
  if (placement.type !== WebIFC.IFCLOCALPLACEMENT) return null;
  const parent = placementOf(model, placement.PlacementRelTo);
  const own = api.GetLine(model, placement.RelativePlacement.value);
  if (!parent || own.type !== WebIFC.IFCAXIS2PLACEMENT3D) return null;
  const numbers = (ref, attribute, fallback) =>
    ref ? api.GetLine(model, ref.value)[attribute].map((v) => v.value ?? v) : fallback;
  const at = numbers(own.Location, 'Coordinates');
  const z = unit(numbers(own.Axis, 'DirectionRatios', [0, 0, 1]));
  const towards = numbers(own.RefDirection, 'DirectionRatios', Math.abs(z[0]) > 1 - 1e-9 ? [0, 1, 0] : [1, 0, 0]);
  const x = unit(towards.map((v, i) => v - dot(towards, z) * z[i]));
  const turned = (v) => [0, 1, 2].map((i) => parent.axes[0][i] * v[0] + parent.axes[1][i] * v[1] + parent.axes[2][i] * v[2]);
  return { origin: turned(at).map((v, i) => v + parent.origin[i]), axes: [turned(x), turned(cross(z, x)), turned(z)] };
}

function near(actual, expected, tolerance, what) {
  assert.ok(Math.abs(actual - expected) <= tolerance, `${what}: web-ifc has ${actual}, expected ${expected}`);
}

function check(folder, name) {
  const expected = JSON.parse(fs.readFileSync(path.join(folder, name + '.json')));
  const before = open(path.join(folder, name + '.design.ifc')), after = open(path.join(folder, name + '.as_built.ifc'));

  // The design is what it was: the same objects, the same shapes.
  const guidsBefore = guids(before), guidsAfter = guids(after);
  for (const [id, guid] of guidsBefore) assert.equal(guidsAfter.get(id), guid, `${name}: GlobalId of #${id}`);
  assert.equal(new Set(guidsAfter.values()).size - new Set(guidsBefore.values()).size, guidsAfter.size - guidsBefore.size, `${name}: new GlobalIds are unique`);
  const shapesBefore = geometry(before), shapesAfter = geometry(after);
  for (const [id, count] of shapesBefore.triangles)
    assert.equal(shapesAfter.triangles.get(id), count, `${name}: triangles of #${id}`);
  // What is new to see are the solids of the as-built anchors, elements of their own.
  for (const id of shapesAfter.boxes.keys())
    if (!shapesBefore.boxes.has(id))
      assert.equal(api.GetNameFromTypeCode(api.GetLine(after, id).type), 'IfcBuildingElementProxy', `${name}: #${id}`);

  // Our reader found the same storeys, at the same heights.
  const metres = expected.length_unit;
  const storeys = new Map(lines(before, WebIFC.IFCBUILDINGSTOREY).map((line) => [line.GlobalId.value, line]));
  assert.equal(storeys.size, expected.storeys.length, `${name}: number of storeys`);
  for (const storey of expected.storeys) {
    const line = storeys.get(storey.guid);
    assert.equal(line?.Name?.value ?? '', storey.name, `${name}: name of storey ${storey.guid}`);
    near(placementOf(before, line.ObjectPlacement).origin[2] * metres, storey.height, 1e-5, `${name}: height of storey ${storey.guid}`);
  }

  // And the same elements, in the same classes and placements, where web-ifc's triangles are.
  let placements = 0;
  const elements = lines(before, WebIFC.IFCELEMENT, true);
  assert.equal(elements.length, expected.elements.length, `${name}: number of elements`);
  const byGuid = new Map(elements.map((line) => [line.GlobalId.value, line]));
  for (const element of expected.elements) {
    const line = byGuid.get(element.guid);
    assert.ok(line, `${name}: web-ifc has no element ${element.guid}`);
    assert.equal(api.GetNameFromTypeCode(line.type), element.class, `${name}: class of ${element.guid}`);
    const placed = placementOf(before, line.ObjectPlacement);
    if (placed) {
      ++placements;
      for (let i = 0; i < 3; ++i) {
        near(placed.origin[i] * metres, element.placement[i], 1e-5, `${name}: placement of ${element.guid}`);
        near(placed.axes[0][i], element.axes[0][i], 1e-9, `${name}: x axis of ${element.guid}`);
        near(placed.axes[2][i], element.axes[1][i], 1e-9, `${name}: z axis of ${element.guid}`);
      }
    }
    const box = shapesBefore.boxes.get(line.expressID);
    if (!box || !element.box) continue;
    for (let i = 0; i < 6; ++i) {
      const sign = i < 3 ? 1 : -1;  // where axes are turned, our box encloses
      if (element.parallel) near(element.box[i], box[i], 1e-3, `${name}: box of ${element.guid}`);
      else assert.ok(sign * (element.box[i] - box[i]) <= 1e-3, `${name}: box of ${element.guid} does not enclose its mesh`);
    }
  }

  assert.ok(placements > 0.9 * expected.elements.length, `${name}: ${placements} placements compared`);

  // The values arrive, in the unit of the project.
  const found = properties(after);
  for (const anchor of expected.anchors) {
    const get = (set, property) => {
      const line = found.get(`${anchor.guid}/${set}/${property}`);
      assert.ok(line, `${name}: ${anchor.guid} lacks ${set}.${property}`);
      return line;
    };
    ['X', 'Y', 'Z'].forEach((axis, i) =>
      near(get('ASB_AnchorDeviation', 'Deviation' + axis).NominalValue.value * metres, anchor.deviation[i], 2e-9, `${name}: Deviation${axis}`));
    near(get('ASB_ModelVsSurvey', 'DeltaZ').NominalValue.value * metres, anchor.delta_z, 2e-9, `${name}: DeltaZ`);
    near(get('ASB_Uncertainty', 'StdZ').NominalValue.value * metres, 1e-4, 2e-9, `${name}: StdZ`);
    assert.equal(get('ASB_AnchorDeviation', 'Verdict').EnumerationValues[0].value, anchor.verdict);
    assert.equal(get('ASB_Provenance', 'Method').NominalValue.value, 'test');
    const storey = expected.elements.find((element) => element.guid === anchor.guid).storey;
    near(found.get(`${storey}/ASB_FloorStatistics/Drift`).NominalValue.value * metres, 0.00005 * anchor.floor, 2e-9, `${name}: Drift`);
  }
  assert.equal(lines(after, WebIFC.IFCANNOTATION).length - lines(before, WebIFC.IFCANNOTATION).length, expected.anchors.length, `${name}: survey points`);
  assert.ok(expected.anchors.length > 0, `${name}: no anchors`);
  api.CloseModel(before);
  api.CloseModel(after);
}

/// The same file through ifc-lite: every instance, every GlobalId, the sets of the anchors, their storeys.
async function checkIfcLite(folder, name) {
  const expected = JSON.parse(fs.readFileSync(path.join(folder, name + '.json')));
  const parse = async (file) => {
    const bytes = fs.readFileSync(path.join(folder, file));
    return new ifcLite.IfcParser().parseColumnar(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  };
  const before = await parse(name + '.design.ifc'), after = await parse(name + '.as_built.ifc');
  assert.equal(after.schemaVersion, before.schemaVersion, `${name}: schema in ifc-lite`);
  near(after.lengthUnitScale, expected.length_unit, 1e-12, `${name}: unit of length in ifc-lite`);
  assert.equal(after.entityCount, expected.instances, `${name}: instances in ifc-lite`);
  for (const element of expected.elements)
    assert.equal(after.entities.getExpressIdByGlobalId(element.guid), before.entities.getExpressIdByGlobalId(element.guid), `${name}: ${element.guid} in ifc-lite`);
  for (const anchor of expected.anchors) {
    const id = after.entities.getExpressIdByGlobalId(anchor.guid);
    const sets = new Map(ifcLite.extractPropertiesOnDemand(after, id).map((set) => [set.name, set]));
    const value = (set, property) => sets.get(set)?.properties.find((p) => p.name === property)?.value;
    ['X', 'Y', 'Z'].forEach((axis, i) =>
      near(value('ASB_AnchorDeviation', 'Deviation' + axis) * expected.length_unit, anchor.deviation[i], 2e-9, `${name}: Deviation${axis} in ifc-lite`));
    assert.equal(value('ASB_AnchorDeviation', 'Verdict'), anchor.verdict, `${name}: verdict in ifc-lite`);
    near(value('ASB_ModelVsSurvey', 'DeltaZ') * expected.length_unit, anchor.delta_z, 2e-9, `${name}: DeltaZ in ifc-lite`);
    assert.equal(value('ASB_Provenance', 'Method'), 'test', `${name}: provenance in ifc-lite`);
  }
}

const folder = process.argv[2];
const names = fs.readdirSync(folder).filter((file) => file.endsWith('.json')).map((file) => file.slice(0, -5)).sort();
assert.ok(names.length >= 3, 'nothing to read back');
let failed = 0;
for (const name of names) {
  try {
    check(folder, name);
    await checkIfcLite(folder, name);
  } catch (error) {
    console.error(error.message);
    failed = 1;
  }
}
process.exit(failed);
