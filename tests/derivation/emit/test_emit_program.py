"""What is emitted equals its expression on every number type; everything else is refused."""

from __future__ import annotations

from fractions import Fraction

import flint
import mpmath
import numpy as np
import pytest
import sympy

from derivation.emit.lower import EmissionError
from derivation.emit.nodes import evaluate
from derivation.emit.printers import python
from derivation.emit.printers.notation import PYTHON, expression
from derivation.emit.program import Argument, Function, Module, compile_function

Y, Yc, X, Xc, a, b, s = sympy.symbols("Y Y_bar X X_bar a b s")

ARGUMENTS = (
    Argument("Y", Y, "a field"),
    Argument("X", X, "another field"),
    Argument("a", a, "a constant", "(..., 1)", parameter=True),
    Argument("b", b, "another constant", "(..., 1)", parameter=True),
)

FORMULAS = {
    "polynomial": 3 * Y**2 * Yc - X * Y / 6 + 5 * Y / 6 - 7,
    "powers": Y**3 + Y**4 * X + Yc**5 - (Y + X) ** 3,
    "quotients": (Y - X) / (a * b**2) - Y / (6 * a) + X / (a - b) / 7 - 1 / b,
    "half_added": (Y + sympy.Rational(1, 2)) * X - sympy.Rational(2, 3) + Y / 5,
    "real_part": X * (Y + Yc) / 2 - Xc * (Y - Yc) / 2,
    "shared": (1 - a / b) * Y + (1 - a / b) * X * Yc + (1 - a / b) ** 2,
    "negative": -Y - X / 2,
    "negative_factors": -a * (-Y - X / 2) * (-Yc - b) - b * (-Xc - Y),
    "imaginary": sympy.I * Y * a / 3 - 2 * sympy.I,
    "conjugates": sympy.conjugate(Y * X) * a + sympy.conjugate(Y * X) ** 2,
}


def make(*outputs: tuple[str, sympy.Expr], namespace: bool = False, arguments=ARGUMENTS) -> Function:
    return Function("f", "A formula.", ("eq:f",), arguments, outputs, ((Yc, Y), (Xc, X)), namespace)


def run(function: Function, *values: object) -> object:
    """The emitted source, executed on these values of its arguments, by name of the argument."""
    scope: dict[str, object] = {}
    exec(python.module(Module("m", "A module.", (function,)), "toy"), scope)
    given = dict(zip(("Y", "X", "a", "b"), values, strict=True))
    needed = [argument.name for argument in compile_function(function).arguments]
    return scope["f"](*(given[name] for name in needed))  # type: ignore[operator]


def exact(expr: sympy.Expr, *values: complex | int) -> sympy.Expr:
    """The same by SymPy, at Gaussian rationals: an arbiter that shares no code with the emission."""
    Yv, Xv, av, bv = (sympy.sympify(value) for value in values)
    substituted = expr.xreplace(
        {Yc: sympy.conjugate(Yv), Xc: sympy.conjugate(Xv), Y: Yv, X: Xv, a: av, b: bv}
    )
    return sympy.expand(substituted.doit(), complex=True)


GAUSSIAN = (
    sympy.Rational(2, 3) + sympy.I / 7,
    sympy.Rational(-5, 4) + 2 * sympy.I,
    sympy.Rational(3, 2),
    sympy.Integer(-7),
)


@pytest.mark.parametrize("name", FORMULAS)
def test_balls_hold_the_exact_value(name):
    """A ball of radius below 1e-50 holds the value: no literal has been rounded on the way."""
    with flint.ctx.workdps(60):
        balls = [ball(value) for value in GAUSSIAN]
        result = flint.acb(run(make(("f", FORMULAS[name])), *balls))
        wanted = exact(FORMULAS[name], *GAUSSIAN)
        assert result.overlaps(ball(wanted))
        assert float(result.real.rad()) < 1e-50
        assert float(result.imag.rad()) < 1e-50


def ball(value: sympy.Expr) -> flint.acb:
    real, imag = value.as_real_imag()
    return flint.acb(*(flint.arb(flint.fmpq(int(part.p), int(part.q))) for part in (real, imag)))


@pytest.mark.parametrize("name", FORMULAS)
def test_mpmath_to_its_working_precision(name):
    with mpmath.workdps(40):
        numbers = [mpmath.mpmathify(sympy.N(value, 45)) for value in GAUSSIAN]
        result = run(make(("f", FORMULAS[name])), *numbers)
        wanted = mpmath.mpmathify(sympy.N(exact(FORMULAS[name], *GAUSSIAN), 45))
        assert mpmath.almosteq(result, wanted, 1e-37)


