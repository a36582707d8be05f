"""Every symbol of the theory, made once: name in code, LaTeX, meaning.

A SymPy symbol with the same name but other assumptions is another symbol, so nothing outside this
module calls ``Symbol``. All symbols are plain (commutative, no assumptions): what is real and what is
complex is said by the conjugation of the ring they live in (:mod:`derivation.jets`).
"""

from __future__ import annotations

from functools import cache

from sympy import Symbol

#: Parameters and constants: name -> (LaTeX, meaning). Scaled by length L and time gamma2 L^4/k3.
PARAMETERS: dict[str, tuple[str, str]] = {
    "k1": (r"\tilde{k}_1", "stretch stiffness ratio"),
    "k2": (r"\tilde{k}_2", "shear stiffness ratio"),
    "gamma1": (r"\tilde{\gamma}_1", "translational drag ratio"),
    "gamma3": (r"\tilde{\gamma}_3", "rotational drag ratio"),
    "force": (r"\mathcal{F}", "follower force"),
    "nu": (r"\nu", "stretch of the compressed straight rod, 1 - force/k1"),
    "mu": (r"\mu", "k2 nu + force"),
    "Delta": (r"\Delta", "detuning, (force - critical force)/epsilon^2"),
    "omega": (r"\omega_c", "critical frequency"),
    "lam": (r"\lambda", "eigenvalue; i omega at the threshold"),
    "r": ("r", "exponent of a mode exp(r u)"),
    "exp_r": (r"\mathrm{e}^{r}", "exp(r), the exponential at the tip"),
    "u": ("u", "material coordinate, 0 at the clamp and 1 at the tip"),
}

#: Exact kinematic and mechanical quantities in which a model is written.
QUANTITIES: dict[str, tuple[str, str]] = {
    "h1": ("h_1", "axial strain"),
    "h2": ("h_2", "shear strain"),
    "Pi": (r"\Pi", "curvature"),
    "v1": ("v_1", "tangential velocity"),
    "v2": ("v_2", "normal velocity"),
    "Omega": (r"\Omega", "angular velocity"),
    "F1": ("F_1", "axial force"),
    "F2": ("F_2", "shear force"),
    "M": ("M", "bending moment"),
    "cos": (r"\cos\theta", "cosine of theta"),
    "sin": (r"\sin\theta", "sine of theta"),
}

#: The amplitude and what the Stuart-Landau equation adds.
AMPLITUDE: dict[str, tuple[str, str]] = {
    "A": ("A", "complex amplitude, a function of the slow time T"),
    "A_T": (r"\frac{\mathrm{d}A}{\mathrm{d}T}", "slow derivative of the amplitude"),
    "R": ("R", "modulus of A"),
    "R_T": (r"\frac{\mathrm{d}R}{\mathrm{d}T}", "slow derivative of R"),
    "phi_T": (r"\frac{\mathrm{d}\varphi}{\mathrm{d}T}", "slow derivative of the phase of A"),
    "alpha": (r"\alpha", "cubic Landau coefficient"),
    "beta": (r"\beta", "linear Landau coefficient"),
    "alpha_re": (r"\mathrm{Re}\,\alpha", "real part of alpha"),
    "alpha_im": (r"\mathrm{Im}\,\alpha", "imaginary part of alpha"),
    "beta_re": (r"\mathrm{Re}\,\beta", "real part of beta"),
    "beta_im": (r"\mathrm{Im}\,\beta", "imaginary part of beta"),
    "beta2_re": (r"\mathrm{Re}\,\beta_2", "real part of beta2 = c102, the coefficient of delta^2 A"),
    "beta2_im": (r"\mathrm{Im}\,\beta_2", "imaginary part of beta2 = c102"),
    "alpha1_re": (r"\mathrm{Re}\,\alpha'", "real part of alpha' = c211, the coefficient of delta |A|^2 A"),
    "alpha1_im": (r"\mathrm{Im}\,\alpha'", "imaginary part of alpha' = c211"),
    "alpha5_re": (r"\mathrm{Re}\,\alpha_5", "real part of alpha5 = c320, the coefficient of |A|^4 A"),
    "alpha5_im": (r"\mathrm{Im}\,\alpha_5", "imaginary part of alpha5 = c320"),
    "third_re": (r"\mathrm{Re}\,Y_{300}(1)", "real part of Y300(1), the tip's third harmonic"),
    "detuning": (r"(\mathcal{F}-\mathcal{F}_c)", "force minus critical force"),
}

