"""The exact route: identities of the theory, the paper's rows, coinciding exponents, honest digits."""

from dataclasses import replace
from itertools import pairwise

import mpmath as mp
import pytest

from rodwnl import kernels
from rodwnl.closedform import adjoint_mode, coefficients, critical_mode, critical_state, second_order
from rodwnl.errors import ComputationError, InputError
from rodwnl.exact import MpNumbers, characteristic, exact_threshold, refine_threshold
from rodwnl.fields import Exponents
from rodwnl.parameters import RodParameters

# (k1, k2, gamma3), the paper's force and frequency (tab:parameters), which serve as starts
ROWS = [
    (("1e4", "1e4", "1e-4"), 37.66, 191.21),
    (("1e4", "1e2", "1e-2"), 27.43, 113.55),
    (("200", "1e4", "1e-4"), 49.76, 334.32),
    (("200", "1e4", "1e-4"), 155.60, 3367.28),
]
BETA = ["7.35+5.36j", "6.93+4.13j", "6.60+9.16j", "-64.59+88.26j"]
POINTS = [mp.mpf(n) / 5 for n in range(6)]
TINY = mp.mpf(10) ** -32


@pytest.fixture(autouse=True)
def _forty_digits():
    with mp.workdps(40):
        yield


def state_at(parameters, force, omega):
    """The rod at any force and frequency: modes solve the equations there, if not all boundary conditions."""
    return critical_state(RodParameters(*parameters), mp.mpf(force), mp.mpf(omega), MpNumbers())


def threshold_state(parameters, force, omega):
    rod = RodParameters(*parameters)
    return critical_state(rod, *refine_threshold(rod, mp.mpf(force), mp.mpf(omega)), MpNumbers())


@pytest.fixture(params=ROWS, ids=["stiff", "soft", "lower", "upper"])
def at_threshold(request):
    return threshold_state(*request.param)


def test_modes_solve_their_equations(at_threshold):
    s, mode, adjoint = at_threshold, critical_mode(at_threshold), adjoint_mode(at_threshold)
    k2, gamma3 = (s.straight.values[name] for name in ("k2", "gamma3"))
    nu, mu = s("base_state")
    for lam, Y, Theta in (
        (s.lam, mode.Y, mode.Theta),
        (s.lam.conjugate(), adjoint.Psi_Y, adjoint.Psi_Theta),
    ):
        Y_u, Theta_u = Y.derivative(), Theta.derivative()
        shear = Y_u.derivative() * k2 - Theta_u * mu - Y * lam
        moment = Theta_u.derivative() + (Y_u - Theta * nu) * mu - Theta * (gamma3 * lam)
        for u in POINTS:
            assert abs(shear(u)) < TINY * k2 * 100
            assert abs(moment(u)) < TINY * k2 * 100
        assert abs(Y.at_start()) + abs(Theta.at_start()) < TINY * 100
    assert abs(mode.Y.at_tip() - 1) < TINY
    assert abs((mode.Y.derivative() - mode.Theta * nu - mode.H)(POINTS[2])) < TINY * 100
    assert abs(mode.H.at_tip()) + abs(mode.Theta_u.at_tip()) < TINY * 1000
    Psi_Y, Psi_Theta = adjoint.Psi_Y, adjoint.Psi_Theta
    assert abs(Psi_Y.derivative().at_tip() * k2 - mu * Psi_Theta.at_tip()) < TINY * k2
    assert abs(Psi_Theta.derivative().at_tip() + s.force * Psi_Y.at_tip()) < TINY * 1e4


