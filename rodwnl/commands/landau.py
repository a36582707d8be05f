"""`rodwnl landau`: the amplitude equation at every threshold."""

from rodwnl.errors import InputError
from rodwnl.options import (
    Certified,
    Convention,
    Digits,
    Json,
    MaxForce,
    Mesh,
    NoEscalate,
    Order,
    read_convention,
    read_digits,
    read_max_force,
    takes_rod,
)
from rodwnl.order_report import (
    equations,
    order_entry,
    print_order,
    print_pitchforks,
    read_order,
    with_pitchforks,
)
from rodwnl.output import print_json, print_table
from rodwnl.parameters import PLAIN, RodParameters
from rodwnl.report import cell, document, heading, landau_entry, sentences


@takes_rod
def command(
    rod: RodParameters,
    max_force: MaxForce = None,
    json: Json = False,
    digits: Digits = None,
    certified: Certified = False,
    convention: Convention = None,
    mesh: Mesh = None,
    no_escalate: NoEscalate = False,
    order: Order = 3,
) -> None:
    """Landau coefficients at every threshold: dA/dt = alpha |A|² A + beta (F - F_c) A.

    The tip moves by 2 |A|. Independent of how the mode is normalised are beta, the criticality, and the
    slopes of A_tip² and omega in the force along the branch of oscillations.
    """
    dialect = read_convention(convention, mesh)
    fifth = read_order(order) == 5
    if fifth and (certified or dialect):
        raise InputError("--order 5 goes with neither --certified nor --convention, which are cubic")
    if digits is not None or certified or dialect:
        from rodwnl.precise import NUMBERS_OF_LANDAU, print_precise

        print_precise(
            rod, read_max_force(rod, max_force), read_digits(digits), NUMBERS_OF_LANDAU,
            certified=certified, json=json, dialect=dialect, fifth=fifth,
        )  # fmt: skip
        return
    from rodwnl.coefficients import DOUBLE, ENOUGH, landau

    found = landau(rod, read_max_force(rod, max_force), escalate=not no_escalate)
    beyond = equations(rod, [c.threshold for c in found]) if fifth else []
    if json:
        entries = [landau_entry(c, plain=rod.model == PLAIN) for c in found]
        for entry, equation in zip(entries, beyond, strict=False):
            entry |= order_entry(equation)
        print_json(with_pitchforks(document(found.search, entries), found.search, fifth))
        return
    print("\n".join(sentences(found.search)))
    print_pitchforks(found.search, fifth)
    if not found.thresholds:
        return
    values: dict[str, list[tuple[complex, float]]] = {
        "force": [(c.force, c.threshold.force_error) for c in found],
        "omega": [(c.omega, c.threshold.omega_error) for c in found],
        "alpha": [(c.alpha, c.alpha_error) for c in found],
        "beta": [(c.beta, c.beta_error) for c in found],
        "A_tip2_slope": [(c.A_tip2_slope, c.A_tip2_slope_error) for c in found],
        "omega_slope": [(c.omega_slope, c.omega_slope_error) for c in found],
    }
    print_table(
        ["threshold", *(str(i + 1) for i in range(len(found)))],
        [
            ["crossing", *(c.crossing for c in found)],
            ["criticality", *(c.criticality for c in found)],
            *([heading(rod, name), *(cell(rod, name, *v) for v in row)] for name, row in values.items()),
            ["largest residual", *(f"{max(c.residuals.values()):.0e}" for c in found)],
        ],
    )
    for i, c in enumerate(found, 1):
        if c.working_digits > DOUBLE:
            used = f"{c.working_digits} working digits were used"
            print(f"Threshold {i}: double precision does not give {ENOUGH} digits; {used}.")
        elif c.digits < ENOUGH:
            print(f"Threshold {i}: only {max(c.digits, 0):.0f} digits hold in the worst of these numbers.")
    if beyond:
        print_order(rod, beyond)