#: Functions of u in the ansatz; ``_tip`` is the value at u = 1.
SHAPES: dict[str, tuple[str, str]] = {
    "Y": ("Y", "transverse shape of the critical mode, Y(1) = 1"),
    "Theta": (r"\Theta", "angle of the critical mode"),
    "H": ("H", "shear of the critical mode, Y' - nu Theta"),
    "X0": ("X_0", "mean longitudinal correction"),
    "X2": ("X_2", "second-harmonic longitudinal correction"),
    "P0": ("P_0", "mean tension correction"),
    "P2": ("P_2", "second-harmonic tension correction"),
    "Psi_Y": (r"\Psi_Y", "transverse part of the adjoint mode"),
    "Psi_Theta": (r"\Psi_\Theta", "angular part of the adjoint mode"),
}

#: Properties of the straight rod that a model need not give in closed form.
STRAIGHT: dict[str, tuple[str, str]] = {
    "K1": ("K_1", "stretch stiffness of the straight rod, d2W/dh1^2"),
    "K2": ("K_2", "shear stiffness of the straight rod, d2W/dh2^2"),
    "K3": ("K_3", "bending stiffness of the straight rod, d2W/dPi^2"),
    "load": ("P", "compression carried by the straight rod, a function of u under a distributed load"),
    "nu_inv": (r"\nu^{-1}", "1/nu"),
}

FIELDS: dict[str, str] = {"x": "x", "y": "y", "theta": r"\theta"}

BAR = "_bar"
TIP = "_tip"

_latex: dict[str, str] = {}


@cache
def symbol(name: str) -> Symbol:
    """The one symbol of that name."""
    return Symbol(name)


def register(name: str, latex: str) -> Symbol:
    """Make the symbol ``name`` and remember how it is typeset."""
    _latex[name] = latex
    return symbol(name)


def parameter(name: str, latex: str = "") -> Symbol:
    """A model's own parameter."""
    return register(name, latex or name)


def jet_name(field: str, order: int, u: int, tau: int = 0, slow: int = 0) -> str:
    """Name of a derivative of the order-``order`` field: ``theta1_uu``, ``y3_tau``, ``x1_T``."""
    suffix = "u" * u + "tau" * tau + "T" * slow
    return f"{field}{order}" + (f"_{suffix}" if suffix else "")


def jet_latex(field: str, order: int, u: int, tau: int = 0, slow: int = 0) -> str:
    r"""LaTeX of the same, as the paper writes it: ``\partial_u^{2} \theta^{(1)}``."""
    powers = [(r"\partial_u", u), (r"\partial_\tau", tau), (r"\partial_T", slow)]
    ops = [op if n == 1 else f"{op}^{{{n}}}" for op, n in powers if n]
    return " ".join([*ops, f"{FIELDS[field]}^{{({order})}}"])


def shape_latex(shape: str, u: int = 0, bar: bool = False, tip: bool = False) -> str:
    """LaTeX of a shape function, its u-derivative, conjugate, or tip value."""
    return SHAPES[shape][0] + "'" * u + ("^*" if bar else "") + ("(1)" if tip else "")


for _table in (PARAMETERS, QUANTITIES, AMPLITUDE, SHAPES, STRAIGHT):
    for _name, (_tex, _) in _table.items():
        register(_name, _tex)


def latex_names() -> dict[Symbol, str]:
    """Symbol -> LaTeX, for SymPy's LaTeX printer."""
    return {symbol(name): tex for name, tex in _latex.items()}


def latex_of(name: str) -> str:
    """How the symbol of that name is typeset."""
    return _latex.get(name, name)


def meaning(name: str) -> str:
    """What the symbol of that name stands for; empty when it is a derivative of another."""
    for table in (PARAMETERS, QUANTITIES, AMPLITUDE, SHAPES, STRAIGHT):
        if name in table:
            return table[name][1]
    return ""
