"""Expressions and statements of EXPRESS as Python closures over a Scope. Indeterminate (?) and UNKNOWN are None, logic has
three values; indices start at 1 unless an ARRAY says otherwise."""
import math
import re

from part21 import DERIVED, Enumeration, Typed


class Scope:
    def __init__(self, model, instance=None, variables=None):
        self.model, self.instance, self.variables = model, instance, variables if variables is not None else {}


class Instance:
    """Of the file: values in the order of all attributes. Made by a constructor: id 0, values by name in `named`."""
    __slots__ = ("id", "entity", "values", "model", "named", "cache")

    def __init__(self, id, entity, values, model, named=None):
        self.id, self.entity, self.values, self.model, self.named, self.cache = id, entity, values, model, named, None

    def get(self, name):
        schema = self.model.schema
        if self.named is not None and name in self.named:
            return plain(self.named[name])
        derived = schema.derived[self.entity.name].get(name)
        if derived:
            if self.cache is None:
                self.cache = {}
            if name not in self.cache:
                self.cache[name] = None  # a derivation that needs itself is indeterminate
                self.cache[name] = derived(Scope(self.model, self))
            return self.cache[name]
        position = schema.positions[self.entity.name].get(name)
        if position is not None:
            return plain(self.values[position]) if self.named is None and position < len(self.values) else None
        inverse = schema.inverse[self.entity.name].get(name)
        if inverse:
            found = self.model.users(self, inverse[0], inverse[1])
            return found if inverse[4] else (found[0] if found else None)
        return None


class Array(list):
    def __init__(self, low, items):
        super().__init__(items)
        self.low = low


class EnumerationType:
    pass


def plain(value):
    if isinstance(value, Enumeration) and value in ("T", "F", "U"):
        return {"T": True, "F": False}.get(value)
    return None if value is DERIVED else value


def bare(value):
    while isinstance(value, Typed):
        value = plain(value.value)
    return value


def constant(value):
    return lambda scope: value


def name(word):
    fixed = {"true": True, "false": False, "unknown": None, "pi": math.pi, "const_e": math.e}
    if word in fixed:
        return constant(fixed[word])

    def run(scope):
        if word in scope.variables:
            return scope.variables[word]
        if word == "self":
            return scope.instance
        schema = scope.model.schema
        if isinstance(scope.instance, Instance) and word in schema.names[scope.instance.entity.name]:
            return scope.instance.get(word)
        if word in schema.types and schema.types[word].kind == "enumeration":
            return EnumerationType
        if word in schema.items:
            return Enumeration(word.upper())
        raise NameError(f"EXPRESS name {word}")
    return run


def attribute(value, word):
    def run(scope):
        whole = value(scope)
        if whole is EnumerationType:
            return Enumeration(word.upper())
        return whole.get(word) if isinstance(whole, Instance) else None
    return run


def group(value, word):
    return value  # attribute names are unique along a line of supertypes


def indexed(value, index):
    def run(scope):
        whole, i = bare(value(scope)), bare(index(scope))
        if whole is None or i is None or isinstance(whole, Instance):
            return None
        i = int(i) - getattr(whole, "low", 1)
        return plain(whole[i]) if 0 <= i < len(whole) else None
    return run


def equal(a, b, seen=()):
    """Value comparison."""
    a, b = bare(a), bare(b)
    if a is None or b is None:
        return None
    if a is b:
        return True
    if isinstance(a, Instance) and isinstance(b, Instance):
        if a.entity is not b.entity or (id(a), id(b)) in seen:
            return a.entity is b.entity
        seen = (*seen, (id(a), id(b)))
        pairs = ((a.get(word), b.get(word)) for word in a.model.schema.positions[a.entity.name])
        return all((x is None and y is None) or equal(x, y, seen) for x, y in pairs)
    if isinstance(a, list) and isinstance(b, list):
        if isinstance(a, Bag) or isinstance(b, Bag):
            return len(a) == len(b) and all(contains(b, x) for x in a)
        results = [equal(x, y, seen) for x, y in zip(a, b)]
        return len(a) == len(b) and (None if None in results and False not in results else False not in results)
    return a == b


def same(a, b):
    """Instance comparison :=:."""
    if isinstance(a, Instance) or isinstance(b, Instance):
        return None if a is None or b is None else a is b
    return equal(a, b)


class Bag(list):
    """Without order: of TYPEOF, USEDIN and set operations."""


def contains(items, value):
    if items is None or value is None:
        return None
    if isinstance(value, str) and not isinstance(value, Typed):
        return any(bare(item) == value for item in items)
    return any(same(plain(item), value) for item in items)


def add(a, b):
    if isinstance(a, list) or isinstance(b, list):
        a, b = (x if isinstance(x, list) else [x] for x in (a, b))
        if isinstance(a, Bag) or isinstance(b, Bag):
            return Bag(a + [x for x in b if not contains(a, x)])
        return a + b
    return a + b


