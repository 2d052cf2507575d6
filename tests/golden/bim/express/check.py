"""check.py EXPRESS_FOLDER FILE...            errors of each file
check.py EXPRESS_FOLDER --added DESIGN COPY ...   errors of each COPY that its DESIGN does not have

Holds exchange files against the official EXPRESS text of their schema: every attribute (number, type, bounds,
uniqueness), INVERSE cardinalities, UNIQUE clauses, all WHERE rules of entities and types, all global RULEs.
Exit code 1 if there are errors."""
import os
import sys

import evaluate as ev
import part21
import schema as express
from part21 import DERIVED, Binary, Enumeration, Reference, Typed


class Schema:
    """A parsed schema with what is asked of it often, along the lines of supertypes."""

    def __init__(self, text):
        parsed = express.Parser(text)
        self.name, self.types, self.entities = parsed.name, parsed.types, parsed.entities
        self.functions, self.rules = parsed.functions, parsed.rules
        self.items = {item for type in self.types.values() if type.kind == "enumeration" for item in type.members}
        self.parents_of_selects = {}
        for word, type in self.types.items():
            for member in type.members if type.kind == "select" else ():
                self.parents_of_selects.setdefault(member, set()).add(word)
        self.ancestors, self.attributes, self.positions, self.derived, self.redefined = {}, {}, {}, {}, {}
        self.inverse, self.names = {}, {}
        for entity in self.entities.values():
            line = [entity]
            while line[-1].parent:
                line.append(self.entities[line[-1].parent])
            word = entity.name
            self.ancestors[word] = [e.name for e in line]
            self.attributes[word] = [a for e in reversed(line) for a in e.attributes]
            self.positions[word] = {a.name.lower(): i for i, a in enumerate(self.attributes[word])}
            self.derived[word], self.inverse[word], redeclared, self.redefined[word] = {}, {}, {}, set()
            for e in reversed(line):
                self.derived[word].update({k: v[0] for k, v in e.derived.items()})
                self.redefined[word].update(k for k, v in e.derived.items() if k in self.positions[word])
                self.inverse[word].update(e.inverse)
                redeclared.update(e.redeclared)
            self.attributes[word] = [redeclared.get(a.name.lower(), a) for a in self.attributes[word]]
            self.names[word] = {*self.positions[word], *self.derived[word], *self.inverse[word]}

    def chain(self, word):
        """A defined type and what it is made of: names, the simple type last."""
        words = []
        while word in self.types:
            words.append(word)
            word = self.types[word].name if self.types[word].kind in ("named", "simple") else ""
        return words + ([word] if word else [])

    def selects_of(self, word):
        found, todo = set(), [word]
        while todo:
            for select in self.parents_of_selects.get(todo.pop(), ()):
                if select not in found:
                    found.add(select)
                    todo.append(select)
        return found


class Model:
    def __init__(self, schema, data):
        self.schema, self.unknown, self.dangling = schema, [], set()
        self.instances = {}
        for id, (keyword, values) in data.items():
            if keyword in schema.entities:
                self.instances[id] = ev.Instance(id, schema.entities[keyword], values, self)
            else:
                self.unknown.append((id, keyword))
        self.references, self.by_entity = {}, {}
        for instance in self.instances.values():
            instance.values = [self.resolved(value, instance, i) for i, value in enumerate(instance.values)]
            for word in schema.ancestors[instance.entity.name]:
                self.by_entity.setdefault(word, []).append(instance)

    def resolved(self, value, user, position):
        if isinstance(value, Reference):
            target = self.instances.get(int(value))
            if target is None:
                self.dangling.add((user.id, int(value)))
                return None
            self.references.setdefault(target.id, []).append((user, position))
            return target
        if isinstance(value, list):
            return [self.resolved(item, user, position) for item in value]
        return Typed(value.name, self.resolved(value.value, user, position)) if isinstance(value, Typed) else value

    def users(self, target, entity, attribute):
        """Instances of `entity` whose `attribute` refers to `target`, once for each reference."""
        found = []
        for user, position in self.references.get(target.id, ()):
            word = user.entity.name
            if entity in self.schema.ancestors[word] and self.schema.positions[word].get(attribute) == position:
                found.append(user)
        return found


