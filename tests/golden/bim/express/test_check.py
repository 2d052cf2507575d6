"""test_check.py EXPRESS_FOLDER FILE : FILE has no errors, and every fault planted in it is found, under the name that the
schema gives the rule."""
import re
import sys
import tempfile

from check import check

# (pattern, what its first match becomes, what has to be said)
PLANTED = [
    (r"(IFCPROPERTYSINGLEVALUE\('DeviationX'.*?)\);", r"\1,$);", "5 arguments for 4 attributes"),
    (r"(IFCRELDEFINESBYPROPERTIES\('[^']*',#\d+,\$,\$,)\(#\d+\)", r"\1()", "RelatedObjects: 0 items, 1 to any belong there"),
    (r"(IFCRELDEFINESBYPROPERTIES\('[^']*',#\d+,\$,\$,\(#\d+\),)#\d+", r"\1$", "RelatingPropertyDefinition: $ for a required"),
    (r"(IFCRELDEFINESBYPROPERTIES\('[^']*',#\d+,\$,\$,\(#\d+\),)#\d+", r"\1#251", "is none of what IfcPropertySetDefinitionSelect"),
    (r"'ASB_Uncertainty'", "'ASB_AnchorDeviation'", "IfcObject.UniquePropertySetNames"),
    (r"'DeviationY'", "'DeviationX'", "IfcPropertySet.UniquePropertyNames"),
    (r"\(IFCLABEL\('PASS'\)\)", "(IFCLABEL('YES'))", "IfcPropertyEnumeratedValue.WR21"),
    (r"IFCLABEL\('horizontal'\)", "IFCLABEL(1.)", "no string"),
    (r"IFCLABEL\('horizontal'\)", "IFCLABEL('" + "x" * 256 + "')", "longer than 255 characters"),
    (r"IFCLABEL\('horizontal'\)", "'horizontal'", "neither an entity nor a typed value"),
    (r"IFCLENGTHMEASURE\(1\.\)", "IFCLENGTHMEASURE(1)", "no real"),
    (r"IFCNORMALISEDRATIOMEASURE\(1\.\)", "IFCNORMALISEDRATIOMEASURE(1.5)", "IfcNormalisedRatioMeasure"),
    (r"(IFCPROPERTYSET\()'[^']{22}'", r"\1'0$$$$$$$$$$$$$$$$$$$$'", "not of 22 characters"),
    (r"(IFCRELASSIGNSTOPRODUCT\()'[^']*'((?s:.*?)IFCRELASSIGNSTOPRODUCT\()('[^']*')", r"\1\3\2\3", "IfcRoot.UR1"),
    (r"(IFCRELASSIGNSTOPRODUCT\('[^']*',#\d+,(?:\$|'[^']*'),\$,\((#\d+)\),\$,)#\d+", r"\1\2", "NoSelfReference"),
    (r"(#22,'Body',)'SweptSolid'(?=(?s:(?!'SweptSolid').)*$)", r"\1'Brep'", "IfcShapeRepresentation.CorrectItemsForType"),
    (r"(IFCBUILDINGELEMENTPROXY\('[^']*',#\d+,)'[^']*'", r"\1$", "IfcBuildingElementProxy.HasObjectName"),
    (r"(IFCEXTRUDEDAREASOLID\(#\d+,#\d+,#\d+,)60\.\)", r"\g<1>-1.)", "IfcPositiveLengthMeasure"),
    (r"(IFCOWNERHISTORY\(#\d+,#\d+,\$,)\.[A-Z]+\.", r"\1.CHANGEDALL.", "is no value of the enumeration"),
    (r"(IFCSTYLEDITEM\()#\d+", r"\g<1>#999999", "refers to #999999"),
    (r"(IFCSTYLEDITEM\()#\d+(.*?;(?s:.*?)IFCSTYLEDITEM\()(#\d+)", r"\1\3\2\3", "StyledByItem: 2 ifcstyleditem"),
    (r"FILE_SCHEMA\(\('IFC4'\)\)", "FILE_SCHEMA(('IFC4'),$)", "FILE_SCHEMA"),
]


def errors_of(schemas, text):
    with tempfile.NamedTemporaryFile("w", encoding="latin-1", suffix=".ifc") as file:
        file.write(text)
        file.flush()
        return [what for _, what in check(schemas, file.name)]


def main(schemas, path):
    sys.setrecursionlimit(3000)
    with open(path, encoding="latin-1") as file:
        text = file.read()
    wrong = [f"the file has errors: {check(schemas, path)}"] if check(schemas, path) else []
    for pattern, replacement, expected in PLANTED:
        broken, count = re.subn(pattern, replacement, text, count=1)
        if count == 0:
            wrong.append(f"nothing matches {pattern}")
            continue
        errors = errors_of(schemas, broken)
        if not any(expected in what for what in errors):
            wrong.append(f"planted {replacement!r} for {pattern}: {expected!r} is not among {errors[:4]}")
    harmless = text.replace("IFCLABEL('horizontal')", r"IFCLABEL('\S\'\X\96')")
    wrong += [f"an apostrophe of the other code page: {what}" for what in errors_of(schemas, harmless)]
    print("\n".join(wrong) or f"{len(PLANTED)} planted faults found")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
