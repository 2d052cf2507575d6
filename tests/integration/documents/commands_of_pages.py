"""The lines of all documents that call something: of code blocks, and code spans that begin with `plumbline`."""
import pathlib
import re


def pages(root):
    found = sorted([*root.glob("*.md"), *root.glob("docs/**/*.md"), *root.glob("benchmarks/**/*.md")])
    return [page for page in found if "reference" not in page.parts and page.name != "CHANGELOG.md"]


def of_blocks(text):
    for block in re.finditer(r"^```(.*?)\n(.*?)^```", text, re.M | re.S):
        if block.group(1) in ("", "sh", "bash"):
            yield from re.sub(r"\\\n\s*", "", block.group(2)).splitlines()


def of_spans(text):
    without = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    for span in re.finditer(r"(?<!`)(`+)(?!`)(.+?)(?<!`)\1(?!`)", without, re.S):
        yield span.group(2).replace("\n", " ")


def plain(line):
    line = re.sub(r"\s\s+#.*$|\s# .*$", "", line).strip()
    return re.sub(r"^\$(?=plumbline)|^\$ ", "", line)


def is_call(line):
    return re.match(r"(?:[A-Z_]+=\S+ )*plumbline(-robots)? ", line) is not None


def all_lines(root):
    """(page, line) of what calls the program, in the order of the pages."""
    for page in pages(root):
        text = page.read_text(encoding="utf-8")
        for line in map(plain, [*of_blocks(text), *of_spans(text)]):
            if is_call(line):
                yield page.relative_to(root).as_posix(), line


OTHER = re.compile(r"(?:[A-Z_]+=\S+ )*(scripts/|build/bin/|benchmarks/|cmake |ninja |ctest |/usr/bin/)")
OTHER_SPAN = re.compile(r"(?:[A-Z_]+=\S+ )*(scripts/\w+(?![\w/.])|(build/bin/)?\w+_benchmark\b|(benchmarks/[\w/]+/)?\w+\.py |benchmarks/[\w/]+(\.py|/run)(?!\S)|cmake -|ctest -|/usr/bin/)")


def other_lines(root):
    """(page, line, whether it is of a code block) of what calls something else, as far as the first word tells."""
    for page in pages(root):
        text = page.read_text(encoding="utf-8")
        for begin, lines in ((OTHER, of_blocks(text)), (OTHER_SPAN, of_spans(text))):
            for line in map(plain, lines):
                if begin.match(line) and not is_call(line):
                    yield page.relative_to(root).as_posix(), line, begin is OTHER