def test_corrections_solve_their_boundary_value_problems(at_threshold):
    s, mode = at_threshold, critical_mode(at_threshold)
    X, k1 = second_order(s, mode), s("stretch_stiffness")
    f0, f2 = (s(f"{name}_forcing", **mode.named()) for name in ("X0", "X2"))
    X0 = X.X0.derivative().derivative() * k1 - f0
    X2 = X.X2.derivative().derivative() * k1 - X.X2 * s("X2_operator") - f2
    size = abs(f2(POINTS[2]))
    assert all(abs(X0(u)) + abs(X2(u)) < TINY * size for u in POINTS)
    for correction in (X.X0, X.X2):
        assert abs(correction.at_start()) < TINY * size
    assert abs(X.P0.at_tip()) + abs(X.P2.at_tip()) < TINY * size


def test_residuals_are_rounding_only(at_threshold):
    residuals = coefficients(at_threshold).residuals
    assert set(residuals) == {"mode", "adjoint", "P0", "P2", "alpha_routes", "beta_routes"}
    assert all(r < 1e-30 for r in residuals.values())


def test_residuals_show_a_force_that_is_no_threshold():
    residuals = coefficients(state_at(ROWS[0][0], 38, 191)).residuals
    assert residuals["mode"] > 1e-4
    assert residuals["adjoint"] > 1e-4


def test_beta_is_the_slope_of_the_eigenvalue(at_threshold):
    # D(λ, F) = 0 with λ = iω, ω complex: dλ/dF = −i D_F/D_ω
    s = at_threshold
    rod = RodParameters(*(str(mp.nstr(s.straight.values[n], 20)) for n in ("k1", "k2", "gamma3")))
    h = mp.mpf(10) ** -12
    D_force = characteristic(rod, s.force * (1 + h), s.omega) - characteristic(
        rod, s.force * (1 - h), s.omega
    )
    D_omega = characteristic(rod, s.force, s.omega * (1 + h)) - characteristic(
        rod, s.force, s.omega * (1 - h)
    )
    slope = -1j * (D_force / s.force) / (D_omega / s.omega)
    beta = coefficients(s).beta
    assert abs(slope / beta - 1) < 1e-20


@pytest.mark.parametrize(("row", "beta"), list(zip(ROWS, BETA, strict=True)))
def test_the_papers_rows(row, beta):
    found = exact_threshold(RodParameters(*row[0]), row[1], row[2], 20)
    beta = mp.mpmathify(complex(beta))
    assert abs(found.force - row[1]) <= 0.005
    assert abs(found.omega - row[2]) <= 0.005
    assert abs(found.beta.real - beta.real) <= 0.005
    assert abs(found.beta.imag - beta.imag) <= 0.005


def same(a, b, digits):
    return all(
        abs(getattr(a, n) - getattr(b, n)) < mp.mpf(10) ** -digits * abs(getattr(b, n))
        for n in ("force", "omega", "alpha", "beta", "A_tip2_slope", "omega_slope")
    )


def test_digits_stay_when_more_are_asked_for():
    rod = RodParameters(200, "1e4", "1e-4")
    few, many = (exact_threshold(rod, 49.76, 334.32, digits) for digits in (25, 60))
    assert few.agreement >= 27
    with mp.workdps(70):
        assert same(few, many, 25)
        assert not same(few, many, 65)


@pytest.mark.parametrize(
    ("parameters", "seed"),
    [
        (("1e8", "1e8", "1e-8"), (37.6954, 191.258)),  # the inextensible, unshearable limit
        (("1e8", "1e2", "1e-2"), (27.39, 113.2)),
        (("1e30", "1e30", "1e-30"), (37.695430840318579, 191.258635765253)),
        (("1e60", "1e60", "1e-60"), (37.695430840318579, 191.258635765253)),
    ],
)
def test_cancellation_in_stiff_rods_is_paid_for(parameters, seed):
    rod = RodParameters(*parameters)
    few, many = (exact_threshold(rod, *seed, digits) for digits in (15, 45))
    with mp.workdps(50):
        assert same(few, many, 15)
    assert few.agreement >= 17


