"""Backlash: play between what is measured and what rubs, opened where the torque changes sign."""

from collections.abc import Iterator, Sequence

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, values_of
from friction_audit.dynamics.transmission import MANY_SAMPLES, FarSide
from friction_audit.effects.excitation import reversals
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.terms.backlash import CONTACT_DAMPING_RATIO, TERM, plays
from friction_audit.effects.transmission import MOTION_BELOW_HZ, far_side_of, motions, no_inertia
from friction_audit.joint_log import Float

SPAN_SHARES = np.geomspace(3e-5, 0.02, 36)
"""Widths of the play as shares of the span of the motion: close to each other: they set when the flanks strike."""
CONTACTS_HZ = (22.0, 50.0)
"""Flanks that ring about as fast as a regression sees, and hard ones."""
FLANK_DAMPINGS = (CONTACT_DAMPING_RATIO, 0.5)
"""Flanks from which half of the speed bounces, and dead ones. What bounces strikes again at moments that noise of the
position shifts, and each one shifts the next."""
SOUGHT_TIMES = 1.8
"""A play that is fitted together with what is behind it is so many times narrower or wider at most."""
HIDDEN_SHARES = (1e-3, 0.08)
"""Widths of plays that may be hidden, as shares of the span of the motion."""
SOUGHT_CONTACTS_HZ = (15.0, 75.0)
SOUGHT_FLANKS = {"contact_hz": SOUGHT_CONTACTS_HZ, "flank_damping_ratio": (0.1, 0.7)}
"""That are fitted together with what is behind them: softer ones are a spring, harder ones look alike."""
PROFILED_CONTACTS_HZ = np.geomspace(*SOUGHT_CONTACTS_HZ, 11)
"""Tried for each width once the name is found: softer flanks strike as a wider play would."""
FAR_SHARES = (0.8, 0.6)
"""Of the inertia that is behind the play, where a rotor before it moves with the measured side, and its torque is
measured too."""
LEAST_SHARE, LARGEST_SHARE = 0.4, 1.6
"""All that the shape says is behind the play, as far as a fit that did not know of it can tell."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """All widths on both kinds of flanks, and on hard ones that a smooth motion strikes.

    On hard flanks every second width with less inertia behind it too, along a smooth motion every fourth.
    """
    span = float(np.ptp(data.q)) or 1.0
    hard = max(CONTACTS_HZ)
    calm = {"motion_below_hz": MOTION_BELOW_HZ, "flank_damping_ratio": max(FLANK_DAMPINGS)}
    kinds: tuple[dict[str, float], ...] = (
        *({"contact_hz": hz} for hz in CONTACTS_HZ),
        *(
            {"contact_hz": hard, "motion_below_hz": MOTION_BELOW_HZ, "flank_damping_ratio": damping}
            for damping in FLANK_DAMPINGS
        ),
    )
    widths = (SPAN_SHARES * span).tolist()
    return (
        *({"gap_rad": width, **kind} for kind in kinds for width in widths),
        *({"gap_rad": width, "contact_hz": hard, "far_share": share} for share in FAR_SHARES for width in widths[::2]),
        *({"gap_rad": width, "contact_hz": hard, **calm, "far_share": s} for s in FAR_SHARES for width in widths[::4]),
    )


def columns(data: JointData, baseline: Nominal, shape: Shape) -> Float:
    """What the play adds to the torque, along the motion as measured or below a frequency."""
    ((_, column),) = together(data, baseline, (shape,))
    return column


def together(data: JointData, baseline: Nominal, shapes: Sequence[Shape]) -> Iterator[tuple[int, Float]]:
    """The same for many plays."""
    yield from struck(data, [far_side_of(baseline)] * len(shapes), shapes)


def struck(data: JointData, far: Sequence[FarSide], shapes: Sequence[Shape]) -> Iterator[tuple[int, Float]]:
    """The same, each play with what is behind it."""
    numbers = np.array([(own.inertia_kg_m2, own.coulomb_nm, own.viscous_nms_per_rad) for own in far])
    for motion, places in motions(data, shapes):
        every = max(len(motion.t) // MANY_SAMPLES, 1)
        simple = np.stack([motion.ddq[::every], motion.direction[::every], motion.dq[::every]])
        usual = np.sqrt(np.mean((numbers[places] @ simple) ** 2, axis=1)).tolist()
        values = [values_of(TERM, shapes[place]) for place in places]
        for k, column in plays(motion, [far[place] for place in places], usual, values):
            yield places[k], column


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    return reversals(data, baseline) or no_inertia(baseline)


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(LEAST_SHARE <= factors[0] <= LARGEST_SHARE)


def sought(_data: JointData, shape: Shape) -> dict[str, tuple[float, float]]:
    """From where to where a play is looked for together with what is behind it."""
    width = shape["gap_rad"]
    return {"gap_rad": (width / SOUGHT_TIMES, width * SOUGHT_TIMES), **SOUGHT_FLANKS}


def hidden(data: JointData) -> dict[str, tuple[float, float]]:
    """From where to where plays are looked for that hide most of the inertia, and so themselves from the grid."""
    least, most = HIDDEN_SHARES
    span = float(np.ptp(data.q)) or 1.0
    return {"gap_rad": (least * span, most * span), **SOUGHT_FLANKS}


def flank_twist(baseline: Nominal, shape: Shape) -> float:
    """By how much one flank gives way under friction: its law is unknown, so that much more or less is play. [rad]"""
    stiffness = baseline.inertia_kg_m2 * (2.0 * np.pi * shape["contact_hz"]) ** 2
    return float(abs(baseline.coulomb_nm) / stiffness) if stiffness > 0.0 else 0.0


def lost_in_flanks(baseline: Nominal, shape: Shape) -> float:
    """Motion that both flanks take by giving way, and that a play may be told too wide or too narrow by. [rad]"""
    return 2.0 * flank_twist(baseline, shape)


CANDIDATE = Candidate(
    name="backlash",
    label="free play at a reversal",
    shapes=shapes,
    columns=columns,
    together=together,
    column_units=("1",),
    untestable=untestable,
    admissible=admissible,
    axis="displacement",
    term=TERM,
    leans_on_model=True,
    rugged="gap_rad",
    beside_rugged=tuple({"contact_hz": float(hz)} for hz in PROFILED_CONTACTS_HZ),
    blur=lost_in_flanks,
    behind=struck,
    sought=sought,
    hidden=hidden,
)