class Checker:
    def __init__(self, schema, data):
        self.schema, self.model, self.errors = schema, Model(schema, data), []

    def say(self, id, what):
        self.errors.append((id, what))

    def run(self, only=None):
        """All errors, or those of the instances whose numbers are in `only`."""
        for id, keyword in self.model.unknown:
            self.say(id, f"{keyword}: no entity of {self.schema.name}")
        for user, target in self.model.dangling:
            self.say(user, f"refers to #{target}, which is not there")
        for instance in self.model.instances.values():
            if only is None or instance.id in only:
                self.instance(instance)
        self.unique()
        self.global_rules()
        return self.errors

    def instance(self, instance):
        entity, word = instance.entity, instance.entity.name
        attributes = self.schema.attributes[word]
        if entity.abstract:
            self.say(instance.id, f"{entity.label} is abstract")
        if len(instance.values) != len(attributes):
            self.say(instance.id, f"{entity.label}: {len(instance.values)} arguments for {len(attributes)} attributes")
            return
        for attribute, value in zip(attributes, instance.values):
            label = f"{entity.label}.{attribute.name}"
            if attribute.name.lower() in self.schema.redefined[word]:
                if value is not DERIVED:
                    self.say(instance.id, f"{label}: a derived attribute is given")
            elif value is DERIVED:
                self.say(instance.id, f"{label}: * for an attribute that is not derived")
            elif value is None:
                if not attribute.optional and (instance.id not in {user for user, _ in self.model.dangling}):
                    self.say(instance.id, f"{label}: $ for a required attribute")
            elif wrong := self.value(value, attribute.type, instance, label):
                self.say(instance.id, f"{label}: {wrong}")
        for inverse in self.schema.inverse[word].values():
            self.cardinality(instance, *inverse)
        for ancestor in self.schema.ancestors[word]:
            for label, rule in self.schema.entities[ancestor].where:
                self.rule(instance.id, f"{self.schema.entities[ancestor].label}.{label}", rule, instance)

    def rule(self, id, label, rule, subject, variables=None):
        try:
            if ev.bare(rule(ev.Scope(self.model, subject, variables))) is False:
                self.say(id, f"{label} does not hold")
        except (TypeError, AttributeError, ValueError, IndexError, RecursionError) as error:
            self.say(id, f"{label} cannot be evaluated: {error}")

    def cardinality(self, instance, source, attribute, low, high, many, label):
        users = len({user.id for user in self.model.users(instance, source, attribute)})
        scope = ev.Scope(self.model, instance)
        least, most = low(scope), high(scope)
        if users < least or (most is not None and users > most):
            self.say(instance.id, f"{instance.entity.label}.{label}: {users} {source} refer to it")

    def value(self, value, type, instance, label):
        """What is wrong with the value of an attribute, or an empty text. WHERE rules of types are told at once."""
        if type.kind == "aggregate":
            return self.aggregate(value, type, instance, label)
        if type.kind == "simple":
            return self.simple(value, type)
        if type.kind == "enumeration":
            right = isinstance(value, Enumeration) and value.lower() in type.members
            return "" if right else f"{value!r} is no value of the enumeration"
        if type.kind == "select":
            return self.select(value, type)
        if type.name in self.schema.entities:
            right = isinstance(value, ev.Instance) and type.name in self.schema.ancestors[value.entity.name]
            return "" if right else f"no {self.schema.entities[type.name].label}"
        named = self.schema.types[type.name]
        if isinstance(value, Typed) and named.kind != "select":
            return f"{value.name.upper()}(…) where the value alone belongs"
        wrong = self.value(value, named, instance, label)
        for rule_label, rule in named.where if not wrong else ():
            self.rule(instance.id, f"{label}: {named.label}.{rule_label}", rule, ev.plain(value), None)
        if not wrong and isinstance(value, Typed):
            return self.value(value.value, express.Type("named", value.name), instance, label)
        return wrong

    def aggregate(self, value, type, instance, label):
        if not isinstance(value, list):
            return "no list"
        scope = ev.Scope(self.model, instance)
        low, high = (ev.bare(bound(scope)) if bound else None for bound in (type.low, type.high))
        if type.name == "array":
            low, high = (None, None) if low is None or high is None else (high - low + 1, high - low + 1)
        if (low is not None and len(value) < low) or (high is not None and len(value) > high):
            return f"{len(value)} items, {low} to {'any' if high is None else high} belong there"
        if type.unique and not (len({(id(v) if isinstance(v, ev.Instance) else repr(ev.bare(v))) for v in value}) == len(value)):
            return "an item stands twice in it"
        return next((wrong for item in value if (wrong := self.value(item, type.of, instance, label))), "")

    def simple(self, value, type):
        kinds = {"real": float, "integer": int, "number": (int, float), "string": str, "binary": Binary}
        if type.name in ("boolean", "logical"):
            allowed = ("T", "F") if type.name == "boolean" else ("T", "F", "U")
            return "" if isinstance(value, Enumeration) and value in allowed else f"no {type.name}"
        wrong_text = type.name == "string" and isinstance(value, (Enumeration, Binary))
        if not isinstance(value, kinds[type.name]) or wrong_text or isinstance(value, Reference):
            return f"no {type.name}"
        high = type.high(None) if type.high else None
        if type.low and len(value) != high:
            return f"not of {high} characters"
        return f"longer than {high} characters" if high and type.name == "string" and len(value) > high else ""

    def select(self, value, type):
        if isinstance(value, ev.Instance):
            words = self.schema.ancestors[value.entity.name]
        elif isinstance(value, Typed) and value.name in self.schema.types:
            words = [value.name]
        else:
            return "neither an entity nor a typed value, as a select needs"
        reach = {select for word in words for select in self.schema.selects_of(word)}
        name = next((word for word, t in self.schema.types.items() if t is type), "")
        return "" if name in reach else f"{words[0]} is none of what {type.label} selects"

    def unique(self):
        for word, entity in self.schema.entities.items():
            for label, names in entity.unique:
                seen = {}
                for instance in self.model.by_entity.get(word, ()):
                    values = [instance.get(name) for name in names]
                    if None in values:
                        continue
                    key = tuple(id(v) if isinstance(v, ev.Instance) else repr(ev.bare(v)) for v in values)
                    if key in seen:
                        self.say(instance.id, f"{entity.label}.{label}: the same as #{seen[key]}")
                    seen.setdefault(key, instance.id)

    def global_rules(self):
        for label, words, variables, body, where in self.schema.rules:
            scope = ev.Scope(self.model, None, {word: list(self.model.by_entity.get(word, ())) for word in words})
            ev.declare(scope, variables)
            body(scope)
            for rule_label, rule in where:
                self.rule(0, f"{label}.{rule_label}", rule, None, scope.variables)