def test_rods_stiffen_towards_the_inextensible_unshearable_filament():
    limit = mp.mpf("37.695430840318579"), mp.mpf("191.258635765253")
    gaps = []
    for k in (10**6, 10**7, 10**8):
        found = exact_threshold(RodParameters(k, k, f"1/{k}"), 37.69, 191.25, 18)
        gaps.append((abs(found.force - limit[0]), abs(found.omega - limit[1])))
    for coarse, fine in pairwise(gaps):  # first order: a gap is c/k + O(1/k²)
        assert all(abs(a / b - 10) < 0.01 for a, b in zip(coarse, fine, strict=True))


def both_sides(at, value, digits):
    """`at` is a function with a removable singularity: above, on it and below must be one smooth curve."""
    on = at(value)
    for gap in (mp.mpf(10) ** -3, mp.mpf(10) ** -6):
        above, below = at(value * (1 + gap)), at(value * (1 - gap))
        slope = abs(above - below) / (2 * gap)
        assert abs((above + below) / 2 - on) < 1e4 * gap**2 * abs(on)
        assert abs(above - on) < 3 * gap * slope + 1e4 * gap**2 * abs(on)
    near = at(value * (1 + mp.mpf(10) ** (-digits)))
    assert abs(near - on) < mp.mpf(10) ** (10 - digits) * abs(on)


def test_zero_exponent_in_the_mean_correction():
    # Im r1 = 0, so that |Θ|² contains e^{0u}: r² = μν/(1 + k2γ3) and γ3ω² = k2r⁴ + μFr²
    k1, k2, gamma3, force = (mp.mpf(p) for p in ("100", "10", "0.5", "8"))
    nu, mu = kernels.base_state(k1, k2, force)
    z = mu * nu / (1 + k2 * gamma3)
    omega = mp.sqrt((k2 * z**2 + mu * force * z) / gamma3)
    parameters = ("100", "10", "0.5")
    r1, r2 = (state_at(parameters, force, omega).exponents.basis[i] for i in (0, 2))
    assert min(abs(r1.imag), abs(r2.imag)) < TINY
    with mp.workdps(100):  # room for the digits that the near side loses
        both_sides(lambda w: coefficients(state_at(parameters, force, w)).alpha, omega, 20)


def test_resonance_in_the_second_harmonic():
    # (r1 + r2)² = 2iωγ1/k1: Re (r1 + r2)² = 0 fixes the force, then γ1 follows
    parameters, omega = ("100", "10", "0.5"), mp.mpf(20)

    def squared(force):
        r = state_at(parameters, force, omega).exponents.basis
        return max(((r[0] + sign * r[2]) ** 2 for sign in (1, -1)), key=lambda z: z.imag)

    with mp.workdps(100):
        force = mp.findroot(
            lambda F: squared(F).real, (mp.mpf("0.1"), mp.mpf(3)), solver="anderson", tol=1e-190
        )
        gamma1 = 100 * squared(force).imag / (2 * omega)
        assert gamma1 > 0

        def alpha(value):
            state = state_at(parameters, force, omega)
            r1, _, r2, *_ = state.exponents.basis
            straight = replace(state.straight, values={**state.straight.values, "gamma1": value})
            exponents = Exponents([r1, r2, mp.sqrt(2 * state.lam * value / 100)], MpNumbers())
            return coefficients(replace(state, straight=straight, exponents=exponents)).alpha

        both_sides(alpha, gamma1, 20)


@pytest.mark.parametrize("digits", [0, -3, 10**7, 2.5, "ten", None, True])
def test_digits_out_of_range_are_refused(digits):
    with pytest.raises(InputError, match="whole number from 1 to 10000"):
        exact_threshold(RodParameters(*ROWS[0][0]), 37.66, 191.21, digits)


def test_a_start_far_from_any_threshold_is_refused():
    with pytest.raises(ComputationError, match="no Hopf threshold near force"):
        exact_threshold(RodParameters(*ROWS[0][0]), 5.0, 1000.0)
