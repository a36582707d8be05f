"""What the proofs rest on, checked for a rod: used for the plain one and for others."""

import mpmath as mp

from rodwnl.balls import BallNumbers, flint
from rodwnl.closedform import critical_mode, critical_state, determinant
from rodwnl.exact import MpNumbers, refine_threshold
from rodwnl.halfplane import characteristic
from rodwnl.linearrod import linear_rod
from rodwnl.uniformrod import uniform_rod


def assert_emitted_determinant(rod, force):
    """D of the proofs is the determinant of the emitted columns over their Wronskian, times a constant."""
    f = flint()
    here, straight = linear_rod(rod, f.arb(force)), uniform_rod(rod, f.acb(force), BallNumbers())
    ratios = []
    for lam in (5 + 7j, -3 + 200j, -0.1, 1e4 - 3j):
        lam = f.acb(lam)
        c4, c2, c0 = straight("exponent_polynomial", lam=lam)
        root = (c2 * c2 - 4 * c4 * c0).sqrt()
        z1, z2 = (root - c2) / (2 * c4), (-root - c2) / (2 * c4)
        r1, r2 = z1.sqrt(), z2.sqrt()
        columns = [straight("boundary_column", r=r, exp_r=r.exp(), lam=lam) for r in (r1, -r1, r2, -r2)]
        D = determinant([list(row) for row in zip(*columns, strict=True)])
        ratios.append(D * r1 * r2 / (lam * (z1 - z2) ** 2) / characteristic(here, lam).whole)
    for ratio in ratios:
        assert ratio.overlaps(ratios[0])
        assert abs(ratio - ratios[0]).abs_upper() < 1e-20 * abs(ratio)


def assert_energy_identity(rod, force, omega):
    """λ(wy‖Y‖² + wθ‖Θ‖² + G) = −‖Q‖²/K2 − K3‖Θ'‖² + F b‖Θ‖² + f Θ(1)Y*(1) + aθ|Θ(1)|², on a mode."""

    def number(ball):
        return mp.mpc(ball) if isinstance(ball, int) else mp.mpf(ball.real.str(30, radius=False))

    with mp.workdps(40):
        s = critical_state(rod, *refine_threshold(rod, mp.mpf(force), mp.mpf(omega)), MpNumbers())
        mode, here = critical_mode(s), linear_rod(rod, flint().arb(mp.nstr(s.force, 35)))
        K2, K3, mu, F, w_y, w_theta = (
            number(getattr(here, name)) for name in ("K2", "K3", "mu", "load", "w_y", "w_theta")
        )
        (yy, _), (_, tt) = here.by_rate
        ay, atheta, yy, tt = (number(b) for b in (*here.by_angle, yy, tt))
        Q = mode.Y.derivative() * K2 - mode.Theta * mu

        def square(f):
            return (f * f.conjugate()).integral()

        tip, work = mode.Theta.at_tip(), abs(mode.Theta.at_tip()) ** 2
        left = s.lam * (w_y * square(mode.Y) + w_theta * square(mode.Theta) - yy - tt * work)
        right = (
            -square(Q) / K2
            - K3 * square(mode.Theta_u)
            + F * mu / K2 * square(mode.Theta)
            + (ay - F) * tip
            + atheta * work
        )
        assert abs(left - right) < mp.mpf(10) ** -24 * abs(left)
