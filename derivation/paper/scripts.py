r"""Scripts, on tokens: marks and orders told from powers, and one digit where there are no braces.

A superscript decorates its letter, ``x^{(2)'}``, ``Y^{\prime *}``, or is a power. What decorates becomes
tokens of its own, ORDER, PRIMES and SUP with a mark, a power of the decorated letter (``\theta^{(1)2}``)
following them. A bracket that is neither an order nor part of a formula is an error.
"""

from __future__ import annotations

from collections.abc import Iterator

from lark import Token

from derivation.errors import ReadError

#: How many arguments a command takes; without braces each is one symbol.
ARGUMENTS = {"FRAC": 2, "SQRT": 1, "SUP": 1, "SUB": 1, "ACCENT": 1}
#: What has places and limits for subscripts, not names.
PLACES = {"EVAL_BAR", "INT", "SERIES"}


def single_digits(tokens: list[Token]) -> Iterator[Token]:
    r"""As in TeX an argument without braces is one digit: ``\frac12`` is a half, ``x^23`` is x^2 times 3.

    Raises:
        ReadError: a decimal number in such a place.
    """
    due = [0]  # arguments still to come, in each open brace
    for t in tokens:
        if t.type == "RBRACE":
            due.pop()
        elif t.type == "LBRACE":
            due.append(0)
            yield t
            continue
        text = str(t)
        if due[-1] and t.type == "NUMBER":
            if "." in text:
                raise ReadError(t.line or 0, f"{text} stands without braces where TeX takes one digit")
            while due[-1] and len(text) > 1:
                yield t.update(value=text[0])
                text, due[-1] = text[1:], due[-1] - 1
        due[-1] += ARGUMENTS.get(t.type, 0) - bool(due[-1])
        yield t.update(value=text)


def resolve(tokens: list[Token]) -> list[Token]:
    """Tokens with the superscripts that decorate letters taken apart.

    Raises:
        ReadError: a superscript that is neither decoration nor power, or a subscript with brackets.
    """
    out: list[Token] = []
    at = 0
    while at < len(tokens):
        t = tokens[at]
        if t.type in ("SUP", "SUB"):
            end, inside = _argument(tokens, at + 1)
            if t.type == "SUB":
                _check_subscript(t, inside, out)
            elif not _is_exponential(out) and (marks := _decoration(t, inside)):
                marks[-1].end_pos = tokens[end - 1].end_pos
                out += marks
                at = end
                continue
        out.append(t)
        at += 1
    return out


def _argument(tokens: list[Token], at: int) -> tuple[int, list[Token]]:
    """Where the argument that begins at ``at`` ends, and what is in it."""
    if at >= len(tokens) or tokens[at].type != "LBRACE":
        return min(at + 1, len(tokens)), tokens[at : at + 1]
    depth = 0
    for end in range(at, len(tokens)):
        depth += (tokens[end].type == "LBRACE") - (tokens[end].type == "RBRACE")
        if not depth:
            return end + 1, tokens[at + 1 : end]
    return len(tokens), tokens[at + 1 :]


def _is_exponential(before: list[Token]) -> bool:
    """Whether a bare e stands before: its superscript is an exponent, brackets and all."""
    named = len(before) > 1 and before[-2].type in ("SUB", "ACCENT")
    return bool(before) and before[-1] == "e" and not named


def _decoration(sup: Token, inside: list[Token]) -> list[Token]:
    """Orders, primes and marks, then perhaps a power; nothing for a power alone."""
    marks: list[Token] = []
    at = 0
    while at < len(inside):
        t = inside[at]
        if _is_order(inside[at : at + 3]):
            marks.append(inside[at + 1].update(type="ORDER"))
            at += 3
        elif t.type in ("PRIMES", "STAR", "DAGGER"):
            marks += [t] if t.type == "PRIMES" else [sup, t]
            at += 1
        else:
            break
    rest = inside[at:]
    if marks and [t.type for t in rest] == ["NUMBER"]:
        return [*marks, sup, *rest]
    bracketed = any(_is_order(rest[k : k + 3]) for k in range(len(rest))) or _in_brackets(rest)
    if (marks and rest) or bracketed:
        raise ReadError(
            sup.line or 0,
            f"the superscript {' '.join(inside)} is neither an order such as (2) with marks nor a power",
        )
    return marks


def _is_order(triple: list[Token]) -> bool:
    """``(2)`` or ``(n)``."""
    if [t.type for t in triple] not in (["LPAR", "NUMBER", "RPAR"], ["LPAR", "LETTER", "RPAR"]):
        return False
    text = str(triple[1])
    return triple[0] == "(" and (text.isdigit() or (len(text) == 1 and text.islower()))


def _in_brackets(tokens: list[Token]) -> bool:
    """Whether one bracket holds it all."""
    depth = 0
    for k, t in enumerate(tokens):
        depth += (t.type == "LPAR") - (t.type == "RPAR")
        if not depth:
            return t.type == "RPAR" and k == len(tokens) - 1
    return False


def _check_subscript(sub: Token, inside: list[Token], before: list[Token]) -> None:
    if before and before[-1].type not in PLACES and any(t.type == "LPAR" for t in inside):
        raise ReadError(sub.line or 0, f"the subscript {' '.join(inside)} is not made of letters and numbers")
