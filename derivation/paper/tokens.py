r"""LaTeX mathematics to tokens: commands named, layout dropped, brackets matched, bars told apart.

A small table says what each command is; one that is not in it is an error that names it, with its line.
Size and nesting are bounded here, before anything is parsed.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from lark import Token

from derivation.errors import ReadError
from derivation.paper.scripts import resolve, single_digits

MAX_TOKENS = 20_000
MAX_DEPTH = 40
MAX_DIGITS = 40

GREEK = {
    "alpha", "beta", "gamma", "delta", "epsilon", "varepsilon", "zeta", "eta", "theta", "vartheta",
    "iota", "kappa", "lambda", "mu", "nu", "xi", "pi", "rho", "sigma", "tau", "upsilon", "phi",
    "varphi", "chi", "psi", "omega", "Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma",
    "Upsilon", "Phi", "Psi", "Omega", "ell",
}  # fmt: skip
ACCENTS = {
    "tilde",
    "bar",
    "hat",
    "vec",
    "dot",
    "overline",
    "widetilde",
    "boldsymbol",
    "mathbf",
    "mathcal",
    "bm",
}
FUNCTIONS = {"cos", "sin", "exp", "Re", "Im", "diag"}
LAYOUT = {
    "displaystyle", "textstyle", "left", "right", "big", "Big", "bigg", "Bigg", "bigl", "bigr", "Bigl",
    "Bigr", "biggl", "biggr", "Biggl", "Biggr", "bigm", "nonumber", "notag", "limits", "nolimits",
    "centering", ",", ";", "!", ":", ">", " ",
}  # fmt: skip
COMMANDS: dict[str, tuple[str, str]] = {
    "equiv": ("REL", "equiv"), "simeq": ("REL", "simeq"), "approx": ("REL", "simeq"), "to": ("REL", "to"),
    "rightarrow": ("REL", "to"), "mapsto": ("REL", "to"), "cdot": ("DOT", "."), "times": ("DOT", "x"),
    "partial": ("PARTIAL", ""), "frac": ("FRAC", ""), "dfrac": ("FRAC", ""), "tfrac": ("FRAC", ""),
    "sqrt": ("SQRT", ""), "int": ("INT", ""), "sum": ("SERIES", ""), "dagger": ("DAGGER", ""),
    "ast": ("STAR", "*"), "infty": ("INFTY", ""), "cdots": ("DOTS", ""), "dots": ("DOTS", ""),
    "ldots": ("DOTS", ""), "quad": ("QUAD", ""), "qquad": ("QUAD", ""), "prime": ("PRIMES", "'"),
    "{": ("LPAR", "{"), "}": ("RPAR", "}"), "lbrace": ("LPAR", "{"), "rbrace": ("RPAR", "}"),
}  # fmt: skip
SINGLE: dict[str, tuple[str, str]] = {
    "=": ("REL", "="), "+": ("SIGN", "+"), "-": ("SIGN", "-"), "/": ("OVER", "/"), "^": ("SUP", "^"),
    "_": ("SUB", "_"), "*": ("STAR", "*"), "{": ("LBRACE", "{"), "}": ("RBRACE", "}"), "(": ("LPAR", "("),
    ")": ("RPAR", ")"), "[": ("LPAR", "["), "]": ("RPAR", "]"), ",": ("COMMA", ","), "&": ("AMP", "&"),
    "|": ("BAR", "|"), ".": ("STOP", "."), ";": ("COMMA", ";"), ":": ("STOP", ":"),
}  # fmt: skip
CLOSES = {
    "LPAR": "RPAR",
    "LBRACE": "RBRACE",
    "LBAR": "RBAR",
    "EVAL_OPEN": "EVAL_BAR",
    "MATRIX_BEGIN": "MATRIX_END",
}
PAIRS = {"(": ")", "[": "]", "{": "}"}
WRITTEN = {"LBAR": "|", "EVAL_OPEN": r"\left.", "MATRIX_BEGIN": r"\begin{bmatrix}"}

#: What a reader of an error message calls the terminals.
NAMES = {
    "REL": "a relation such as =", "SIGN": "+ or -", "NUMBER": "a number", "LETTER": "a symbol",
    "LPAR": "an opening bracket", "RPAR": "a closing bracket", "LBRACE": "{", "RBRACE": "}", "LBAR": "|",
    "RBAR": "a closing |", "FRAC": r"\frac", "$END": "the end of the equation", "SUP": "^", "SUB": "_",
    "COMMA": "a comma", "AMP": "&", "ROW": r"\\", "MATRIX_END": r"\end{bmatrix}",
    "OVER": "/", "PRIMES": "a prime",
    "EVAL_BAR": r"\right|", "ORDER": "an order such as ^{(2)}",
}  # fmt: skip

_TOKEN = re.compile(
    r"""(?P<blank>[\s~]+)
      | (?P<ccnst>\\mathrm\s*\{\s*c\.c\.\s*\+\s*\\mathrm\s*\{\s*n\.s\.t\.\s*\}\s*\})
      | (?P<label>\\label\s*\{(?P<key>[^{}]*)\})
      | (?P<matrix>\\(?P<edge>begin|end)\s*\{(?P<env>[a-zA-Z]+\*?)\})
      | (?P<words>\\(?:mathrm|text|textrm|operatorname\*?|rm)\s*(?:\{(?P<text>[^{}]*)\}|(?P<short>[A-Za-z])))
      | (?P<evalopen>\\left\s*\.)
      | (?P<evalbar>\\(?:right|[bB]igg?r?)\s*\|)
      | (?P<leftbar>\\left\s*\|)
      | (?P<row>\\\\\*?(?:\s*\[\s*-?[0-9.]+\s*[a-z]{2}\s*\])?)
      | (?P<command>\\(?:[a-zA-Z]+|.))
      | (?P<number>[0-9]+(?:\.[0-9]+)?|\.[0-9]+)
      | (?P<primes>'+)
      | (?P<letter>[A-Za-z])
      | (?P<single>[-=+/^_*{}()\[\],&|.;:])""",
    re.VERBOSE,
)
MATRICES = {"bmatrix", "pmatrix", "matrix"}


def tokenize(text: str, line: int) -> list[Token]:
    """Tokens of mathematics that begins on ``line``; brackets matched, bars and superscripts resolved.

    Raises:
        ReadError: an unknown command or character, an unmatched bracket, a superscript of no known kind, too
            long or too deeply nested.
    """
    raw: list[Token] = []
    at = 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise ReadError(line, f"unexpected character {text[at]!r}")
        raw.extend(_classify(match, line))
        line += match.group().count("\n")
        at = match.end()
        if len(raw) > MAX_TOKENS:
            raise ReadError(line, f"more than {MAX_TOKENS} symbols in one display; split it")
    return resolve(list(single_digits(_match_brackets(raw))))


def _classify(m: re.Match[str], line: int) -> list[Token]:
    def tok(kind: str, value: str) -> Token:
        return Token(kind, value, start_pos=m.start(), line=line, end_pos=m.end())

    text = m.group()
    match m.lastgroup:
        case "blank":
            return []
        case "ccnst":
            return [tok("CC", ""), tok("SIGN", "+"), tok("NST", "")]
        case "label":
            return [tok("LABEL", m["key"].strip())]
        case "matrix":
            kind = f"MATRIX_{m['edge'].upper()}"
            return [tok(kind, text)] if m["env"] in MATRICES else []
        case "words":
            return _words((m["text"] if m["text"] is not None else m["short"]).strip(), tok)
        case "evalopen":
            return [tok("EVAL_OPEN", text)]
        case "evalbar":
            return [tok("EVAL_BAR", text)]
        case "leftbar":
            return [tok("BAR", "|")]
        case "row":
            return [tok("ROW", text)]
        case "number":
            if len(text) > MAX_DIGITS:
                raise ReadError(line, f"a number of {len(text)} digits; at most {MAX_DIGITS} are read")
            return [tok("NUMBER", text)]
        case "primes":
            return [tok("PRIMES", text)]
        case "letter":
            return [tok("LETTER", text)]
        case "single":
            return [tok(*SINGLE[text])]
    name = text[1:]
    if name in LAYOUT:
        return []
    if name in GREEK:
        return [tok("LETTER", text)]
    if name in ACCENTS:
        return [tok("ACCENT", text)]
    if name in FUNCTIONS:
        return [tok("FUNC", name)]
    if name in COMMANDS:
        kind, value = COMMANDS[name]
        return [tok(kind, value or text)]
    raise ReadError(line, f"unknown command {text}; expected mathematics that this reader's grammar knows")


def _words(word: str, tok: Callable[[str, str], Token]) -> list[Token]:
    r"""What stands in \mathrm, \text, \operatorname."""
    if word in ("c.c.", "cc"):
        return [tok("CC", "")]
    if word in ("n.s.t.", "nst"):
        return [tok("NST", "")]
    if word in FUNCTIONS:
        return [tok("FUNC", word)]
    if word == "at":
        return [tok("AT", "at")]
    if word == "d":
        return [tok("D", "d")]
    if len(word) == 2 and word[0] == "d":  # \mathrm{dA} for \mathrm{d}A
        return [tok("D", "d"), tok("LETTER", word[1])]
    return [tok("WORD", rf"\mathrm{{{word}}}")] if word else []


def _match_brackets(raw: list[Token]) -> list[Token]:
    open_: list[Token] = []
    out: list[Token] = []
    for t in raw:
        if t.type == "BAR":
            t = t.update(type="RBAR" if open_ and open_[-1].type == "LBAR" else "LBAR")
        elif t.type == "EVAL_BAR" and open_ and open_[-1].type == "LBAR":
            t = t.update(type="RBAR")
        elif t.type == "EVAL_BAR" and not any(o.type == "EVAL_OPEN" for o in open_):
            raise ReadError(t.line or 0, f"{t} without an opening \\left.")
        if t.type in CLOSES:
            open_.append(t)
            if len(open_) > MAX_DEPTH:
                raise ReadError(t.line or 0, f"brackets nested deeper than {MAX_DEPTH}")
        elif t.type in CLOSES.values():
            _close(open_, t)
        out.append(t)
    if open_:
        raise ReadError(open_[-1].line or 0, f"{_shown(open_[-1])} is not closed")
    return out


def _close(open_: list[Token], t: Token) -> None:
    if not open_:
        raise ReadError(t.line or 0, f"{t} closes nothing")
    o = open_.pop()
    if CLOSES[o.type] != t.type or (o.type == "LPAR" and PAIRS[str(o)] != str(t)):
        raise ReadError(t.line or 0, f"{t} closes {_shown(o)} of line {o.line}")


def _shown(t: Token) -> str:
    return WRITTEN.get(t.type, str(t))
