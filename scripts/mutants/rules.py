"""Where a line can be wrong, and how it is written so that a switch makes it wrong.

sites(text) gives each place with its rule and what stands there when it is wrong; rewritten(text, sites) is the source
in which all of them wait for their number (mutant.hpp). It reads the text of formatted C++, not the language: what
does not compile is found by the compiler and left out.
"""
import dataclasses, re

OPENING, CLOSING = '([{', ')]}'
LOW = r'\s(?:\+|-|<|>|<=|>=|==|!=|&&|\|\||\?|:|<<|>>|=|\+=|-=|\*=|/=|<=>)\s'
HIGH = LOW[:-3] + r'|\*|/|%)\s'


# Members that stand side by side in one struct; where one of the two is not there, the compiler leaves the place out.
COPIED = [('first', 'second'), ('from', 'to'), ('width', 'height'), ('low', 'high'), ('lower', 'upper'), ('minimum', 'maximum'),
          ('rows', 'columns'), ('line', 'column'), ('begin', 'end'), ('east', 'north'), ('fx', 'fy'), ('cx', 'cy'), ('p1', 'p2'),
          ('instrument_height', 'target_height'), ('measured', 'computed'), ('given', 'measured'), ('source', 'target')]


@dataclasses.dataclass
class Site:
    rule: str
    start: int       # what the switch encloses, by the text's characters
    end: int
    before: str      # put in at start, N for the number
    after: str       # put in at end
    keep: bool       # whether the text between stays
    tail: int = 0    # so many characters before end go
    shown: str = ''  # the line as it is when wrong
    line: int = 0
    number: int = 0


def blanked(text):
    """The text with comments, literals and directives made blank, so that every place keeps its index."""
    pattern = r'//[^\n]*|/\*.*?\*/|R"\((?:.*?)\)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*'
    keep = lambda m: ''.join(c if c == '\n' else '_' if m[0][0] in '"\'R' else ' ' for c in m[0])
    return re.sub(pattern, keep, text, flags=re.S | re.M)


def operand_end(code, start, stops):
    """Where the operand that begins at start ends: before an operator that binds less, or the end of what encloses it."""
    depth = 0
    for i in range(start, len(code)):
        c = code[i]
        if c in OPENING:
            depth += 1
        elif c in CLOSING:
            depth -= 1
            if depth < 0:
                return i
        elif depth == 0 and (c in ';,' or (c.isspace() and i > start and re.compile(stops).match(code, i))):
            return i
    return len(code)


def bracket_end(code, start):
    """Where the bracket closes that is open at start."""
    depth = 0
    for i in range(start, len(code)):
        depth += (code[i] in OPENING) - (code[i] in CLOSING)
        if depth < 0:
            return i
    return len(code)


def primary_begin(code, end):
    """Where the operand begins that ends before `.member()` at end; None where it is not plain."""
    i = end
    while i > 0:
        c = code[i - 1]
        if c in CLOSING:
            depth = 0
            while i > 0:
                i -= 1
                depth += (code[i] in CLOSING) - (code[i] in OPENING)
                if depth == 0:
                    break
            if code[i] == '{':
                return None
        elif c.isalnum() or c in '_.:':
            i -= 1
        elif c == '>' and code[i - 2] == '-':
            i -= 2
        else:
            break
    return i if i < end and re.match(r'[\w(]', code[i]) and not (c == '>') else None