def subtract(a, b):
    if isinstance(a, list):
        b = b if isinstance(b, list) else [b]
        return Bag(x for x in a if not contains(b, x))
    return a - b


def multiply(a, b):
    return Bag(x for x in a if contains(b, x)) if isinstance(a, list) else a * b


def compared(operation):
    def run(a, b):
        if isinstance(a, list) and isinstance(b, list):
            return all(contains(b, x) for x in a) if operation(1, 2) else all(contains(a, x) for x in b)
        return operation(a, b)
    return run


def like(text, pattern):
    classes = {"@": "[A-Za-z]", "^": "[A-Z]", "?": ".", "&": ".*", "#": "[0-9]", "$": r"\S*\s?", "*": ".*"}
    return re.fullmatch("".join(classes.get(c, re.escape(c)) for c in pattern), text, re.S) is not None


def combined(a, b):
    """Partial complex instances a || b."""
    deeper = a.entity if b.entity.name in a.model.schema.ancestors[a.entity.name] else b.entity
    return Instance(0, deeper, None, a.model, {**a.named, **b.named})


ARITHMETIC = {
    "+": add, "-": subtract, "*": multiply, "/": lambda a, b: a / b if b else None, "||": combined,
    "**": lambda a, b: a ** b, "div": lambda a, b: int(a / b) if b else None, "mod": lambda a, b: a % b if b else None,
    "<": compared(lambda a, b: a < b), ">": compared(lambda a, b: a > b), "<=": compared(lambda a, b: a <= b),
    ">=": compared(lambda a, b: a >= b), "like": like,
}


def negated(value):
    return None if value is None else not value


def binary(operator, left, right):
    if operator in ("and", "or"):
        decisive = operator == "or"

        def logic(scope):
            a = bare(left(scope))
            if a is decisive:
                return decisive
            b = bare(right(scope))
            return decisive if b is decisive else (None if a is None or b is None else not decisive)
        return logic
    if operator == "xor":
        return lambda scope: (lambda a, b: None if a is None or b is None else a != b)(bare(left(scope)), bare(right(scope)))
    special = {"=": equal, "<>": lambda a, b: negated(equal(a, b)), ":=:": same, ":<>:": lambda a, b: negated(same(a, b)),
               "in": lambda a, b: contains(bare(b), a)}
    if operator in special:
        operation = special[operator]
        return lambda scope: operation(left(scope), right(scope))
    operation = ARITHMETIC[operator]

    def run(scope):
        a, b = bare(left(scope)), bare(right(scope))
        return None if a is None or b is None else operation(a, b)
    return run


def unary(operator, operand):
    if operator == "not":
        return lambda scope: negated(bare(operand(scope)))
    sign = -1 if operator == "-" else 1
    return lambda scope: (lambda v: None if v is None else sign * v)(bare(operand(scope)))


def interval(low, first, value, second, high):
    lower, upper = binary(first, low, value), binary(second, value, high)
    return binary("and", lower, upper)


def query(variable, source, condition):
    def run(scope):
        items = bare(source(scope))
        if items is None:
            return None
        inner, found = Scope(scope.model, scope.instance, dict(scope.variables)), []
        for item in items:
            inner.variables[variable] = plain(item)
            if bare(condition(inner)) is True:
                found.append(item)
        return found
    return run


def aggregate(items):
    def run(scope):
        found = []
        for value, repeated in items:
            found += [value(scope)] * (1 if repeated is None else int(bare(repeated(scope))))
        return found
    return run


def type_names(scope, value):
    schema = scope.model.schema
    if isinstance(value, Instance):
        words = schema.ancestors[value.entity.name]
    elif isinstance(value, Typed):
        words = schema.chain(value.name)
    else:
        return Bag(kind for kind, of in (("STRING", str), ("BOOLEAN", bool), ("REAL", float), ("INTEGER", int), ("LIST", list))
                   if isinstance(value, of))
    return Bag(f"{schema.name}.{word}".upper() for word in {*words, *(s for word in words for s in schema.selects_of(word))})


def unique_values(items):
    return all(not equal(a, b) for i, a in enumerate(items) for b in items[:i]) if len(items) < 200 else \
        len({str(bare(x)) for x in items}) == len(items)


def used_in(scope, value, role):
    _, entity, word = role.lower().split(".")
    return Bag(scope.model.users(value, entity, word))


