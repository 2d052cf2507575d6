"""Parses the text of an EXPRESS schema (ISO 10303-11) into declarations whose expressions are Python closures over a
scope. Everything that the IFC schemas use is read, so that WHERE rules come from the official text and from nowhere else."""
import re

import evaluate as ev

LEXEME = re.compile(
    r"(?:\s|\(\*.*?\*\)|--[^\n]*)*(?:(?P<text>'(?:[^']|'')*')|(?P<real>\d+\.\d*(?:[Ee][+-]?\d+)?)|(?P<integer>\d+)|"
    r"(?P<word>[A-Za-z]\w*)|(?P<mark>:=:|:<>:|:=|<=|>=|<>|<\*|\|\||\*\*|[-+*/=<>\\|{}\[\]().,;:?]))", re.S)
SIMPLE = {"real", "integer", "number", "string", "boolean", "logical", "binary"}


class Type:
    """kind: simple, named, aggregate, enumeration, select, generic."""

    def __init__(self, kind, name="", low=None, high=None, unique=False, of=None, members=()):
        self.kind, self.name, self.low, self.high, self.unique, self.of = kind, name, low, high, unique, of
        self.members, self.where, self.label = members, [], name


class Attribute:
    def __init__(self, name, type, optional):
        self.name, self.type, self.optional = name, type, optional


class Entity:
    def __init__(self, name):
        self.name, self.label, self.parent, self.abstract = name.lower(), name, None, False
        self.attributes, self.redeclared, self.derived, self.inverse, self.unique, self.where = [], {}, {}, {}, [], []