def spots(code):
    """(rule, start, end, before, after, keep, as it is when wrong, tail)"""
    def spot(rule, start, end, before, after='', keep=True, wrong=None, tail=0):
        return rule, start, end, before, after, keep, wrong, tail

    for m in re.finditer(r'(?<=[\w)\]])\s([+-])\s', code):
        start, end = m.end(), operand_end(code, m.end(), LOW)
        if re.fullmatch(r'[12]', code[start:end]):
            yield spot('off by one', start, end, f'(mutants::on(N) ? 0 : {code[start:end]})', '', False, '0')
        elif not re.fullmatch(r'[\d.e-]+', code[start:end]):
            yield spot('sign of a term', start, end, 'mutants::flip<N>(', ')', True, ('flip', m.start() + 1, m[1]))
    for m in re.finditer(r'\s([+-])=\s', code):
        yield spot('sign of a term', m.end(), operand_end(code, m.end(), ';'), 'mutants::flip<N>(', ')', True,
                   ('flip', m.start() + 1, m[1]))
    for m in re.finditer(r'(?:(?<=[(\[,=?:{]\s)|(?<=[(\[{])|(?<=return ))-(?=[a-z(])', code):
        yield spot('sign of a product', m.end(), operand_end(code, m.end(), HIGH), 'mutants::flip<N>(', ')', True,
                   ('drop', m.start(), m.end()))
    for m in re.finditer(r'(?<![\w.])(0\.5|[234](?:\.0)?)(?= [*/] )|(?<= [*/] )(0\.5|[234](?:\.0)?)(?![\w.])', code):
        yield spot('factor left out', m.start(), m.end(), f'(mutants::on(N) ? {"1.0" if "." in m[0] else "1"} : {m[0]})',
                   '', False, '1')
    # A number that something is compared with, half as large again; a count by one more.
    for m in re.finditer(r'(?<=\s[<>]\s|[<>]=\s)(\d+\.?\d*(?:e-?\d+)?)(?![\w.])(?=\s*(?:[);,&|?*]|$))', code):
        number = m[1]
        wrong = f'1.5 * {number}' if re.search(r'[.e]', number) else f'{int(number) + 1}'
        yield spot('threshold', m.start(), m.end(), f'(mutants::on(N) ? {wrong} : {number})', '', False, wrong)
    for m in re.finditer(r'\bconstexpr double \w+ = ([^;{}]+);', code):
        if 'numeric_limits' in m[1]:
            continue
        yield spot('default', m.start(), m.end(), code[m.start():m.start(1)].replace('constexpr', 'const', 1)
                   + f'(mutants::on(N) ? 1.5 * ({m[1]}) : ({m[1]}));', '', False, m[0].replace(m[1], f'1.5 * ({m[1]})'))
    for m in re.finditer(r'(?<![\w.])(?<!const )double \w+ = (\d+\.?\d*(?:e-?\d+)?);', code):
        if float(m[1]) != 0:
            yield spot('default', m.start(1), m.end(1), f'(mutants::on(N) ? 1.5 * {m[1]} : {m[1]})', '', False, f'1.5 * {m[1]}')
    unit = r'(?:1000(?:\.0?)?|1e-?[369]|180(?:\.0?)?|200(?:\.0?)?|400(?:\.0?)?|60(?:\.0?)?|3600(?:\.0?)?)'
    for m in re.finditer(rf'(?<![\w.])({unit})(?= [*/] )|(?<= [*/] )({unit})(?![\w.])', code):
        yield spot('unit', m.start(), m.end(), f'(mutants::on(N) ? 1 : {m[0]})', '', False, '1')
    # A name that was copied from the line above and not changed.
    for one, other in COPIED:
        for here, there in ((one, other), (other, one)):
            for m in re.finditer(rf'(?<=[\w\])])\.{here}\b(?!\()', code):
                begin = primary_begin(code, m.start())
                if begin is not None and not re.match(r'\s[-+*/|&]?=\s', code[m.end():]):
                    of = code[begin:m.start()]
                    yield spot('copied name', begin, m.end(), f'(mutants::on(N) ? {of}.{there} : {of}.{here})', '', False,
                               f'{of}.{there}')
    for name in ('sqrt', 'abs', 'cos', 'sin', 'atan2', 'hypot', 'clamp', 'max', 'min'):
        wrong = {'cos': 'std::sin(', 'sin': 'std::cos(', 'max': 'std::min(', 'min': 'std::max(', 'sqrt': '(', 'abs': '(',
                 'atan2': 'std::atan2 swapped(', 'hypot': 'first of (', 'clamp': 'first of ('}[name]
        for m in re.finditer(rf'std::{name}\((?!\{{)', code):
            yield spot({'sqrt': 'root left out', 'abs': 'absolute value left out'}.get(name, f'not {name}'),
                       m.start(), m.end(), f'mutants::{name}<N>(', '', False, wrong)
    for member, function in (('norm', 'norm'), ('squaredNorm', 'squared_norm'), ('transpose', 'transpose'),
                             ('inverse', 'inverse'), ('conjugate', 'inverse')):
        rule = 'transposed' if function == 'transpose' else 'inverse left out' if function == 'inverse' else 'square for norm'
        for m in re.finditer(rf'\.{member}\(\)', code):
            begin = primary_begin(code, m.start())
            if begin is not None:
                wrong = {'norm': '.squaredNorm()', 'squaredNorm': '.norm()'}.get(member, '')
                yield spot(rule, begin, m.end(), f'mutants::{function}<N>(', ')', True,
                           ('replace', m.start(), m.end(), wrong), len(m[0]))
    in_for = [range(m.start(), bracket_end(code, m.end())) for m in re.finditer(r'\bfor \(', code)]
    names = {'<': 'less', '>': 'greater', '<=': 'at_most', '>=': 'at_least', '==': 'equal', '!=': 'unequal'}
    for m in re.finditer(r'(?<=[\w)\]])\s(<|>|<=|>=|==|!=)(?=\s)', code):
        if not any(m.start() in head for head in in_for):
            wrong = {'<': '>=', '>': '<=', '<=': '>', '>=': '<', '==': '!=', '!=': '=='}[m[1]]
            yield spot('condition inverted', m.end(), m.end(),
                       f' mutants::Compare<mutants::Relation::{names[m[1]]}>{{N}} {m[1]}', '', True,
                       ('replace', m.start(1), m.end(1), wrong))
    for m in re.finditer(r'\s(&&|\|\|)\s', code):
        end = operand_end(code, m.end(), r'\s(?:&&|\|\||\?|:)\s')
        before = '(mutants::on(N) || (' if m[1] == '&&' else '(!mutants::on(N) && ('
        yield spot('part of a condition left out', m.end(), end, before, '))', True, ('drop', m.start(), end))
    for m in re.finditer(r'\bif \(', code):
        end = bracket_end(code, m.end())
        if re.match(r'\)\s+(continue|break|return\b)', code[end:]) and not re.search(r';|\s=\s', code[m.end():end]):
            yield spot('condition off', m.end(), end, '!mutants::on(N) && (', ')', True, ('replace', m.end(), end, 'false'))
    for m in re.finditer(r'\bif \(', code):
        end = bracket_end(code, m.end())
        if re.fullmatch(r'!?[\w.:>()\[\]-]+', code[m.end():end]):
            yield spot('condition inverted', m.end(), end, 'mutants::on(N) != static_cast<bool>(', ')', True,
                       ('replace', m.end(), end, f'!({code[m.end():end]})'))
    for m in re.finditer(r'(?<=\w)\[([012])\]', code):
        wrong = {'0': '1', '1': '0', '2': '1'}[m[1]]
        yield spot('index', m.start(1), m.end(1), f'(mutants::on(N) ? {wrong} : {m[1]})', '', False, wrong)
    for m in re.finditer(r'\.([xyz])\(\)', code):
        own, wrong = 'xyz'.index(m[1]), {'x': 1, 'y': 0, 'z': 1}[m[1]]
        yield spot('index', m.start(), m.end(), f'[mutants::on(N) ? {wrong} : {own}]', '', False, f'.{"xyz"[wrong]}()')
    for m in re.finditer(r'(?<=\w)\(([a-z]\w*), ([a-z]\w*)\)(?! (?:const )?\{)', code):
        a, b = m[1], m[2]
        if a != b:
            yield spot('arguments swapped', m.start(), m.end(), f'(mutants::other<N>({a}, {b}), mutants::other<N>({b}, {a}))',
                       '', False, f'({b}, {a})')
    for m in re.finditer(r'(?<=[\w)\]])\s([*/])\s(?=[a-z(])', code):
        end = operand_end(code, m.end(), HIGH)
        wrong = '/' if m[1] == '*' else '*'
        yield spot('times for divided by', m.end(), end, 'mutants::invert<N>(', ')', True,
                   ('replace', m.start(1), m.end(1), wrong))
    for m in re.finditer(r'(?<=[;{})])\s*\n\s+(?=[\w*(])', code):
        end = code.find(';', m.end())
        statement = code[m.end():end]
        lvalue = re.match(r'[\w.\[\]>()*:-]+(?:\s[-+*/|&]?=\s|\()', statement)
        if end < 0 or not lvalue or '{' in statement or '}' in statement:
            continue
        if re.match(r'(?:return|if|for|while|switch|case|throw|else|do|static_assert)\b', statement):
            continue
        if lvalue[0].endswith('(') and not re.fullmatch(r'[\w.\[\]>:-]+(?:\(.*\))+', statement, re.S):
            continue
        yield spot('statement left out', m.end(), end + 1, '{ if (!mutants::on(N)) ', ' }', True,
                   ('replace', m.end(), end + 1, ';'))


