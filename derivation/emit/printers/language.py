"""Packages as one file of another language: a table of what its statements look like, and two templates.

The templates `NAME_file.txt` and `NAME_function.txt` hold the frame; everything else is in the table.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from derivation.emit.lower import EmissionError
from derivation.emit.nodes import Node
from derivation.emit.printers import notation
from derivation.emit.printers.layout import INDENT, WIDTH, statement, wrapped
from derivation.emit.printers.notation import Notation
from derivation.emit.printers.python import template
from derivation.emit.program import Package, Program, compile_function

MARGIN = 2 * INDENT


@dataclass(frozen=True)
class Language:
    """How a language writes functions. Where a pair is given, it goes before and after an expression."""

    name: str
    notation: Notation
    title: Callable[[str], str] = str
    """How the rod's name is spelt as that of a package."""
    argument: str = "{}"
    result: str = ""
    """An argument that takes one of several results; empty where a function returns them all."""
    value: str = "{}"
    """The name under which one of several results is kept."""
    nothing: str = ""
    """An empty list of arguments."""
    types: tuple[str, str] = ("", "")
    """What a function with one result and what one with several returns."""
    local: tuple[str, str] = ("{} = ", "")
    output: tuple[str, str] = ("{} = ", "")
    """Locals, and one of several results, given its name."""
    only: tuple[str, str] = ("return ", "")
    """The one result."""
    together: str = "return {}"
    """Several results at the end; empty where each has been handed over already."""
    margin: str = ""
    """Before every line for readers."""
    escapes: tuple[tuple[str, str], ...] = ()
    """What must not stand in a text for readers, and what stands there instead."""
    reserved: frozenset[str] = frozenset()
    """Words that cannot be names."""

    def spell(self, name: str) -> str:
        """The name as this language writes it; EmissionError if it cannot."""
        spelt = self.notation.name(name)
        if spelt in self.reserved:
            raise EmissionError(f"{name!r} means something else in {self.name}: choose another name")
        return spelt

    def text(self, words: str) -> str:
        """Words for a reader, made harmless."""
        for old, new in self.escapes:
            words = words.replace(old, new)
        return words


def source(package: Package, language: Language) -> str:
    """Every function of the package in one file, in the package's order.

    Raises EmissionError where a name cannot be used in that language, or two names become one.
    """
    programs = [compile_function(f) for module in package.modules for f in module.functions]
    names = [language.spell(program.name) for program in programs]
    _require_distinct(package.model, names)
    title = language.title(package.model)
    functions = [_function(program, language, title) for program in programs]
    return template(f"{language.name}_file").substitute(
        title=title,
        model=package.model,
        doc=language.text(package.doc),
        names="\n".join(wrapped(", ".join(names), "")),
        functions="\n".join(functions),
    )


def _function(program: Program, language: Language, title: str) -> str:
    arguments = [language.spell(a.name) for a in program.arguments]
    local = [language.spell(name) for name, _ in program.locals]
    outputs = [language.value.format(language.spell(name)) for name, _ in program.outputs]
    several = len(outputs) > 1
    _require_distinct(program.name, [*arguments, *local, *(outputs if several else ())])
    received = outputs if several and language.result else []
    signature = [language.argument.format(a) for a in arguments] + [
        language.result.format(name) for name in received
    ]
    assigned = [] if received or not several else outputs
    return template(f"{language.name}_function").substitute(
        title=title,
        name=language.spell(program.name),
        type=language.types[several],
        arguments=_folded(", ".join(signature)) or language.nothing,
        names=_folded(", ".join(arguments)),
        locals=_folded(", ".join([*local, *assigned])),
        doc="\n".join(_doc(program, language)),
        body="\n".join(_body(program, language)),
    )


def _folded(arguments: str) -> str:
    """A list that fits behind a function's name, or else on lines of its own."""
    if len(arguments) <= WIDTH // 2:
        return arguments
    return "\n".join(["", *wrapped(arguments, MARGIN)])


