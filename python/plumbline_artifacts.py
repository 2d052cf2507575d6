"""Plumbline's artifacts in Python: read in place as numpy views, written from plain dicts.

An artifact is a FlatBuffers table of a type from schemas/artifacts/*.fbs. No code is generated: the binary schema (flatc -b
--schema, or build/framework/include/plumbline_artifacts/artifacts/*.bfbs) tells what the bytes mean.

    schema = Schema(open("points.bfbs", "rb").read())
    points = schema.read(data)                      # points.points[0].id, points.points[0].position["x"]
    data = schema.write({"points": [{"id": "A1", "position": (1.0, 2.0, 3.0)}]})

Reading: numbers are numbers, strings are str ("" if absent), structs and lists of numbers or structs are numpy views on the bytes
(no copy), tables are Table, lists of tables are lists. Enum fields are the names of their values, in lists their numbers; Schema.enums
has both. Writing takes either.

A node that is an executable (a manifest NAME.node.yaml beside it) begins with `call = Call()`. Import this module first: from
then on no module is imported that others may write, and at the end the host is told of all that were imported, so that the node
runs again when one of them changes.
"""
import atexit
import importlib.machinery
import json
import os
import stat
import struct
import sys


def _distrust(path):
    """Why a module's file is not believed, or nothing. The host looks at more, when the node has ended."""
    if os.environ.get("PLUMBLINE_TRUST_OTHERS", "0") not in ("", "0"):
        return None
    folder = os.path.dirname(path)
    for place, sticky in ((path, 0), (folder, stat.S_ISVTX)):
        mode = os.stat(place).st_mode
        if mode & stat.S_IWOTH and not mode & sticky:
            return (f"{place} may be written by everybody on this machine; take the right away with: chmod o-w {place}, or believe "
                    "everybody with --trust-others (PLUMBLINE_TRUST_OTHERS=1)")
    return None


class _Watch:
    """Stands before all finders of modules and refuses what they find if others may write it."""

    @staticmethod
    def find_spec(name, path=None, target=None):
        for finder in sys.meta_path:
            spec = None if finder is _Watch or not hasattr(finder, "find_spec") else finder.find_spec(name, path, target)
            if spec is not None:
                problem = _distrust(spec.origin) if spec.origin and os.path.isfile(spec.origin) else None
                if problem:
                    raise ImportError(f"the module '{name}' is not imported: {problem}")
                return spec
        return None

    @staticmethod
    def invalidate_caches():
        pass


_folder_at_start = os.getcwd()


def _whole(path):
    """A path as it was named, links and all: what a link leads to may change."""
    return os.path.join(_folder_at_start, path)


def _module_files():
    """The files of all modules that were imported, as whole paths: as they were found, and where links lead."""
    found = set()
    for module in list(sys.modules.values()):
        path = getattr(module, "__file__", None)
        if not path:
            continue
        if path.endswith(tuple(importlib.machinery.BYTECODE_SUFFIXES)) and os.path.isfile(path[:-1]):
            path = path[:-1]
        while path and not os.path.exists(path):  # in an archive
            path = os.path.dirname(path)
        if path and os.path.isfile(path):
            found.update((_whole(path), os.path.realpath(path)))
    return sorted(found)


def _absent_files():
    """What is not there and would have been imported in place of a module that was: it stands before it on the path."""
    suffixes = importlib.machinery.EXTENSION_SUFFIXES + importlib.machinery.SOURCE_SUFFIXES
    entries = [_whole(entry) for entry in sys.path]
    absent = {entry for entry in entries if not os.path.exists(entry)}
    for name, module in list(sys.modules.items()):
        origin = getattr(getattr(module, "__spec__", None), "origin", None)
        if "." in name or not origin or not getattr(module.__spec__, "has_location", False):
            continue  # parts of a package come from its folder; what is built in nothing stands before
        origin = _whole(origin)
        candidates = [os.path.join(name, "__init__.py")] + [name + suffix for suffix in suffixes]
        for candidate in (os.path.join(entry, candidate) for entry in entries for candidate in candidates):
            if candidate == origin:
                break
            if not os.path.lexists(candidate):
                absent.add(candidate)
    return sorted(absent)


sys.meta_path.insert(0, _Watch)

import flatbuffers
import numpy as np

