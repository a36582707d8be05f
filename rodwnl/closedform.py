"""A rod at a threshold in closed form: mode, adjoint, second-order corrections, α and β; nothing discretised.

The emitted formulas run on sums of exponentials (rodwnl/fields.py), over whichever numbers are given:
mpmath's (rodwnl/exact.py) or balls that contain the truth (rodwnl/certified.py). Every integral is a finite
sum.

    Y = Σ c_j e^{r_j u},  k2 r⁴ + (μF − λ − k2γ3λ) r² + λ(μν + γ3λ) = 0,  λ = iω

Dimensionless throughout: lengths in L, times in γ2L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from rodwnl.fields import Exponents, Field, Key, Scalar, two_point
from rodwnl.parameters import PLAIN, RodParameters
from rodwnl.straightrod import StraightRod
from rodwnl.uniformrod import Numbers, uniform_rod


@dataclass(frozen=True)
class CriticalState:
    """A rod at a threshold, in one kind of number, and the exponents that occur there.

    exponents: generators r1, r2 (of the mode) and s, K1 s² = c, of X2. Calling it with the name of an emitted
    function evaluates that at λ = iω. by_g: whether α and β are split as g1…g4 split them, not by rows.
    """

    numbers: Numbers
    straight: StraightRod
    omega: Scalar
    exponents: Exponents
    by_g: bool = False

    def __call__(self, name: str, **fields: Any) -> Any:
        return self.straight(name, **{"lam": self.lam, **fields})

    @property
    def force(self) -> Scalar:
        return self.straight.force

    @property
    def lam(self) -> Scalar:
        """λ = iω."""
        return self.omega * 1j


@dataclass(frozen=True)
class Mode:
    """The critical mode, Y(1) = 1; `defect` is what remains of the second tip condition, not imposed."""

    Y: Field
    Theta: Field
    Theta_u: Field
    H: Field
    defect: Scalar

    def named(self) -> dict[str, Any]:
        """The fields and tip values by the names that emitted functions use."""
        fields = {"Y": self.Y, "Theta": self.Theta, "Theta_u": self.Theta_u, "H": self.H}
        return fields | {"Y_tip": self.Y.at_tip(), "Theta_tip": self.Theta.at_tip()}


@dataclass(frozen=True)
class Adjoint:
    """The adjoint mode, Ψ_Y(1) = 1; `defect` is what remains of the second tip condition."""

    Psi_Y: Field
    Psi_Theta: Field
    defect: Scalar

    def named(self) -> dict[str, Any]:
        """As `Mode.named`."""
        tips = {"Psi_Y_tip": self.Psi_Y.at_tip(), "Psi_Theta_tip": self.Psi_Theta.at_tip()}
        return {"Psi_Y": self.Psi_Y, "Psi_Theta": self.Psi_Theta, **tips}


@dataclass(frozen=True)
class Corrections:
    """Second-order axial displacement and tension: mean (0) and second harmonic (2)."""

    X0: Field
    X2: Field
    P0: Field
    P2: Field


@dataclass(frozen=True)
class Coefficients:
    """α, β of dA/dT = α|A|²A + βΔA and the residuals behind them, in one kind of number.

    alpha_parts, beta_parts: what the rows of y and θ contribute; of the plain rod what (g1, g3) and (g2, g4)
    do.
    """

    force: Scalar
    omega: Scalar
    alpha: Scalar
    beta: Scalar
    alpha_parts: tuple[Scalar, Scalar]
    beta_parts: tuple[Scalar, Scalar]
    residuals: dict[str, Scalar]


def critical_state(rod: RodParameters, force: Scalar, omega: Scalar, numbers: Numbers) -> CriticalState:
    """The rod's numbers and exponents at λ = iω; raises what `uniform_rod` raises.

    The two roots r² never coincide there: their discriminant (λ(K2wθ + K3wy) − μF)² − 4K2K3λwy(λwθ + μν) has
    the imaginary part −2ωμ(F(K2wθ + K3wy) + 2K2K3νwy) < 0.
    """
    straight = uniform_rod(rod, force, numbers)
    lam = omega * 1j
    axial = straight("X2_operator", lam=lam) / straight("stretch_stiffness")
    squares = (*squared_exponents(straight, lam, numbers), axial)
    exponents = Exponents([numbers.sqrt(z) for z in squares], numbers)
    return CriticalState(numbers, straight, omega, exponents, by_g=rod.model == PLAIN)


def squared_exponents(straight: StraightRod, lam: Scalar, numbers: Numbers) -> tuple[Scalar, Scalar]:
    """The two r² of the exponentials e^{ru} that solve the linear problem at this eigenvalue."""
    c4, c2, c0 = straight("exponent_polynomial", lam=lam)
    half, root = -c2 / (2 * c4), numbers.sqrt(c2 * c2 - 4 * c4 * c0) / (2 * c4)
    # the larger of half ± root loses nothing; the other one follows from r1² r2² = c0/c4
    larger = half + root if abs(half + root) > abs(half - root) else half - root
    return larger, c0 / (c4 * larger)


def critical_mode(state: CriticalState) -> Mode:
    """Y, Θ, H from the clamp, the first tip condition and Y(1) = 1; the second holds at a threshold."""
    keys = _mode_keys(state)
    c, defect = _amplitudes(state, keys, boundary_rows(state, "boundary_column", state.lam))
    Y, Theta, H = _mode_fields(state, keys, c, state.lam)
    return Mode(Y, Theta, Theta.derivative(), H, defect)


def adjoint_mode(state: CriticalState) -> Adjoint:
    """Ψ from the clamp, the first adjoint tip condition and Ψ_Y(1) = 1; eigenvalue λ*, exponents r*."""
    keys, lam = [state.exponents.conjugate(key) for key in _mode_keys(state)], state.lam.conjugate()
    c, defect = _amplitudes(state, keys, boundary_rows(state, "adjoint_boundary_column", lam, keys))
    Psi_Y, Psi_Theta, _ = _mode_fields(state, keys, c, lam)
    return Adjoint(Psi_Y, Psi_Theta, defect)


def _mode_keys(state: CriticalState) -> list[Key]:
    """The exponents ±r1, ±r2."""
    return [state.exponents.key(i, sign) for i in (0, 1) for sign in (1, -1)]


def boundary_rows(
    state: CriticalState, column: str, lam: Scalar, keys: list[Key] | None = None
) -> list[list[Scalar]]:
    """The four boundary conditions (rows) of the four exponentials (columns), from an emitted column."""
    columns = []
    for key in keys or _mode_keys(state):
        r = state.exponents.value(key)
        columns.append(state(column, r=r, exp_r=state.numbers.exp(r), lam=lam))
    return [list(row) for row in zip(*columns, strict=True)]


def _amplitudes(
    state: CriticalState, keys: list[Key], rows: list[list[Scalar]]
) -> tuple[list[Scalar], Scalar]:
    """c from the first three conditions and Σ c_j e^{r_j} = 1, and the fourth relative to its terms.

    The vector orthogonal to three rows has their minors as its components.
    """
    minors = [determinant([row[:j] + row[j + 1 :] for row in rows[:3]]) for j in range(4)]
    signed = [minor if j % 2 else -minor for j, minor in enumerate(minors)]
    tip = sum(x * state.numbers.exp(state.exponents.value(key)) for x, key in zip(signed, keys, strict=True))
    c = [x / tip for x in signed]
    terms = [a * x for a, x in zip(rows[3], c, strict=True)]
    return c, sum(terms) / max(abs(t) for t in terms)


def determinant(rows: list[list[Scalar]]) -> Scalar:
    """By expansion along the first row: small matrices, of entries whose sizes may differ by any factor."""
    if len(rows) == 1:
        return rows[0][0]
    minors = [determinant([row[:j] + row[j + 1 :] for row in rows[1:]]) for j in range(len(rows))]
    return sum(-a * m if j % 2 else a * m for j, (a, m) in enumerate(zip(rows[0], minors, strict=True)))


def _mode_fields(
    state: CriticalState, keys: list[Key], c: list[Scalar], lam: Scalar
) -> tuple[Field, Field, Field]:
    """Σ c_j (1, Θ/Y, H/Y)(r_j) e^{r_j u}."""
    Y: dict[Key, Scalar] = dict(zip(keys, c, strict=True))
    Theta, H = {}, {}
    for key in keys:
        by_Y = state("mode_amplitudes", r=state.exponents.value(key), lam=lam)
        Theta[key], H[key] = (Y[key] * ratio for ratio in by_Y)
    Y_field, Theta_field, H_field = (
        state.exponents.field({key: (x,) for key, x in terms.items()}) for terms in (Y, Theta, H)
    )
    return Y_field, Theta_field, H_field


def second_order(state: CriticalState, mode: Mode) -> Corrections:
    """X0, X2 and the tensions P0, P2: K1 X'' = c X + f, X(0) = 0, S X(1) + S_u X'(1) = S_u·slope.

    c belongs to the drag of X2, S to a load with drag at the tip.
    """
    given = mode.named()
    K1, found = state("stretch_stiffness"), {}
    for harmonic, root in ((0, state.exponents.zero), (2, state.exponents.key(2))):
        x = f"X{harmonic}"
        S, S_u = state("x_tip_row", lam=harmonic * state.lam)
        forcing = state.exponents.promoted(state(f"{x}_forcing", **given))
        found[x] = two_point(forcing / K1, root, state(f"{x}_tip_slope", **given), S / S_u)
        found[f"{x}_u"] = found[x].derivative()
    P0, P2 = (state(name, **given, **found) for name in ("P0", "P2"))
    return Corrections(found["X0"], found["X2"], P0, P2)


def coefficients(state: CriticalState) -> Coefficients:
    """α = (∫Ψ†(cubic rows) + tip)/(∫Ψ†Γ(Y, Θ) + tip), and β the same with the rows of the detuning.

    Where the load follows, α = ∫(Ψ_Y* g1 + Ψ_Θ* g3)/∫Ψ†Γ(Y, Θ) as well, and β with g2 and g4.
    """
    mode, adjoint = critical_mode(state), adjoint_mode(state)
    X = second_order(state, mode)
    given = mode.named() | adjoint.named() | vars(X)
    given["u"] = state.exponents.u(state.numbers.number(Fraction(1)))
    norm = _integral(state("norm_integrand", **given)) + state("norm_boundary", **given)
    parts, residuals = _by_rows(state, given), {"mode": abs(mode.defect), "adjoint": abs(adjoint.defect)}
    residuals |= _tension_defects(state, given)
    if hasattr(state.straight.functions, "g1"):
        transformed = _by_g(state, given)
        for name, one, other in zip(("alpha", "beta"), parts, transformed, strict=True):
            residuals[f"{name}_routes"] = abs(sum(one) / sum(other) - 1)
        parts = transformed if state.by_g else parts
    (a_y, a_theta), (b_y, b_theta) = ((y / norm, theta / norm) for y, theta in parts)
    alpha, beta = a_y + a_theta, b_y + b_theta
    return Coefficients(state.force, state.omega, alpha, beta, (a_y, a_theta), (b_y, b_theta), residuals)


Parts = list[tuple[Scalar, Scalar]]


def _by_rows(state: CriticalState, given: Mapping[str, Any]) -> Parts:
    """The numerators of α and of β, by the y and the θ row of the untransformed theory with its tip terms."""
    none = state.exponents.field({})
    only_y = {"Psi_Theta": none, "Psi_Theta_tip": none.at_tip()}
    only_theta = {"Psi_Y": none, "Psi_Y_tip": none.at_tip()}
    at_tip = {x: given[x].at_tip() for x in ("X0", "X2")}  # boundary terms take tip values by these names

    def part(name: str, only: Mapping[str, Any]) -> Scalar:
        bulk = state(f"{name}_untransformed", **{**given, **only})
        return _integral(bulk) + state(f"{name}_boundary", **{**given, **only, **at_tip})

    return [(part(name, only_y), part(name, only_theta)) for name in ("alpha", "beta")]


def _by_g(state: CriticalState, given: Mapping[str, Any]) -> Parts:
    """The same by g1 and g3, and by g2 and g4, the forcings of the transformed variables."""
    none = state.exponents.field({})
    g = {f"g{k}": state(f"g{k}", **given) for k in (1, 2, 3, 4)}

    def part(name: str, left_out: str) -> Scalar:
        return _integral(state(f"{name}_integrand", **{**given, **g, left_out: none}))

    return [(part("alpha", "g3"), part("alpha", "g1")), (part("beta", "g4"), part("beta", "g2"))]


def _integral(integrand: Field | Scalar) -> Scalar:
    """∫₀¹ du, also of a constant."""
    return integrand.integral() if isinstance(integrand, Field) else integrand


def _tension_defects(state: CriticalState, given: Mapping[str, Any]) -> dict[str, Scalar]:
    """The axial force balance P' = … in mid-rod, relative to P'. Of P0 only the real part has a meaning."""
    half = state.numbers.number(Fraction(1, 2))
    mean, harmonic = (state(f"{p}_slope", **given)(half) for p in ("P0", "P2"))
    return {
        "P0": abs(given["P0"].derivative()(half).real / mean.real - 1),
        "P2": abs(given["P2"].derivative()(half) / harmonic - 1),
    }