def _body(program: Program, language: Language) -> Iterable[str]:
    def line(pair: tuple[str, str], node: Node, name: str = "") -> str:
        return statement(pair[0].format(name), node, language.notation, pair[1])

    for name, node in program.locals:
        yield line(language.local, node, language.spell(name))
    if len(program.outputs) == 1:
        yield line(language.only, program.outputs[0][1])
        return
    names = [language.value.format(language.spell(name)) for name, _ in program.outputs]
    for name, (_, node) in zip(names, program.outputs, strict=True):
        yield line(language.output, node, name)
    if language.together:
        yield INDENT + language.together.format(", ".join(names))


def _doc(program: Program, language: Language) -> Iterable[str]:
    """What the function computes, its arguments, its results in their order, the paper's labels."""
    spell = language.spell
    results = ", ".join(spell(name) for name, _ in program.outputs)
    texts = [
        program.doc,
        "",
        *(f"{spell(a.name)}: {a.doc}" for a in program.arguments),
        f"Returns {results}.",
    ]
    if program.labels:
        texts.append(f"Paper: {', '.join(program.labels)}.")
    for text in texts:
        yield from wrapped(language.text(text), language.margin, INDENT) or [""]


def _require_distinct(where: str, names: Iterable[str]) -> None:
    if twice := [name for name, number in Counter(names).items() if number > 1]:
        raise EmissionError(f"{where}: two names become {', '.join(twice)} in this language")


def words(text: str) -> frozenset[str]:
    """The words of a text."""
    return frozenset(text.split())


JAX = Language(
    "jax",
    notation.JAX,
    margin=INDENT,
    escapes=(("\\", "\\\\"), ('"', r"\"")),
    reserved=frozenset({"jax", "jnp"}),
)

JULIA = Language(
    "julia",
    notation.JULIA,
    title=lambda name: name.title().replace("_", ""),
    escapes=(("\\", "\\\\"), ("$", r"\$"), ('"', r"\"")),
    reserved=words(
        "baremodule begin break catch const continue do else elseif end export false finally for function "
        "global if import in isa let local macro module quote return struct true try using while where "
        "im pi conj sin cos exp log sqrt"
    ),
)

C = Language(
    "c",
    notation.C,
    argument="rodwnl_number {}",
    result="rodwnl_number *{}",
    nothing="void",
    types=("rodwnl_number", "void"),
    local=("const rodwnl_number {} = ", ";"),
    output=("*{} = ", ";"),
    only=("return ", ";"),
    together="",
    escapes=(("*/", "* /"), ("/*", "/ *")),
    reserved=words(
        "auto break case char const continue default do double else enum extern float for goto if inline int "
        "long register restrict return short signed sizeof static struct switch typedef union unsigned void "
        "volatile while complex imaginary I conj sin cos exp log sqrt rodwnl_number rodwnl_power "
        # C23
        "alignas alignof bool constexpr false nullptr static_assert thread_local true typeof "
        # macros of tgmath.h and, as the file may be included behind any header, of the common ones
        "NAN INFINITY HUGE_VAL HUGE_VALF HUGE_VALL FP_NAN FP_INFINITE FP_ZERO FP_SUBNORMAL FP_NORMAL "
        "FP_ILOGB0 FP_ILOGBNAN FP_FAST_FMA FP_FAST_FMAF FP_FAST_FMAL MATH_ERRNO MATH_ERREXCEPT "
        "math_errhandling M_E M_LOG2E M_LOG10E M_LN2 M_LN10 M_PI M_PI_2 M_PI_4 M_1_PI M_2_PI M_2_SQRTPI "
        "M_SQRT2 M_SQRT1_2 NULL EOF BUFSIZ RAND_MAX EXIT_SUCCESS EXIT_FAILURE FILENAME_MAX FOPEN_MAX "
        "L_tmpnam TMP_MAX SEEK_CUR SEEK_END SEEK_SET MB_CUR_MAX errno EDOM ERANGE EILSEQ stdin stdout stderr "
        "assert offsetof linux unix TRUE FALSE"
    ),
)

MATHEMATICA = Language(
    "mathematica",
    notation.MATHEMATICA,
    title=notation.camel_case,
    argument="{}_",
    value="{}Value",
    local=("{} = ", ";"),
    output=("{} = ", ";"),
    only=("", ""),
    together="{{{}}}",
    escapes=(("\\", "\\\\"), ('"', r"\"")),
)