def sites(text):
    code, found = blanked(text), []
    for rule, start, end, before, after, keep, wrong, tail in spots(code):
        line_begin = text.rfind('\n', 0, start) + 1
        if re.match(r'\s*(?:static_assert|template|using|constexpr (?!double)|PLUMBLINE_)|.*\boperator\b', code[line_begin:].split('\n')[0]):
            continue
        kind = wrong[0] if isinstance(wrong, tuple) else None
        if kind == 'flip':
            edit = wrong[1], wrong[1] + 1, '-' if wrong[2] == '+' else '+'
        elif kind == 'drop':
            edit = wrong[1], wrong[2], ''
        elif kind == 'replace':
            edit = wrong[1:]
        else:
            edit = start, end, wrong
        begin = text.rfind('\n', 0, edit[0]) + 1
        stop = text.find('\n', edit[1])
        shown = ' '.join((text[begin:edit[0]] + edit[2] + text[edit[1]:stop]).split())
        if kind == 'replace' and edit[2] == ';':
            shown = 'without: ' + ' '.join(text[start:end].split())
        found.append(Site(rule, start, end, before, after, keep, tail, shown, text.count('\n', 0, start) + 1))
    found.sort(key=lambda s: (s.start, -s.end, s.rule))
    for number, site in enumerate(found):
        site.number = number
    return found