def header_errors(header):
    wanted = {"file_description": (list, str), "file_name": (str, str, list, list, str, str, str), "file_schema": (list,)}
    errors = []
    if [name for name, _ in header[:3]] != list(wanted):
        errors.append((0, "the header is not FILE_DESCRIPTION, FILE_NAME, FILE_SCHEMA"))
    for name, values in header:
        kinds = wanted.get(name, ())
        right = len(values) == len(kinds) and all(
            type(v) is k and (k is str or (v and all(type(item) is str for item in v))) for v, k in zip(values, kinds))
        if name in wanted and not right:
            errors.append((0, f"{name.upper()}: arguments are not those of ISO 10303-21"))
    return errors


schemas = {}


def schema_for(folder, header):
    name = next(values[0][0] for word, values in header if word == "file_schema").upper()
    key = next((key for key in ("IFC4X3", "IFC2X3") if name.startswith(key)), name)  # IFC4X3_ADD2, IFC2X3_FINAL
    if key not in schemas:
        with open(os.path.join(folder, key + ".exp"), encoding="latin-1") as file:
            schemas[key] = Schema(file.read())
    return schemas[key]


def check(folder, path, only=None):
    with open(path, encoding="latin-1") as file:
        header, data = part21.read(file.read())
    return header_errors(header) + Checker(schema_for(folder, header), data).run(only)


def added(folder, design, copy):
    """Errors of the copy that the design does not have."""
    errors = check(folder, copy)
    before = set(check(folder, design, {id for id, _ in errors})) if errors else ()
    return [error for error in errors if error not in before], len(errors)


def main(folder, *paths):
    sys.setrecursionlimit(3000)
    found = 0
    pairs = paths[:1] == ("--added",)
    for design, path in zip(paths[1::2], paths[2::2]) if pairs else ((None, path) for path in paths):
        if pairs:
            errors, all_of_copy = added(folder, design, path)
            print(f"{path}: {len(errors)} errors added to {all_of_copy - len(errors)} of the design")
        else:
            errors = check(folder, path)
            print(f"{path}: {len(errors)} errors")
        for id, what in errors[:20]:
            print(f"  #{id} {what}")
        found += len(errors)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