_SCALARS = {1: "u1", 2: "?", 3: "i1", 4: "u1", 5: "<i2", 6: "<u2", 7: "<i4", 8: "<u4", 9: "<i8", 10: "<u8", 11: "<f4", 12: "<f8"}
_STRING, _VECTOR, _OBJECT = 13, 14, 15


class _Raw:
    """A table by the numbers of its fields."""

    def __init__(self, data, at):
        self.data, self.at = data, at
        self.vtable = at - struct.unpack_from("<i", data, at)[0]
        self.size = struct.unpack_from("<H", data, self.vtable)[0]

    def place(self, number):
        slot = 4 + 2 * number
        offset = struct.unpack_from("<H", self.data, self.vtable + slot)[0] if slot < self.size else 0
        return self.at + offset if offset else None

    def number(self, number, form, default=0):
        at = self.place(number)
        return default if at is None else struct.unpack_from(form, self.data, at)[0]

    def follow(self, number):
        at = self.place(number)
        return None if at is None else at + struct.unpack_from("<I", self.data, at)[0]

    def text(self, number):
        at = self.follow(number)
        return "" if at is None else _text(self.data, at)

    def tables(self, number):
        at = self.follow(number)
        return [] if at is None else [_Raw(self.data, place) for place in _places(self.data, at)]


def _text(data, at):
    size = struct.unpack_from("<I", data, at)[0]
    return bytes(data[at + 4:at + 4 + size]).decode()


def _places(data, at):
    count = struct.unpack_from("<I", data, at)[0]
    return [at + 4 + 4 * i + struct.unpack_from("<I", data, at + 4 + 4 * i)[0] for i in range(count)]


class _Field:
    def __init__(self, raw):
        kind = _Raw(raw.data, raw.follow(1))
        self.name, self.number, self.offset = raw.text(0), raw.number(2, "<H"), raw.number(3, "<H")
        self.base, self.element, self.index = kind.number(0, "<b"), kind.number(1, "<b"), kind.number(2, "<i", -1)
        self.required = bool(raw.number(7, "<B"))
        real = self.base in (11, 12)
        self.default = raw.number(5, "<d", 0.0) if real else raw.number(4, "<q")


class _Object:
    def __init__(self, raw):
        self.name, self.is_struct = raw.text(0), bool(raw.number(2, "<B"))
        self.align, self.size = raw.number(3, "<i"), raw.number(4, "<i")
        self.fields = sorted((_Field(f) for f in raw.tables(1)), key=lambda field: field.number)
        self.by_name = {field.name: field for field in self.fields}


