"""check_ids.py EXPRESS_FOLDER SPECIFICATION.ids MODEL.ifc ...    pairs; what a model does not fulfil, exit code 1 if anything
check_ids.py EXPRESS_FOLDER --cases FOLDER                      buildingSMART's own cases (pass-*, fail-*): which agree

A checker of Information Delivery Specifications (IDS 1.0) that shares no code with what writes them: facets entity (name),
attribute and property, names and values as they stand or as enumerations, types of properties, all cardinalities. What it does
not know (patterns, bounds, predefined types, numbers with units, quantities, other facets) it refuses, and never passes over."""
import os
import sys
import xml.etree.ElementTree as xml

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "express"))
import check as express  # noqa: E402
import part21  # noqa: E402
from part21 import DERIVED, Enumeration, Reference, Typed  # noqa: E402

IDS = "{http://standards.buildingsmart.org/IDS}"
XS = "{http://www.w3.org/2001/XMLSchema}"
SCHEMAS = {"IFC2X3": "IFC2X3", "IFC4": "IFC4", "IFC4X3": "IFC4X3_ADD2"}


class Unknown(Exception):
    """Something of IDS that this checker does not claim."""


def values_of(node):
    """Values that a name or value may have; None: any."""
    if node is None:
        return None
    simple = node.find(IDS + "simpleValue")
    if simple is not None:
        return {simple.text or ""}
    restriction = node.find(XS + "restriction")
    kinds = {child.tag for child in restriction}
    if kinds != {XS + "enumeration"} or restriction.get("base") != "xs:string":
        raise Unknown("restrictions but enumerations of strings")
    return {child.get("value") for child in restriction}


def is_nothing(value):
    return value is None or value is DERIVED or value == "" or value == [] or \
        isinstance(value, Enumeration) and value == "U" or isinstance(value, Typed) and is_nothing(value.value)


class Model:
    def __init__(self, path, schemas):
        with open(path, encoding="iso-8859-1") as file:
            header, self.data = part21.read(file.read())
        name = next(arguments[0][0].upper() for word, arguments in header if word == "file_schema")
        self.version = next(SCHEMAS[key] for key in sorted(SCHEMAS, reverse=True) if name.startswith(key))
        self.schema = schemas(self.version)
        self.types, self.sets = {}, {}
        for word, arguments in self.data.values():
            if word == "ifcreldefinesbytype":
                for one in arguments[4]:
                    self.types[one] = arguments[5]
            elif word == "ifcreldefinesbyproperties":
                sets = arguments[5].value if isinstance(arguments[5], Typed) else arguments[5]
                for one in arguments[4]:
                    self.sets.setdefault(one, []).extend(sets if isinstance(sets, list) else [sets])

    def get(self, number, name):
        word, arguments = self.data[number]
        at = self.schema.positions[word].get(name.lower())
        return None if at is None or at >= len(arguments) else arguments[at]

    def all(self):
        return self.data.items()

    def set_of(self, number, name):
        """Properties of a set: of the object, then those of its type, whose properties it may override."""
        own = self.sets.get(number, []) + (self.get(number, "HasPropertySets") or [])  # the second of a type itself
        of_type = self.get(self.types[number], "HasPropertySets") or [] if number in self.types else []
        properties = {}
        for one in [*own, *of_type]:
            if self.get(one, "Name") != name:
                continue
            if self.data[one][0] != "ifcpropertyset":
                raise Unknown("quantities and predefined sets")
            for each in self.get(one, "HasProperties"):
                properties.setdefault(self.get(each, "Name"), each)
        return properties


def matches_entity(facet, model, number):
    if facet.find(IDS + "predefinedType") is not None:
        raise Unknown("predefined types")
    return model.data[number][0].upper() in values_of(facet.find(IDS + "name"))


def matches_attribute(facet, model, number):
    """None: it has no such attribute with a value."""
    names, wanted = values_of(facet.find(IDS + "name")), values_of(facet.find(IDS + "value"))
    if len(names) != 1:
        raise Unknown("several attributes at once")
    value = model.get(number, next(iter(names)))
    if is_nothing(value):
        return None
    if wanted is None:
        return True
    if isinstance(value, bool) or not isinstance(value, str) or isinstance(value, Enumeration):
        raise Unknown("values of attributes that are no strings")
    return value in wanted


def values_of_property(model, number):
    """(type, value) of all that a property holds."""
    word = model.data[number][0]
    if word == "ifcpropertysinglevalue":
        held = [model.get(number, "NominalValue")]
    elif word == "ifcpropertyenumeratedvalue":
        held = model.get(number, "EnumerationValues") or []
    elif word == "ifcpropertylistvalue":
        held = model.get(number, "ListValues") or []
    elif word == "ifcpropertyboundedvalue":
        held = [model.get(number, name) for name in ("UpperBoundValue", "LowerBoundValue", "SetPointValue")]
    else:
        raise Unknown(word)
    return [(one.name.upper(), one.value) for one in held if not is_nothing(one)]