@pytest.mark.parametrize("name", FORMULAS)
def test_numpy_broadcasts_rods_against_nodes(name):
    random = np.random.default_rng(1)
    Yv, Xv = random.normal(size=(2, 3, 5)) + 1j * random.normal(size=(2, 3, 5))
    av, bv = random.normal(size=(2, 3, 1))
    result = np.broadcast_to(run(make(("f", FORMULAS[name])), Yv, Xv, av, bv), (3, 5))
    for rod, node in np.ndindex(3, 5):
        scalars = Yv[rod, node], Xv[rod, node], av[rod, 0], bv[rod, 0]
        wanted = complex(exact(FORMULAS[name], *map(complex, scalars)))
        assert result[rod, node] == pytest.approx(wanted, rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("name", [name for name in FORMULAS if name != "imaginary"])
def test_fractions_stay_exact(name):
    rationals = (sympy.Rational(2, 3), sympy.Rational(-5, 4), sympy.Rational(3, 2), sympy.Integer(-7))
    result = run(make(("f", FORMULAS[name])), *(Fraction(int(v.p), int(v.q)) for v in rationals))
    wanted = exact(FORMULAS[name], *rationals)
    assert result == Fraction(int(wanted.p), int(wanted.q))


@pytest.mark.parametrize("name", FORMULAS)
def test_the_record_means_what_its_source_does(name):
    program = compile_function(make(("f", FORMULAS[name])))
    values: dict[str, object] = {"Y": 2 + 1j, "X": -1 + 3j, "a": 1.5, "b": -0.25}
    for local, node in (*program.locals, *program.outputs):
        values[local] = evaluate(node, values)
    assert values["f"] == run(make(("f", FORMULAS[name])), 2 + 1j, -1 + 3j, 1.5, -0.25)


@pytest.mark.parametrize(("xp", "number"), [(np, np.linspace(0.1, 1, 4)), (mpmath.mp, mpmath.mpf("0.3"))])
def test_functions_come_from_the_namespace(xp, number):
    expr = sympy.sin(s) * X + sympy.cos(2 * s) / sympy.sqrt(s) - sympy.exp(-s) + s ** sympy.Rational(3, 2)
    expr += s ** sympy.Rational(3, 10) / s**X
    arguments = (Argument("s", s, "an angle"), Argument("X", X, "a field"))
    program = python.function(compile_function(make(("f", expr), namespace=True, arguments=arguments)))
    scope: dict[str, object] = {}
    exec(program, scope)
    wanted = (
        xp.sin(number) * 2 + xp.cos(2 * number) / xp.sqrt(number) - xp.exp(-number) + xp.sqrt(number) ** 3
    ) + xp.exp(xp.log(number) * -17 / 10)
    np.testing.assert_allclose(np.array(scope["f"](xp, number, 2) - wanted, float), 0, atol=1e-14)  # type: ignore


def test_anatomy_of_a_function():
    text = python.function(compile_function(make(("p", (1 - a / b) * Yc), ("q", (1 - a / b) * Y**3 / 6))))
    assert (
        text
        == '''\
def f(Y, X, a, b):
    """A formula.

    Y (..., nodes): a field
    X (..., nodes): another field
    a (..., 1): a constant
    b (..., 1): another constant
    Returns p, q.
    Paper: eq:f.
    Operations: 1 addition, 4 multiplications, 2 divisions, 1 conjugation.
    """
    Y_bar = Y.conjugate()
    t0 = 1 - a/b
    p = Y_bar*t0
    q = t0*Y**2*Y/6
    return p, q
'''
    )


def test_the_sign_of_an_all_negative_sum_stands_before_its_product():
    program = compile_function(make(("p", a * (-Y - X)), ("q", (-Y - X * a) * (-1 - b) / 3)))
    assert [expression(node, PYTHON) for _, node in program.outputs] == ["-a*(X + Y)", "(1 + b)*(Y + X*a)/3"]


def test_only_needed_parameters_and_conjugates_appear():
    text = python.function(compile_function(make(("p", Y * b))))
    assert text.startswith("def f(Y, X, b):")
    assert "conjugate()" not in text


def test_long_statements_fit_the_line_and_keep_their_value():
    long = sum((-1) ** n * n * Y**n * X ** (n % 3) * a for n in range(1, 30))
    function = make(("p", long), ("q", Yc))
    assert max(map(len, python.function(compile_function(function)).splitlines())) <= python.WIDTH
    p, _ = run(function, Fraction(1, 2), Fraction(1, 3), Fraction(1), Fraction(0))
    wanted = exact(long, sympy.Rational(1, 2), sympy.Rational(1, 3), 1, 0)
    assert p == Fraction(int(wanted.p), int(wanted.q))


@pytest.mark.parametrize(
    ("expr", "message"),
    [
        (
            Y + sympy.Symbol("P0") * sympy.Symbol("gamma9"),
            r"f: P0, gamma9 not among its arguments \(Y, X, a, b\)",
        ),
        (Y * 2.5, "2.5.* cannot be written as code: it may hold names, whole numbers"),
        (Y * sympy.pi, "pi cannot be written as code"),
        (Y**X, "exp, log needs namespace=True"),
        (Y ** sympy.Rational(1, 3), "exp, log needs namespace=True"),
        (sympy.sqrt(Y), "sqrt needs namespace=True"),
        (sympy.sin(Y) + sympy.cos(Y), "cos, sin needs namespace=True"),
        (sympy.re(Y), r"re\(Y\) cannot be written"),
        (sympy.Abs(Y), r"Abs\(Y\) cannot be written"),
        (sympy.Function("g")(Y), r"g\(Y\) cannot be written"),
        (sympy.Derivative(sympy.Function("g")(Y), Y), "cannot be written"),
        (sympy.Rational(1, 3), "the bare constant 1/3 would be rounded"),
        (Y + sympy.I / 3, r"the bare constant I/3 would be rounded"),
    ],
)
def test_refused_expressions(expr, message):
    with pytest.raises(EmissionError, match=message):
        compile_function(make(("p", expr)))


@pytest.mark.parametrize(
    ("name", "message"),
    [("Y", "'Y' is defined twice"), ("lambda", "'lambda' is not a name"), ("p;import os", "is not a name")],
)
def test_refused_names(name, message):
    with pytest.raises(EmissionError, match=message):
        compile_function(make((name, Y)))


@pytest.mark.parametrize(
    "constant",
    [
        sympy.Rational(3, 2),
        sympy.Rational(-1, 7),
        sympy.I / 3,
        sympy.I + sympy.Rational(1, 3),
        sympy.sqrt(2) / 3 - sympy.Rational(2, 3),
        sympy.exp(sympy.Rational(1, 3)),
    ],
)
def test_a_bare_constant_takes_its_type_from_an_argument(constant):
    """The last digit of 40 is right, where a quotient of two literals would have 17."""
    k = sympy.Symbol("k")
    arguments = (Argument("k", k, "a number", parameter=True, carrier=True), *ARGUMENTS)
    function = make(("p", constant), ("q", 2 * Y), namespace=True, arguments=arguments)
    assert [argument.name for argument in compile_function(function).arguments] == ["k", "Y", "X"]
    scope: dict[str, object] = {}
    exec(python.module(Module("m", "A module.", (function,)), "toy"), scope)
    with mpmath.workdps(45):
        value = scope["f"](mpmath.mp, mpmath.mpf(200), 1, 1)[0]  # type: ignore[operator]
        assert abs(value - mpmath.mpmathify(sympy.N(constant, 50))) < mpmath.mpf(10) ** -40
    assert scope["f"](np, 200.0, 1, 1)[0] == pytest.approx(complex(constant), rel=1e-15)  # type: ignore[operator]


def test_locals_avoid_declared_names():
    t0 = sympy.Symbol("t0")
    arguments = (
        Argument("t0", t0, "named like a local"),
        Argument("Y", Y, "a field"),
    )
    program = compile_function(make(("t1", (t0 + Y) ** 2 * (t0 + Y) * Y), ("q", t0 + Y), arguments=arguments))
    names = [name for name, _ in program.locals] + ["t0", "t1", "q", "Y"]
    assert len(set(names)) == len(names) > 4


def test_docstrings_cannot_break_out():
    harmless = make(("p", Y))
    for doc in ('"""\nimport os', "a\\"):
        with pytest.raises(EmissionError, match="docstring"):
            python.module(Module("m", doc, (harmless,)), "toy")
