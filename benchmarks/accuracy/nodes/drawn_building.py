"""A drawn building: anchors 2 m apart, two in a storey, a panel between two columns, on one facade or on four round a block."""
import hashlib

SIDES = {"S": ((0, 0), (1, 0), (0, -1)), "E": ((1, 0), (0, 1), (1, 0)), "N": ((1, 1), (-1, 0), (0, 1)), "W": ((0, 1), (0, -1), (-1, 0))}
STOREY, APART = 4.0, 2.0  # [m]


def anchors(floors, columns, facades):
    """(name, facade, floor, column, row, position [m]) of each, floors and columns from 1."""
    width = APART * columns
    for floor in range(floors):
        for facade in facades:
            (x, y), (rx, ry), _ = SIDES[facade]
            for column in range(columns):
                for row in (0, 1):
                    along = 1 + APART * column
                    at = (x * width + rx * along, y * width + ry * along, STOREY * floor + 1 + 2 * row)
                    yield f"{facade}-F{floor + 1}-C{column + 1}-R{row + 1}", facade, floor + 1, column + 1, row + 1, at


def panels(floors, columns, facades):
    """(name, facade, floor, middle of the lower edge [m]): 60 mm before the anchors."""
    width = APART * columns
    for floor in range(floors):
        for facade in facades:
            (x, y), (rx, ry), (ox, oy) = SIDES[facade]
            for column in range(1, columns):
                along = APART * column
                at = (x * width + rx * along + 0.06 * ox, y * width + ry * along + 0.06 * oy, STOREY * floor + 1.05)
                yield f"{facade}-F{floor + 1}-P{column}", facade, floor + 1, at


def guid(key):
    digits = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_$"
    number, text = int(hashlib.sha1(key.encode()).hexdigest()[:32], 16), ""
    for _ in range(22):
        text, number = digits[number & 63] + text, number >> 6
    return text


class Step:
    """Lines of a STEP file, each with its number."""

    def __init__(self):
        self.lines = []

    def __call__(self, text):
        self.lines.append(text)
        return f"#{len(self.lines)}"

    def point(self, at):
        return self("IFCCARTESIANPOINT((%.6f,%.6f,%.6f))" % tuple(at))

    def box(self, context, origin, up, x, y, z):
        middle = self(f"IFCAXIS2PLACEMENT2D({self('IFCCARTESIANPOINT((0.,0.))')},$)")
        profile = self(f"IFCRECTANGLEPROFILEDEF(.AREA.,$,{middle},{x:.3f},{y:.3f})")
        solid = self(f"IFCEXTRUDEDAREASOLID({profile},{origin},{up},{z:.3f})")
        shape = self(f"IFCSHAPEREPRESENTATION({context},'Body','SweptSolid',({solid}))")
        return self(f"IFCPRODUCTDEFINITIONSHAPE($,$,({shape}))")

    def write(self, path):
        head = ("ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('drawn','2026-01-01T00:00:00',(''),(''),'','','');\n"
                "FILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n")
        body = "".join(f"#{i}={text};\n" for i, text in enumerate(self.lines, 1))
        path.write_text(head + body + "ENDSEC;\nEND-ISO-10303-21;\n")


def write_ifc(path, floors, columns, facades):
    """The design: an IfcMechanicalFastener for each anchor, an IfcPlate for each panel, a slab for each storey."""
    step = Step()
    units = step(f"IFCUNITASSIGNMENT(({step('IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.)')},{step('IFCSIUNIT(*,.PLANEANGLEUNIT.,$,.RADIAN.)')}))")
    origin = step(f"IFCAXIS2PLACEMENT3D({step.point((0, 0, 0))},$,$)")
    context = step(f"IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-05,{origin},$)")
    project = step(f"IFCPROJECT('{guid('project')}',$,'drawn',$,$,$,$,({context}),{units})")
    world = step(f"IFCLOCALPLACEMENT($,{origin})")
    building = step(f"IFCBUILDING('{guid('building')}',$,'drawn',$,$,{world},$,$,.ELEMENT.,$,$,$)")
    step(f"IFCRELAGGREGATES('{guid('of project')}',$,$,$,{project},({building}))")
    up = step("IFCDIRECTION((0.,0.,1.))")
    right = {side: step("IFCDIRECTION((%.1f,%.1f,0.))" % axes[1]) for side, axes in SIDES.items()}

    def placed(at, side):
        return step(f"IFCLOCALPLACEMENT({world},{step(f'IFCAXIS2PLACEMENT3D({step.point(at)},{up},{right[side]})')})")

    width = APART * columns
    depth = width if len(facades) > 1 else 6
    slab = step.box(context, origin, up, width - 0.1, depth - 0.1, 0.3)
    bolt, plate = step.box(context, origin, up, 0.04, 0.04, 0.08), step.box(context, origin, up, 1.98, 0.05, 1.9)
    held = [[step(f"IFCSLAB('{guid(f'slab {f}')}',$,'slab {f + 1}',$,$,{placed((width / 2, depth / 2, STOREY * f), 'S')},{slab},$,.FLOOR.)")]
            for f in range(floors)]
    for name, side, floor, _, _, at in anchors(floors, columns, facades):
        held[floor - 1].append(step(f"IFCMECHANICALFASTENER('{guid(name)}',$,'{name}',$,$,{placed(at, side)},{bolt},'{name}',$,$,$)"))
    for name, side, floor, at in panels(floors, columns, facades):
        held[floor - 1].append(step(f"IFCPLATE('{guid(name)}',$,'{name}',$,$,{placed(at, side)},{plate},'{name}',.CURTAIN_PANEL.)"))
    storeys = []
    for f, elements in enumerate(held):
        z = STOREY * f
        storeys.append(step(f"IFCBUILDINGSTOREY('{guid(f'storey {f}')}',$,'Floor {f + 1}',$,$,{placed((0, 0, z), 'S')},$,$,.ELEMENT.,{z:.3f})"))
        step(f"IFCRELCONTAINEDINSPATIALSTRUCTURE('{guid(f'in {f}')}',$,$,$,({','.join(elements)}),{storeys[-1]})")
    step(f"IFCRELAGGREGATES('{guid('of building')}',$,$,$,{building},({','.join(storeys)}))")
    step.write(path)