class Parser:
    def __init__(self, text):
        self.tokens, at = [], 0
        while match := LEXEME.match(text, at):
            at = match.end()
            kind = match.lastgroup
            self.tokens.append((kind, match[kind].lower() if kind == "word" else match[kind], match[kind], at))
        self.tokens.append(("end", "", "", at))
        self.at, self.text = 0, text
        self.types, self.entities, self.functions, self.rules = {}, {}, {}, []
        self.schema()

    # --- tokens
    def peek(self, ahead=0):
        return self.tokens[self.at + ahead][1]

    def next(self):
        self.at += 1
        return self.tokens[self.at - 1][1]

    def accept(self, *texts):
        if self.peek() in texts and self.tokens[self.at][0] != "text":
            return self.next()
        return None

    def take(self, text):
        if not self.accept(text):
            kind, _, found, at = self.tokens[self.at]
            raise SyntaxError(f"line {self.text.count(chr(10), 0, at) + 1}: {text!r} expected, found {found!r}")

    def label(self):
        self.at += 1
        return self.tokens[self.at - 1][2]

    # --- declarations
    def schema(self):
        self.take("schema")
        self.name = self.next()
        self.take(";")
        readers = {"type": self.type_declaration, "entity": self.entity, "function": self.function, "rule": self.rule}
        while not self.accept("end_schema"):
            readers[self.next()]()

    def type(self):
        word = self.next()
        if word in SIMPLE:
            high = None
            if self.accept("("):
                high = self.expression()
                self.take(")")
            fixed = high if self.accept("fixed") else None
            return Type("simple", word, low=fixed, high=high)
        if word in ("list", "set", "bag", "array", "aggregate"):
            low = high = None
            if self.accept("["):
                low = self.expression()
                self.take(":")
                high = self.expression()
                self.take("]")
            if self.accept(":"):
                self.next()
            self.take("of")
            self.accept("optional")
            unique = bool(self.accept("unique"))
            return Type("aggregate", word, low, high, unique or word == "set", self.type())
        if word == "enumeration":
            self.take("of")
            return Type("enumeration", members=self.names())
        if word == "select":
            return Type("select", members=self.names())
        if word in ("generic", "generic_entity"):
            if self.accept(":"):
                self.next()
            return Type("generic")
        return Type("named", word)

    def names(self):
        self.take("(")
        names = [self.next()]
        while self.accept(","):
            names.append(self.next())
        self.take(")")
        return names

    def type_declaration(self):
        label = self.label()
        self.take("=")
        type = self.types[label.lower()] = self.type()
        type.label = label
        self.take(";")
        if self.accept("where"):
            type.where = self.where_rules()
        self.take("end_type")
        self.take(";")

    def where_rules(self):
        rules = []
        while not self.peek().startswith("end_"):
            label = f"rule {len(rules) + 1}"
            if self.peek(1) == ":":
                label = self.label()
                self.next()
            rules.append((label, self.expression()))
            self.take(";")
        return rules

    def attribute_names(self):
        """[(name, group it is redeclared from or None)]"""
        names = []
        while True:
            group = None
            if self.accept("self"):
                self.take("\\")
                group = self.next()
                self.take(".")
            names.append((self.label(), group))
            if not self.accept(","):
                return names

    def entity(self):
        entity = Entity(self.label())
        self.entities[entity.name] = entity
        while not self.accept(";"):
            word = self.next()
            if word == "abstract":
                entity.abstract = True
            elif word == "of":
                self.skip_parentheses()
            elif word == "subtype":
                self.take("of")
                entity.parent, = self.names()
        sections = {"derive": self.derive, "inverse": self.inverse, "unique": self.unique}
        while not self.accept("end_entity"):
            if self.peek() in sections:
                sections[self.next()](entity)
            elif self.accept("where"):
                entity.where = self.where_rules()
            else:
                self.explicit(entity)
        self.take(";")

    def skip_parentheses(self):
        self.take("(")
        depth = 1
        while depth:
            depth += {"(": 1, ")": -1}.get(self.next(), 0)

    def explicit(self, entity):
        names = self.attribute_names()
        self.take(":")
        optional, type = bool(self.accept("optional")), self.type()
        self.take(";")
        for label, group in names:
            if group:
                entity.redeclared[label.lower()] = Attribute(label, type, optional)
            else:
                entity.attributes.append(Attribute(label, type, optional))

    def derive(self, entity):
        while self.peek() not in ("inverse", "unique", "where", "end_entity"):
            (label, group), = self.attribute_names()
            self.take(":")
            type = self.type()
            self.take(":=")
            entity.derived[label.lower()] = (self.expression(), type, group is not None)
            self.take(";")

    def inverse(self, entity):
        while self.peek() not in ("unique", "where", "end_entity"):
            label = self.label()
            self.take(":")
            low, high, many = ev.constant(1), ev.constant(1), False
            if self.accept("set", "bag"):
                many, low, high = True, ev.constant(0), ev.constant(None)
                if self.accept("["):
                    low = self.expression()
                    self.take(":")
                    high = self.expression()
                    self.take("]")
                self.take("of")
            source = self.next()
            self.take("for")
            entity.inverse[label.lower()] = (source, self.next(), low, high, many, label)
            self.take(";")

    def unique(self, entity):
        while self.peek() not in ("where", "end_entity"):
            label = "unique"
            if self.peek(1) == ":":
                label = self.label()
                self.next()
            entity.unique.append((label, [name.lower() for name, _ in self.attribute_names()]))
            self.take(";")

    # --- functions, rules and statements
    def function(self):
        label = self.label()
        parameters = []
        if self.accept("("):
            while not self.accept(")"):
                names = [self.next()]
                while self.accept(","):
                    names.append(self.next())
                self.take(":")
                self.type()
                self.accept(";")
                parameters += names
        self.take(":")
        self.type()
        self.take(";")
        self.functions[label.lower()] = (parameters, self.locals(), self.statements("end_function"))
        self.take("end_function")
        self.take(";")

    def rule(self):
        label = self.label()
        self.take("for")
        names = self.names()
        self.take(";")
        local, body = self.locals(), self.statements("where")
        self.take("where")
        self.rules.append((label, names, local, body, self.where_rules()))
        self.take("end_rule")
        self.take(";")

    def locals(self):
        variables = []
        if not self.accept("local"):
            return variables
        while not self.accept("end_local"):
            names = [self.next()]
            while self.accept(","):
                names.append(self.next())
            self.take(":")
            type = self.type()
            start = self.expression() if self.accept(":=") else None
            self.take(";")
            variables += [(name, type, start) for name in names]
        self.take(";")
        return variables

    def statements(self, *ends):
        steps = []
        while self.peek() not in ends:
            if step := self.statement():
                steps.append(step)
        return ev.sequence(steps)

    def statement(self):
        word = self.next()
        if word == ";":
            return None
        if word == "if":
            condition = self.expression()
            self.take("then")
            yes, no = self.statements("else", "end_if"), None
            if self.accept("else"):
                no = self.statements("end_if")
            self.close("end_if")
            return ev.branch(condition, yes, no)
        if word == "case":
            return self.case()
        if word == "repeat":
            return self.repeat()
        if word == "return":
            value = ev.constant(None) if self.peek() == ";" else self.expression()
            self.take(";")
            return ev.returned(value)
        if word == "begin":
            body = self.statements("end")
            self.close("end")
            return body
        if word in ("escape", "skip"):
            self.take(";")
            return ev.escape if word == "escape" else ev.skip
        path = []  # of an assignment
        while not self.accept(":="):
            if self.accept("["):
                path.append(("index", self.expression()))
                self.take("]")
            else:
                path.append((self.next(), self.next()))
        value = self.expression()
        self.take(";")
        return ev.assignment(word, [step for step in path if step[0] != "\\"], value)

    def close(self, word):
        self.take(word)
        self.take(";")

    def case(self):
        selector, branches, otherwise = self.expression(), [], None
        self.take("of")
        while not self.accept("end_case"):
            if self.accept("otherwise"):
                self.take(":")
                otherwise = self.statement()
                continue
            labels = [self.expression()]
            while self.accept(","):
                labels.append(self.expression())
            self.take(":")
            branches.append((labels, self.statement()))
        self.take(";")
        return ev.case(selector, branches, otherwise)

    def repeat(self):
        variable = first = last = step = condition = until = None
        if self.peek(1) == ":=":
            variable = self.next()
            self.next()
            first = self.expression()
            self.take("to")
            last = self.expression()
            step = self.expression() if self.accept("by") else ev.constant(1)
        if self.accept("while"):
            condition = self.expression()
        if self.accept("until"):
            until = self.expression()
        self.take(";")
        body = self.statements("end_repeat")
        self.close("end_repeat")
        return ev.repeat(variable, first, last, step, condition, until, body)

    # --- expressions
    def expression(self):
        left = self.simple_expression()
        while operator := self.accept("=", "<>", "<", ">", "<=", ">=", ":=:", ":<>:", "in", "like"):
            left = ev.binary(operator, left, self.simple_expression())
        return left

    def simple_expression(self):
        left = self.term()
        while operator := self.accept("+", "-", "or", "xor"):
            left = ev.binary(operator, left, self.term())
        return left

    def term(self):
        left = self.factor()
        while operator := self.accept("*", "/", "div", "mod", "and", "||"):
            left = ev.binary(operator, left, self.factor())
        return left

    def factor(self):
        left = self.unary()
        return ev.binary("**", left, self.unary()) if self.accept("**") else left

    def unary(self):
        if operator := self.accept("not", "-", "+"):
            return ev.unary(operator, self.unary())
        return self.qualified(self.primary())

    def primary(self):
        kind, word, label, _ = self.tokens[self.at]
        self.at += 1
        if kind == "text":
            return ev.constant(label[1:-1].replace("''", "'"))
        if kind == "real":
            return ev.constant(float(label))
        if kind == "integer":
            return ev.constant(int(label))
        if word == "(":
            value = self.expression()
            self.take(")")
            return value
        if word == "?":
            return ev.constant(None)
        if word == "[":
            return self.aggregate()
        if word == "{":
            low = self.simple_expression()
            first = self.next()
            value = self.simple_expression()
            second = self.next()
            high = self.simple_expression()
            self.take("}")
            return ev.interval(low, first, value, second, high)
        if word == "query":
            self.take("(")
            variable = self.next()
            self.take("<*")
            source = self.expression()
            self.take("|")
            condition = self.expression()
            self.take(")")
            return ev.query(variable, source, condition)
        if self.accept("("):
            arguments = []
            while not self.accept(")"):
                arguments.append(self.expression())
                self.accept(",")
            return ev.call(word, arguments)
        return ev.name(word)

    def aggregate(self):
        items = []
        while not self.accept("]"):
            value = self.expression()
            items.append((value, self.expression() if self.accept(":") else None))
            self.accept(",")
        return ev.aggregate(items)

    def qualified(self, value):
        while mark := self.accept(".", "\\", "["):
            if mark == ".":
                value = ev.attribute(value, self.next())
            elif mark == "\\":
                value = ev.group(value, self.next())
            else:
                index = self.expression()
                self.take("]")
                value = ev.indexed(value, index)
        return value