def matches_property(facet, model, number):
    sets, names = values_of(facet.find(IDS + "propertySet")), values_of(facet.find(IDS + "baseName"))
    wanted, kind = values_of(facet.find(IDS + "value")), facet.get("dataType")
    if len(sets) != 1 or len(names) != 1:
        raise Unknown("several properties at once")
    found = model.set_of(number, next(iter(sets))).get(next(iter(names)))
    if found is None:
        return None
    held = values_of_property(model, found)
    if not held:
        return None
    if kind and any(type != kind for type, _ in held):
        return False
    if wanted is None:
        return True
    if any(not isinstance(value, str) or isinstance(value, Enumeration) for _, value in held):
        raise Unknown("values of properties that are no strings")
    return any(value in wanted for _, value in held)


FACETS = {IDS + "entity": matches_entity, IDS + "attribute": matches_attribute, IDS + "property": matches_property}


def facet_holds(facet, model, number):
    if facet.tag not in FACETS:
        raise Unknown("facet " + facet.tag.removeprefix(IDS))
    return FACETS[facet.tag](facet, model, number)


def required_holds(facet, model, number):
    cardinality = facet.get("cardinality", "required")
    holds = facet_holds(facet, model, number)
    return not holds if cardinality == "prohibited" else holds is not False and \
        (holds is not None or cardinality == "optional" and not empty_is_told(facet, model, number))


def empty_is_told(facet, model, number):
    """An optional attribute that is there and empty is not the same as none; a null is none."""
    if facet.tag != IDS + "attribute":
        return False
    return model.get(number, next(iter(values_of(facet.find(IDS + "name"))))) == ""


def failures(specifications, model):
    """What the model does not fulfil, in words."""
    told = []
    for specification in xml.parse(specifications).getroot().iter(IDS + "specification"):
        name = specification.get("name")
        applicability = specification.find(IDS + "applicability")
        if applicability.find(IDS + "entity") is None:
            raise Unknown("applicability without an entity")
        subjects = [n for n, _ in model.all() if all(facet_holds(f, model, n) for f in applicability)]
        if applicability.get("maxOccurs") == "0":
            if applicability.get("minOccurs", "1") != "0" or specification.find(IDS + "requirements") is not None:
                raise Unknown("prohibited specifications with requirements")
            told += [f"{name}: #{n} is prohibited" for n in subjects]
            continue
        if not subjects and applicability.get("minOccurs", "1") != "0":
            told.append(f"{name}: nothing that it is about")
        for facet in specification.find(IDS + "requirements") or []:
            what = "/".join(sorted(text for node in facet for text in node.itertext() if text.strip())[:2])
            told += [f"{name}: #{n}: {what}" for n in subjects if not required_holds(facet, model, n)]
    return told


def run_cases(folder, schemas):
    agree, differ, unknown = 0, [], 0
    for path, _, names in sorted(os.walk(folder)):
        for name in sorted(names):
            if not name.endswith(".ids") or not name.startswith(("pass-", "fail-")):
                continue
            specification = os.path.join(path, name)
            try:
                told = failures(specification, Model(specification[:-3] + "ifc", schemas))
            except (Unknown, part21.Part21Error):
                unknown += 1
                continue
            if bool(told) == name.startswith("fail-"):
                agree += 1
            else:
                differ.append(f"{specification}: {told[:2]}")
    print(f"{agree} cases of buildingSMART as they should be, {len(differ)} not, {unknown} with what this checker refuses")
    print("\n".join(differ))
    return 1 if differ or agree == 0 else 0


def main():
    folder, rest, known = sys.argv[1], sys.argv[2:], {}

    def schemas(version):
        if version not in known:
            names = {"IFC2X3": "IFC2X3", "IFC4": "IFC4", "IFC4X3_ADD2": "IFC4X3"}
            path = next(os.path.join(folder, f) for f in sorted(os.listdir(folder))
                        if f.upper().replace("_", "").startswith(names[version]) and (version != "IFC4" or "4X3" not in f.upper()))
            with open(path, encoding="iso-8859-1") as file:
                known[version] = express.Schema(file.read())
        return known[version]

    if rest[0] == "--cases":
        return run_cases(rest[1], schemas)
    bad = 0
    for specification, path in zip(rest[0::2], rest[1::2]):
        told = failures(specification, Model(path, schemas))
        print(f"{path}: {len(told)} not fulfilled" + "".join("\n  " + line for line in told[:10]))
        bad += len(told)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
