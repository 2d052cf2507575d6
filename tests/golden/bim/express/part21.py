"""Reads ISO 10303-21 exchange files into plain Python values: a reader of its own, so that what Plumbline writes is not
only read by Plumbline. Everything is in memory; meant for files of some megabytes."""
import re

# \S\' is the one apostrophe of a string that need not be doubled.
TOKEN = re.compile(
    r"\s*(?:/\*.*?\*/\s*)*(?:"
    r"(?P<text>'(?:\\S\\'(?!\s*[,)])|[^']|'')*')|(?P<binary>\"[0-9A-Fa-f]*\")|(?P<reference>#\s*\d+)|"
    r"(?P<real>[+-]?\d+\.\d*(?:[Ee][+-]?\d+)?)|(?P<integer>[+-]?\d+)|(?P<enumeration>\.[A-Za-z0-9_]+\.)|"
    r"(?P<keyword>[!A-Za-z_][A-Za-z0-9_-]*)|(?P<mark>[()=,;$*]))", re.S)


class Part21Error(Exception):
    pass


class Reference(int):
    """#n"""


class Enumeration(str):
    """.NAME., in capitals without its dots."""


class Binary(str):
    pass


class Typed:
    """KEYWORD(value): a value of a defined type, as selects need it."""

    def __init__(self, name, value):
        self.name, self.value = name, value

    def __eq__(self, other):
        return (self.value if not isinstance(other, Typed) else (self.name, self.value)) == \
            (other if not isinstance(other, Typed) else (other.name, other.value))

    def __hash__(self):
        return hash(str(self.value))


DERIVED = type("Derived", (), {"__repr__": lambda self: "*"})()


def decoded(text):
    """Characters of a string literal, so that its length is that of what is meant."""
    text = text[1:-1].replace("''", "'")
    if "\\" not in text:
        return text
    text = re.sub(r"\\X2\\((?:[0-9A-Fa-f]{4})*)\\X0\\",
                  lambda m: bytes.fromhex(m[1]).decode("utf-16-be", "replace"), text)
    text = re.sub(r"\\X4\\((?:[0-9A-Fa-f]{8})*)\\X0\\",
                  lambda m: bytes.fromhex(m[1]).decode("utf-32-be", "replace"), text)
    text = re.sub(r"\\X\\([0-9A-Fa-f]{2})", lambda m: chr(int(m[1], 16)), text)
    text = re.sub(r"\\P[A-I]\\", "", text)
    text = re.sub(r"\\S\\(.)", lambda m: chr(ord(m[1]) + 128), text, flags=re.S)
    return text.replace("\\\\", "\\")


class Reader:
    def __init__(self, source):
        self.source, self.at = source, 0
        self.next()

    def next(self):
        match = TOKEN.match(self.source, self.at)
        if not match:
            rest = self.source[self.at:].strip()
            if rest and not re.fullmatch(r"(?:\s|/\*.*?\*/)*", rest, re.S):
                raise Part21Error(f"line {self.line()}: no token: {rest[:40]!r}")
            self.kind, self.text = "end", ""
            return
        self.at = match.end()
        self.kind = match.lastgroup
        self.text = match[self.kind]

    def line(self):
        return self.source.count("\n", 0, self.at) + 1

    def take(self, text):
        if self.text != text or self.kind not in ("mark", "keyword"):
            raise Part21Error(f"line {self.line()}: {text!r} expected, found {self.text[:40]!r}")
        self.next()

    def value(self):
        kind, text = self.kind, self.text
        self.next()
        if kind == "text":
            return decoded(text)
        if kind == "real":
            return float(text)
        if kind == "integer":
            return int(text)
        if kind == "reference":
            return Reference(text[1:].strip())
        if kind == "enumeration":
            return Enumeration(text[1:-1].upper())
        if kind == "binary":
            return Binary(text[1:-1])
        if text == "$":
            return None
        if text == "*":
            return DERIVED
        if text == "(":
            return self.rest_of_list()
        if kind == "keyword":
            self.take("(")
            values = self.rest_of_list()
            if len(values) != 1:
                raise Part21Error(f"line {self.line()}: {text} holds {len(values)} values")
            return Typed(text.lower(), values[0])
        raise Part21Error(f"line {self.line()}: no value: {text!r}")

    def rest_of_list(self):
        values = []
        if self.text == ")" and self.kind == "mark":
            self.next()
            return values
        while True:
            values.append(self.value())
            if self.text == ")" and self.kind == "mark":
                self.next()
                return values
            self.take(",")

    def record(self):
        if self.kind != "keyword":
            raise Part21Error(f"line {self.line()}: a keyword expected, found {self.text[:40]!r}")
        name = self.text.lower()
        self.next()
        self.take("(")
        return name, self.rest_of_list()


def read(source):
    """(header records, {id: (keyword, arguments)}) of the text of a file."""
    reader = Reader(source)
    for text in ("ISO-10303-21", ";", "HEADER", ";"):
        reader.take(text)
    header, data = [], {}
    while reader.text != "ENDSEC":
        header.append(reader.record())
        reader.take(";")
    for text in ("ENDSEC", ";", "DATA", ";"):
        reader.take(text)
    while reader.text != "ENDSEC":
        if reader.kind != "reference":
            raise Part21Error(f"line {reader.line()}: #number expected, found {reader.text[:40]!r}")
        number = int(reader.text[1:])
        reader.next()
        reader.take("=")
        if number in data:
            raise Part21Error(f"line {reader.line()}: #{number} twice")
        data[number] = reader.record()
        reader.take(";")
    for text in ("ENDSEC", ";", "END-ISO-10303-21", ";"):
        reader.take(text)
    return header, data