BUILT_IN = {
    "sizeof": len, "hiindex": lambda v: len(v) + getattr(v, "low", 1) - 1, "loindex": lambda v: getattr(v, "low", 1),
    "hibound": len, "lobound": lambda v: getattr(v, "low", 1), "abs": abs, "length": len, "value_unique": unique_values,
    "sqrt": lambda v: math.sqrt(v) if v >= 0 else None, "sin": math.sin, "cos": math.cos, "tan": math.tan,
    "acos": math.acos, "asin": math.asin, "exp": math.exp, "log": lambda v: math.log(v) if v > 0 else None,
    "odd": lambda v: v % 2 == 1, "blength": lambda v: 4 * (len(v) - 1) - int(v[0]) if v else 0,
    "atan": math.atan2, "value_in": lambda items, v: any(equal(v, x) for x in items),
}


def call(word, arguments):
    def run(scope):
        values = [argument(scope) for argument in arguments]
        schema = scope.model.schema
        if word == "exists":
            return values[0] is not None
        if word == "nvl":
            return values[0] if values[0] is not None else values[1]
        if word == "typeof":
            return None if values[0] is None else type_names(scope, values[0])
        if word == "usedin":
            return Bag() if values[0] is None else used_in(scope, *values)
        if word in BUILT_IN:
            bared = [bare(value) for value in values]
            return None if None in [type(v) if v is None else 0 for v in bared] or any(v is None for v in bared) \
                else BUILT_IN[word](*bared)
        if word in schema.functions:
            return invoke(scope.model, schema.functions[word], values)
        if word in schema.entities:
            entity = schema.entities[word]
            return Instance(0, entity, None, scope.model, {a.name.lower(): v for a, v in zip(entity.attributes, values)})
        if word in schema.types:
            return Typed(word, bare(values[0])) if values[0] is not None else None
        raise NameError(f"EXPRESS function {word}")
    return run


def invoke(model, function, values):
    parameters, variables, body = function
    scope = Scope(model, None, dict(zip(parameters, values)))
    declare(scope, variables)
    result = body(scope)
    return result[1] if result and result[0] == "return" else None


def declare(scope, variables):
    for variable, type, start in variables:
        value = start(scope) if start else ([] if type.kind == "aggregate" else None)
        if type.kind == "aggregate" and type.name == "array" and type.low:
            low, high = bare(type.low(scope)), bare(type.high(scope))
            if low is not None and high is not None:
                value = Array(int(low), (value or []) + [None] * max(0, int(high) - int(low) + 1 - len(value or [])))
        elif type.kind == "aggregate" and type.name in ("set", "bag"):
            value = Bag(value or [])
        scope.variables[variable] = value


# --- statements: each returns None to go on, or ("return", value), ("escape",), ("skip",)
def sequence(steps):
    def run(scope):
        for step in steps:
            if result := step(scope):
                return result
        return None
    return run


def branch(condition, yes, no):
    def run(scope):
        if bare(condition(scope)) is True:
            return yes(scope)
        return no(scope) if no else None
    return run


def case(selector, branches, otherwise):
    def run(scope):
        value = selector(scope)
        for labels, step in branches:
            if any(equal(value, label(scope)) for label in labels):
                return step(scope) if step else None
        return otherwise(scope) if otherwise else None
    return run


def repeat(variable, first, last, step, condition, until, body):
    def run(scope):
        i, end, by = (bare(f(scope)) for f in (first, last, step)) if variable else (0, 0, 0)
        if variable and None in (i, end, by):
            return None
        while not variable or (i <= end if by > 0 else i >= end):
            if variable:
                scope.variables[variable] = i
            if condition and bare(condition(scope)) is not True:
                return None
            result = body(scope)
            if result and result[0] == "escape":
                return None
            if result and result[0] == "return":
                return result
            if until and bare(until(scope)) is True:
                return None
            i += by
        return None
    return run


def returned(value):
    return lambda scope: ("return", value(scope))


def escape(scope):
    return ("escape",)


def skip(scope):
    return ("skip",)


def assignment(variable, path, value):
    def run(scope):
        new, old = value(scope), scope.variables.get(variable)
        if isinstance(new, list):
            new = Array(new.low, new) if isinstance(new, Array) else type(new)(new)
        if not path:
            if isinstance(old, Array) and isinstance(new, list):
                new = Array(old.low, new)
            scope.variables[variable] = new
            return
        target = scope.variables[variable] = writable(old)
        for k, (kind, what) in enumerate(path):
            final = k == len(path) - 1
            if kind == ".":
                if final:
                    target.named[what] = new
                else:
                    target.named[what] = target = writable(target.get(what))
            else:
                i = int(bare(what(scope))) - getattr(target, "low", 1)
                target.extend([None] * (i + 1 - len(target)))
                if final:
                    target[i] = new
                else:
                    target[i] = target = writable(target[i])
    return run


def writable(value):
    """A copy that an assignment may change without changing the file."""
    if isinstance(value, Instance):
        names = value.model.schema.positions[value.entity.name]
        return Instance(0, value.entity, None, value.model, {word: value.get(word) for word in names})
    return Array(value.low, value) if isinstance(value, Array) else list(value or [])
