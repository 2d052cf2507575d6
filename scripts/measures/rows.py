"""docs/measured.toml: what it holds, and what is wrong with it."""
import fnmatch
import functools
import pathlib
import re
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
FILE = ROOT / "docs/measured.toml"
# Where a value is found: exactly one of these.
SOURCES = ("metric", "file", "text", "property", "asserts", "time")
KEYS = {
    "part": {"heading", "text", "row"},
    "row": {"claim", "on", "note", "check"},
    "check": {"command", "test", "here", "long", "exit", "before", "write", "seeds", "wants", "modules", "values"},
    "value": {"of", "value", "tolerance", "unit", "factor", "most", "pointer", "over", *SOURCES},
}
LONGEST = 200  # characters of a cell: more is no table


class NoRows(Exception):
    """The file has no rows to look at; the text says what was found and what to give."""


def load(file=FILE):
    """The parts of the file. Throws NoRows where it cannot be read or holds none."""
    if pathlib.Path(file).is_dir():
        raise NoRows(f"{file} is a folder; rows are in a file such as {FILE.relative_to(ROOT)}, and the folder of the test data is said by "
                     f"PLUMBLINE_TEST_DATA={file}")
    try:
        with open(file, "rb") as stream:
            parts = tomllib.load(stream).get("part")
    except (OSError, UnicodeDecodeError) as fault:
        raise NoRows(f"{file} cannot be read: {getattr(fault, 'strerror', None) or 'it is not UTF-8'}; --data takes a file such as {FILE.relative_to(ROOT)}") from fault
    except tomllib.TOMLDecodeError as fault:
        raise NoRows(f"{file} is no TOML: {fault}") from fault
    if not isinstance(parts, list) or not all(isinstance(part, dict) for part in parts):
        raise NoRows(f"{file} has no [[part]] with rows; the head of {FILE.relative_to(ROOT)} says how one is written")
    return parts


def rows(parts):
    return [row for part in parts for row in part.get("row", [])]


def checks(row):
    found = row.get("check", [])
    return found if isinstance(found, list) else [found]


def values(check):
    """Those of the check; without a list of them the check is its only one."""
    if "values" in check:
        return check["values"]
    return [{key: check[key] for key in check if key in KEYS["value"]}]


def command(check):
    """What is typed."""
    return check["command"] if "command" in check else "ctest --test-dir build -R " + check["test"]


def others(check):
    """Repositories of others that the command reads: OWNER/NAME."""
    return sorted(set(re.findall(r"\$OTHERS/([\w.-]+/[\w.-]+)", " ".join([command(check), check.get("before", ""), check.get("here", "")]))))


def mark(check):
    """Who makes it again: quick (every run of the tests), test, long, or others (files that do not come with the test data)."""
    if others(check):
        return "others"
    if "test" in check:
        return "test"
    return "long" if check.get("long") else "quick"


@functools.cache
def sources_of_tests():
    return [(file, file.read_text(encoding="utf-8", errors="replace")) for file in sorted((ROOT / "tests").rglob("*"))
            if file.suffix in (".cpp", ".hpp", ".txt", ".py", ".sh", ".mjs")]


@functools.cache
def tests_of_the_tree():
    """Names of all tests as their sources have them; what CMake puts together is a *."""
    names = set()
    for file, text in sources_of_tests():
        if file.suffix in (".cpp", ".hpp"):
            names |= {f"{a}.{b}" for a, b in re.findall(r"^(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+)\s*,\s*(\w+)\s*\)", text, re.M)}
        elif file.name == "CMakeLists.txt":
            names |= {re.sub(r"\$\{\w+\}", "*", name) for name in re.findall(r"add_test\(\s*NAME\s+([^\s)]+)", text)}
    return names


def is_there(name):
    return any(fnmatch.fnmatchcase(test, name) or fnmatch.fnmatchcase(name, test) for test in tests_of_the_tree())


def number(thing):
    return isinstance(thing, (int, float)) and not isinstance(thing, bool)


def faults_of_value(value, of_test):
    where = [source for source in SOURCES if source in value and not (source == "text" and "file" in value)]
    if len(where) != 1:
        yield f"a value needs one of {', '.join(SOURCES)}, this one has {', '.join(where) or 'none'}"
    for key in ("value", "tolerance"):
        if not number(value.get(key)):
            yield f"a value needs '{key}', a number"
    if number(value.get("tolerance")) and value["tolerance"] < 0:
        yield "a tolerance is not negative"
    if "file" in value and ("pointer" in value) == ("text" in value) or "pointer" in value and "file" not in value:
        yield "a file needs either 'pointer' or 'text', and a pointer a file"
    if "text" in value:
        try:
            re.compile(value["text"])
        except re.error as error:
            yield f"'text' is no regular expression: {error}"
    if value.get("over", "most") not in ("most", "sum", "count") or "over" in value and "text" not in value:
        yield "'over' is most, sum or count, of what 'text' finds"
    if ("property" in value or "asserts" in value) and not of_test:
        yield "'property' and 'asserts' are of tests"


def asserts(line, test):
    """Whether the line stands in a source of that test: one that names its suite, or lies beside the CMakeLists.txt that does."""
    suite = re.compile(rf"\b{test.split('.')[0]}\b")
    line = re.sub(r"\s+", " ", line)
    named = [file for file, text in sources_of_tests() if suite.search(text)]
    beside = {file.parent for file in named if file.name == "CMakeLists.txt"}
    return any(line in re.sub(r"\s+", " ", text) for file, text in sources_of_tests() if file in named or file.parent in beside)


def faults_of_check(check):
    if ("command" in check) == ("test" in check):
        yield "a check needs either 'command' or 'test'"
        return
    if "test" in check and not is_there(check["test"]):
        yield f"names the test {check['test']}, which is not there"
    if "$BEFORE" in command(check) and "before" not in check:
        yield "$BEFORE without 'before'"
    if ("$HERE" in command(check)) != ("here" in check):
        yield "$HERE and 'here' belong together"
    if "{seed}" in command(check) and "seeds" not in check:
        yield "{seed} without 'seeds'"
    for value in values(check):
        for key in sorted(value.keys() - KEYS["value"]):
            yield f"unknown key '{key}' of a value"
        yield from faults_of_value(value, "test" in check)
        if "asserts" in value and not asserts(value["asserts"], check.get("test", "")):
            yield f"the test {check.get('test')} has no line `{value['asserts']}`"


def faults_of_row(row):
    for key in ("claim", "on"):
        if not isinstance(row.get(key), str) or not row[key]:
            yield f"needs '{key}'"
    if not checks(row):
        yield "needs a check: a command, its values, their tolerances. What nobody can make again belongs into docs/observations.md"
    for key in sorted(row.keys() - KEYS["row"]):
        yield f"unknown key '{key}'"
    for check in checks(row):
        for key in sorted(check.keys() - KEYS["check"] - (set() if "values" in check else KEYS["value"])):
            yield f"unknown key '{key}' of a check"
        yield from faults_of_check(check)


def faults(parts):
    """Sentences, each with the row it is about."""
    for part in parts:
        for key in sorted(part.keys() - KEYS["part"]):
            yield f"part '{part.get('heading', '')}': unknown key '{key}'"
    seen = set()
    for row in rows(parts):
        claim = row.get("claim", "a row without a claim")
        for fault in faults_of_row(row):
            yield f"'{claim}': {fault}"
        if claim in seen:
            yield f"'{claim}' stands twice"
        seen.add(claim)
