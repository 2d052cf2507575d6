#!/usr/bin/env python3
"""make_large.py DESIGN FILLER MEGABYTES OUT: a large IFC file out of real ones.

DESIGN with the instances of FILLER after its own, renumbered, as often as it takes: what a reader meets in FILLER (kinds
and lengths of instances, shapes, property sets) it meets in OUT in the same proportions. Every copy has GlobalIds of its
own; projects of FILLER become that of DESIGN. Both files need one schema."""
import re
import sys

ALPHABET = b"0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_$"
INSTANCE = re.compile(rb"#(\d+)\s*=\s*([A-Za-z0-9_]*)\s*\((?:[^';]|'(?:[^']|'')*')*\)\s*;")
REFERENCE = re.compile(rb"'(?:[^']|'')*'|#(\d+)")
GUID = re.compile(rb"\(\s*'([0-3][0-9A-Za-z_$]{21})'")


def instances(data):
    return [(int(m.group(1)), m.group(2).upper(), m.group(0)) for m in INSTANCE.finditer(data)]


def guid_of_copy(guid, copy):
    """The fifth to eighth digit, of base 64, plus the number of the copy: elements of a model mostly differ elsewhere."""
    number = copy
    for k in range(4):
        number += ALPHABET.index(guid[7 - k]) * 64**k
    return guid[:4] + bytes(ALPHABET[number // 64**k % 64] for k in (3, 2, 1, 0)) + guid[8:]


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__.split("\n")[0])
    design, filler = (open(path, "rb").read() for path in sys.argv[1:3])
    size = int(float(sys.argv[3]) * 1e6)
    schema = [re.search(rb"FILE_SCHEMA\s*\(\s*\(\s*'([^']*)'", data).group(1) for data in (design, filler)]
    if schema[0] != schema[1]:
        sys.exit(f"{sys.argv[1]} is {schema[0].decode()}, {sys.argv[2]} {schema[1].decode()}: they need one schema")
    own, added = instances(design), instances(filler[filler.index(b"DATA;"):])
    project = next(number for number, keyword, _ in own if keyword == b"IFCPROJECT")
    projects = {number for number, keyword, _ in added if keyword == b"IFCPROJECT"}
    span = max(number for number, _, _ in added) + 1
    first = max(number for number, _, _ in own) + 1
    end = design.rindex(b"ENDSEC")
    with open(sys.argv[4], "wb") as out:
        out.write(design[:end])
        for copy in range(1, 100000):
            if out.tell() >= size:
                break
            shift = first + (copy - 1) * span

            def renumbered(match):
                if match.group(1) is None:
                    return match.group(0)
                number = int(match.group(1))
                return b"#%d" % (project if number in projects else number + shift)

            for number, _, text in added:
                if number in projects:
                    continue
                text = GUID.sub(lambda m: b"('" + guid_of_copy(m.group(1), copy) + b"'", text, count=1)
                out.write(REFERENCE.sub(renumbered, text) + b"\n")
        out.write(design[end:])


main()