KNOWN = 1000000  # line numbers from here on are those of sites


def rewritten(text, chosen, name, header):
    """The source with the chosen sites in it; each has a line number of its own for the compiler's messages."""
    taken, edits = [], []  # a text that is replaced has no other site in it
    for site in chosen:
        if not site.keep:
            taken.append((site.start, site.end, site.number))
    inside = lambda s: any(a <= s.start and s.end <= b and n != s.number and (b > a) for a, b, n in taken)
    for site in chosen:
        if inside(site):
            continue
        before = re.sub(r'\bN\b', str(site.number), site.before)
        mark = f'\n#line {KNOWN + site.number}\n{before}\n#line LINE\n'
        edits.append((site.start, 1, -site.end, mark, site.start if site.keep else site.end))
        if site.after:
            edits.append((site.end - site.tail, 0, -site.start, site.after, site.end))
    edits.sort(key=lambda e: e[:3])
    out, at, line = [], 0, lambda index: text.count('\n', 0, index) + 1
    for position, _, _, insert, resume in edits:
        out.append(text[at:position])
        out.append(insert.replace('LINE', str(line(resume))))
        at = max(position, resume)
    out.append(text[at:])
    return f'#define PLUMBLINE_MUTANTS_OF "{name}"\n#include "{header}"\n#line 1\n' + ''.join(out)
