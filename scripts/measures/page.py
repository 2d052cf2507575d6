"""docs/measured.md and a page for each subject in docs/measured/: short tables, notes folded out below them."""
import pathlib
import re

from . import rows as data

PAGE = data.ROOT / "docs/measured.md"
FOLDER = data.ROOT / "docs/measured"
LONGEST_LINE = 380  # of a table
NOTE = "<!-- Made by scripts/measured from docs/measured.toml: change that. -->"
HEAD = """# What was measured

Each row is a claim, what it was measured on, its figures with the tolerance they are compared within, and the command that makes
them again: `scripts/measured --check` types them and compares. *Simulated*: photographs and readings of our own simulator, whose
optics are ideal and whose transfer curve is linear where a row does not say `optics=real`. A number in brackets leads to what else was seen and
how far it holds, below the tables of its page. What was seen once and has no command is no figure: it stands in [observations](observations.md).

`$DATA` is the public test data (`PLUMBLINE_TEST_DATA`), `$OTHERS` a folder with clones of public repositories, `$OTHERS/OWNER/NAME`
(`PLUMBLINE_OTHERS`); `$HERE` is the folder that the row names, `$SCRATCH` one for files that the row has in
`docs/measured.toml`, `$BEFORE` what the command before it gave. Times are processor times, of a machine with two cores where a row says nothing else.
"""
MARKS = {
    "quick": ("✓", "computed and compared in every run of the tests"),
    "test": ("◇", "held by a test: the figure is what it asserts, or what it found and asserts"),
    "long": ("○", "computed and compared by `scripts/measured --check --long`: seconds to an hour each"),
    "others": ("△", "the same, with files of others in `$OTHERS`"),
}


def written(number):
    """1e-06 as it is read: 10⁻⁶."""
    text = f"{number:.6g}"
    if "e" not in text:
        return text
    mantissa, exponent = text.split("e")
    power = "10" + "".join("⁰¹²³⁴⁵⁶⁷⁸⁹"[int(c)] if c.isdigit() else "⁻" for c in str(int(exponent)))
    return power if mantissa == "1" else f"{mantissa}·{power}"


def figure(value):
    unit = " " + value["unit"] if value.get("unit") else ""
    label = value["of"] + " " if value.get("of") else ""
    if value.get("most"):
        return f"{label}≤ {written(value['value'] + value['tolerance'])}{unit}"
    return label + written(value["value"]) + (f" ± {written(value['tolerance'])}" if value["tolerance"] else "") + unit


def folded(text, width=140):
    """In lines, as a list item has them. No line begins with what would be a list, a heading, a quotation or a table of its own."""
    lines = [""]
    for word in text.split():
        begins = re.match(r"[-+*>#|=~]|\d+[.)]$|<", word)
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width and not begins:
            lines.append("  " + word)
        else:
            lines[-1] += (" " if lines[-1] else "") + word
    return "\n".join(lines)


def cell(text):
    return text.replace("|", "\\|").replace("\n", " ")


def lines_of(row, bracket, aside):
    """A line for each command, so that no cell is long; where a line would be, its command goes to the list `aside`, with its number."""
    for number, check in enumerate(data.checks(row)):
        command = f"{MARKS[data.mark(check)][0]} `{data.command(check)}`"
        if "before" in check:
            words = check["before"].split()
            command += f", after `{' '.join(words[:3])} …`" if words[0] == "plumbline" else f", after {words[0].split('/')[-1]}"
        if "seeds" in check:
            command += f", {len(check['seeds'])} seeds"
        on = row["on"] if not number else ""
        if "here" in check:
            on += f" ($HERE: `{check['here']}`)"
        line = [row["claim"] + bracket if not number else "", on, "; ".join(map(figure, data.values(check))), command]
        if sum(map(len, line)) > LONGEST_LINE:
            aside.append(command)
            line[3] = f"{command[0]} [command {len(aside)}](#command-{len(aside)})"
        yield line


def subjects(parts):
    """Heading and parts of each page: a part without a heading belongs to the one before it."""
    pages = []
    for part in parts:
        if "heading" in part or not pages:
            pages.append((part.get("heading", "Figures"), []))
        pages[-1][1].append(part)
    return pages


def file_of(heading):
    return FOLDER / (re.sub(r"[^a-z]+", "_", heading.lower()) + ".md")


def marks(parts):
    kinds = [data.mark(check) for row in data.rows(parts) for check in data.checks(row)]
    return [f"- {mark} {kinds.count(name)} {what}" for name, (mark, what) in MARKS.items()]


def index(parts):
    """docs/measured.md: how the pages of figures are to be read, and which there are."""
    checks = sum(len(data.checks(row)) for row in data.rows(parts))
    lines = [HEAD.rstrip(), "", NOTE, "", f"{len(data.rows(parts))} claims, {checks} commands:", "", *marks(parts), "", "| figures of | claims |", "|---|---|"]
    for heading, of in subjects(parts):
        lines.append(f"| [{heading}]({FOLDER.name}/{file_of(heading).name}) | {len(data.rows(of))} |")
    return "\n".join(lines) + "\n"


def subject(heading, parts):
    """The tables of one subject; below them what else was seen, and the commands that are too long for a cell."""
    legend = "; ".join(f"{mark} {what}" for mark, what in (("✓", "in every run of the tests"), ("◇", "held by a test"), ("○", "takes long"), ("△", "files of others")))
    lines, notes, aside = [f"# {heading}: what was measured", "", NOTE, "", f"{legend} ([how to read this](../{PAGE.name})).", ""], [], []
    for part in parts:
        if "text" in part:
            lines += [part["text"].strip(), ""]
        if not part.get("row"):
            continue
        lines += ["| what | on | figure | again with |", "|---|---|---|---|"]
        for row in part["row"]:
            bracket = ""
            if "note" in row:
                number = len(notes) + 1
                bracket = f" [({number})](#note-{number})"
                notes.append(f'- <a id="note-{number}"></a>' + folded(f'**({number})** {row["note"]}'))
            lines += ["| " + " | ".join(map(cell, line)) + " |" for line in lines_of(row, bracket, aside)]
        lines.append("")
    if notes:
        lines += ["## Notes", "", *notes, ""]
    if aside:
        lines += ["## Long commands", "", *(f'- <a id="command-{n}"></a>**{n}** {command}' for n, command in enumerate(aside, 1)), ""]
    return "\n".join(lines)


def pages(parts):
    """The text of each page, by its file."""
    pages = {PAGE: index(parts), **{file_of(heading): subject(heading, of) for heading, of in subjects(parts)}}
    assert len(pages) == 1 + len(list(subjects(parts))), "two headings of measured.toml make the same file: name one otherwise"
    return pages


def too_long(parts):
    """Cells that are longer than a table's should be."""
    for row in data.rows(parts):
        for line in lines_of(row, "", []):
            for text in line:
                if len(text) > data.LONGEST:
                    yield f"'{row['claim']}': a cell of {len(text)} characters, at most {data.LONGEST} are a table: {text[:60]}…"