class Schema:
    """The meaning of the bytes of one type."""

    def __init__(self, bfbs):
        root = _Raw(bfbs, struct.unpack_from("<I", bfbs, 0)[0])
        self._objects = [_Object(o) for o in root.tables(0)]
        self.enums = {e.text(0): {v.text(0): v.number(1, "<q") for v in e.tables(1)} for e in root.tables(1)}
        self._values = list(self.enums.values())  # by the index that fields have
        self._names = [{number: name for name, number in values.items()} for values in self._values]
        self.name = _Raw(bfbs, root.follow(4)).text(0)
        self._root = next(o for o in self._objects if o.name == self.name)

    def read(self, data):
        """The root table. The host has verified the bytes; of others they must be verified first."""
        return Table(self, self._root, _Raw(data, struct.unpack_from("<I", data, 0)[0]))

    def write(self, values):
        """The bytes of an artifact. `values`: a dict by field names; what is left out takes its default."""
        builder = flatbuffers.Builder(1024)
        builder.Finish(self._write_table(builder, self._root, values))
        return bytes(builder.Output())

    def dtype(self, thing):
        """The numpy type of a struct of the schema, by name or as an object of it."""
        if isinstance(thing, str):
            thing = next(o for o in self._objects if o.name == thing)
        forms = [_SCALARS.get(f.base) or self.dtype(self._objects[f.index]) for f in thing.fields]
        return np.dtype({"names": [f.name for f in thing.fields], "formats": forms,
                         "offsets": [f.offset for f in thing.fields], "itemsize": thing.size})

    def _element(self, field):
        return _SCALARS.get(field.element) or self.dtype(self._objects[field.index])

    def _write_table(self, builder, thing, values):
        unknown = set(values) - set(thing.by_name)
        if unknown:
            raise KeyError(f"{thing.name} has no {', '.join(sorted(unknown))}; it has {', '.join(thing.by_name)}")
        missing = [f.name for f in thing.fields if f.required and values.get(f.name) is None]
        if missing:
            raise KeyError(f"{thing.name} needs {', '.join(missing)}")
        given = [(f, values[f.name]) for f in thing.fields if values.get(f.name) is not None]
        ends = {f.number: self._write_apart(builder, f, v) for f, v in given
                if f.base in (_STRING, _VECTOR) or f.base == _OBJECT and not self._objects[f.index].is_struct}
        builder.StartObject(len(thing.fields))
        for field, value in given:
            if field.number in ends:
                builder.PrependUOffsetTRelativeSlot(field.number, ends[field.number], 0)
            elif field.base == _OBJECT:
                held = self._objects[field.index]
                builder.PrependStructSlot(field.number, self._put(builder, held.align, _struct(self.dtype(held), value)), 0)
            else:
                raw = _kept(self._number_of(thing, field, value), np.dtype(_SCALARS[field.base]), field.name).tobytes()
                self._put(builder, len(raw), raw)
                builder.Slot(field.number)
        return builder.EndObject()

    def _number_of(self, thing, field, value):
        """Of an enum's value by name."""
        if not isinstance(value, str) or field.index < 0:
            return value
        values = self._values[field.index]
        if value not in values:
            raise KeyError(f"{thing.name}.{field.name} is one of {', '.join(values)}; found '{value}'")
        return values[value]

    def _write_apart(self, builder, field, value):
        if field.base == _STRING:
            return builder.CreateString(value)
        if field.base == _OBJECT:
            return self._write_table(builder, self._objects[field.index], value)
        if field.element == _STRING or field.element == _OBJECT and not self._objects[field.index].is_struct:
            write = builder.CreateString if field.element == _STRING else (
                lambda item: self._write_table(builder, self._objects[field.index], item))
            ends = [write(item) for item in value]
            builder.StartVector(4, len(ends), 4)
            for end in reversed(ends):
                builder.PrependUOffsetTRelative(end)
            return builder.EndVector()
        form = np.dtype(self._element(field))
        if isinstance(value, (bytes, bytearray)) and form.itemsize == 1:  # the content of a File
            value = np.frombuffer(value, form)
        if field.element == _OBJECT and not (isinstance(value, np.ndarray) and value.dtype == form):
            items = b"".join(_struct(form, item) for item in value)
        else:
            items = np.ascontiguousarray(_kept(value, form, field.name)).tobytes()
        align = self._objects[field.index].align if field.element == _OBJECT else form.itemsize
        builder.StartVector(form.itemsize, len(items) // form.itemsize, align)
        builder.head = builder.Head() - len(items)
        builder.Bytes[builder.Head():builder.Head() + len(items)] = items
        return builder.EndVector()

    @staticmethod
    def _put(builder, align, raw):
        builder.Prep(max(align, 1), len(raw) - align if len(raw) > align else 0)
        builder.head = builder.Head() - len(raw)
        builder.Bytes[builder.Head():builder.Head() + len(raw)] = raw
        return builder.Offset()


def _numbers(value):
    for item in value.item() if isinstance(value, np.void) else value:
        if isinstance(item, (tuple, list, np.ndarray, np.void)):
            yield from _numbers(item)
        else:
            yield item


def _kept(value, form, name):
    """The numbers in the form of their field. What numpy would wrap, cut or take for true is refused: 300 or 65.9 in a byte, "False"."""
    given = np.asarray(value)
    if given.dtype.kind not in "biuf":
        raise ValueError(f"'{name}' takes numbers of the form {form.name}; found {value!r:.60}")
    with np.errstate(all="ignore"):
        kept = given.astype(form)
    good = np.isfinite(kept) | ~np.isfinite(given) if form.kind == "f" else kept == given
    if not good.all():
        raise ValueError(f"'{name}' takes numbers of the form {form.name}, which cannot hold {given[~good].flat[0]!r}; "
                         "round it, or clip it, before it is written")
    return kept


def _struct(form, value):
    """One struct as bytes, from numbers in the order of its fields, nested or flat."""
    numbers = list(_numbers(value))
    left = iter(numbers)

    def fill(kind):
        return tuple(fill(kind[name]) if kind[name].names else leaf(kind[name], name) for name in kind.names)

    def leaf(kind, name):
        number = next(left)
        return number if kind == np.float64 else _kept(number, kind, name).item()

    try:
        filled = fill(form)
        extra = len(list(left))
    except (StopIteration, RuntimeError):
        extra = -1
    if extra:
        raise ValueError(f"a struct of the fields {', '.join(form.names)} was given {len(numbers)} numbers")
    return np.array([filled], form).tobytes()


class Table:
    """One table: its fields are attributes."""

    def __init__(self, schema, thing, raw):
        self._schema, self._thing, self._raw = schema, thing, raw

    def __dir__(self):
        return list(self._thing.by_name)

    def __getattr__(self, name):
        field = self._thing.by_name.get(name)
        if field is None:
            raise AttributeError(f"{self._thing.name} has no '{name}'; it has {', '.join(self._thing.by_name)}")
        raw, schema = self._raw, self._schema
        if field.base in _SCALARS:
            number = raw.number(field.number, _struct_form(field.base), field.default)
            return schema._names[field.index].get(number, number) if field.index >= 0 else number
        if field.base == _STRING:
            return raw.text(field.number)
        if field.base == _OBJECT:
            held = schema._objects[field.index]
            if held.is_struct:
                at = raw.place(field.number)
                return None if at is None else np.frombuffer(raw.data, schema.dtype(held), 1, at)[0]
            at = raw.follow(field.number)
            return None if at is None else Table(schema, held, _Raw(raw.data, at))
        at = raw.follow(field.number)
        if field.element == _STRING:
            return [] if at is None else [_text(raw.data, place) for place in _places(raw.data, at)]
        if field.element == _OBJECT and not schema._objects[field.index].is_struct:
            return [Table(schema, schema._objects[field.index], item) for item in raw.tables(field.number)]
        form = np.dtype(schema._element(field))
        count = 0 if at is None else struct.unpack_from("<I", raw.data, at)[0]
        return np.frombuffer(raw.data, form, count, at + 4) if count else np.empty(0, form)


def _struct_form(base):
    return {1: "<B", 2: "<?", 3: "<b", 4: "<B", 5: "<h", 6: "<H", 7: "<i", 8: "<I", 9: "<q", 10: "<Q", 11: "<f", 12: "<d"}[base]


class Call:
    """One run of a node that is an executable: what the host put into the folder named by the last argument."""

    def __init__(self, folder=None):
        self.folder = folder or sys.argv[-1]
        with open(os.path.join(self.folder, "call.json"), encoding="utf-8") as stream:
            call = json.load(stream)
        self.kind, self.parameters, self.seed = call["kind"], call["parameters"], call.get("seed")
        self._references = call["references"]
        self._committed, self._metrics = {}, {}
        for path in _module_files():
            if _distrust(path):
                sys.exit(f"a module was imported that is not believed: {_distrust(path)}")
        atexit.register(self._tell_used)

    def _tell_used(self):
        with open(os.path.join(self.folder, "used"), "wb") as stream:
            stream.write(b"".join(os.fsencode(path) + b"\n" for path in _module_files()))
            stream.write(b"".join(b"absent:" + os.fsencode(path) + b"\n" for path in _absent_files()))

    def schema(self, type_name):
        """Of a type such as "plumbline.Points/1"."""
        with open(os.path.join(self.folder, "schemas", type_name.replace("/", "-") + ".bfbs"), "rb") as stream:
            return Schema(stream.read())

    def inputs(self, port, type_name):
        """The artifacts of an input, in order; none if it is not connected."""
        folder, schema = os.path.join(self.folder, "inputs", port), self.schema(type_name)
        names = sorted(os.listdir(folder)) if os.path.isdir(folder) else []
        return [schema.read(open(os.path.join(folder, name), "rb").read()) for name in names]

    def path(self, uri):
        """Where the file lies that an artifact names."""
        if uri not in self._references:
            raise FileNotFoundError(f"no input names '{uri}'")
        return self._references[uri]

    def commit(self, port, type_name, values):
        """Writes an artifact to an output."""
        number = self._committed.get(port, 0)
        self._committed[port] = number + 1
        with open(os.path.join(self.folder, "outputs", port, f"{number:06d}"), "wb") as stream:
            stream.write(self.schema(type_name).write(values))

    def metric(self, name, value, unit="1"):
        """A number of the run record, which `plumbline bench` can measure as NODE.name. SI units; nan is "not known"."""
        value = float(value)
        self._metrics[name] = [value if np.isfinite(value) else None, unit]
        with open(os.path.join(self.folder, "metrics.json"), "w", encoding="utf-8") as stream:
            json.dump(self._metrics, stream)
