"""The motion that would tell apart what a log does not."""

from collections.abc import Sequence

PAIRS: tuple[tuple[str, str, str], ...] = (
    # friction over speed
    (
        "stribeck",
        "nonlinear_viscous",
        "move steadily at speeds that differ by a factor of 8 and more, very slow to fast",
    ),
    (
        "stribeck",
        "presliding",
        "reverse slowly and fast at the same places: presliding goes by the path, not the speed",
    ),
    ("stribeck", "stiction", "start slowly and go on slowly for some seconds: stiction is over once the joint moves"),
    ("stribeck", "frictional_lag", "move slowly at constant speed: without acceleration there is no lag"),
    ("stribeck", "unlogged_compensation", "log the commanded torque, or record again without compensation"),
    ("stribeck", "torque_ripple", "pass slowly and steadily over five periods of the ripple in both directions"),
    (
        "stiction",
        "presliding",
        "start after rests from 0.1 to 10 s and reverse without any: only stiction needs the rest",
    ),
    ("stiction", "contact_event", "start 15 times after a rest: stiction comes at every start, a contact does not"),
    ("stiction", "backlash", "start again in the same direction after a rest: without a reversal no gap opens"),
    (
        "asymmetric_coulomb",
        "torque_bias",
        "let the joint rest unloaded for 2 s: a bias is read at rest too, friction is not",
    ),
    ("asymmetric_coulomb", "gravity_error", "move through at least 1.5 rad both ways, with rests at several places"),
    ("asymmetric_coulomb", "asymmetric_viscous", "pass the same places slowly and fast in both directions"),
    ("asymmetric_viscous", "torque_bias", "pass the same places slowly and fast in both directions"),
    ("asymmetric_viscous", "gravity_error", "pass every place slowly and fast in both directions"),
    ("presliding", "backlash", "reverse slowly with hardly any load: a gap gives no torque at all, then an impact"),
    (
        "presliding",
        "frictional_lag",
        "reverse at different accelerations: presliding goes by the path, a lag by the time",
    ),
    (
        "presliding",
        "time_delay",
        "reverse at different accelerations: presliding goes by the path, a delay by the time",
    ),
    ("presliding", "joint_elasticity", "reverse fast and slowly: a spring rings after a fast reversal"),
    ("nonlinear_viscous", "time_delay", "repeat strokes of equal speed with different accelerations"),
    ("nonlinear_viscous", "warm_up", "repeat the same slow and fast strokes early and late"),
    ("nonlinear_viscous", "unlogged_compensation", "log the commanded torque, or record again without compensation"),
    ("frictional_lag", "time_delay", "repeat strokes of equal speed with different accelerations, and carry a load"),
    # load and place
    ("load_dependent_friction", "position_dependent_friction", "pass the same places with another payload or posture"),
    (
        "load_dependent_friction",
        "asymmetric_coulomb",
        "let the motor and a hand drive the joint, each in both directions",
    ),
    ("load_dependent_friction", "torque_crosstalk", "move one joint at a time, in both directions"),
    ("position_dependent_friction", "torque_ripple", "pass every place four times in each direction"),
    ("position_dependent_friction", "gravity_error", "pass every place four times in each direction"),
    (
        "torque_ripple",
        "joint_elasticity",
        "repeat slow, steady strokes at two speeds: a ripple's frequency goes with speed",
    ),
    ("gravity_error", "torque_bias", "move through at least 1.5 rad, with rests at several places"),
    (
        "gravity_error",
        "cable_spring",
        "move through at least 1.5 rad: gravity is a sine of the position, a spring a line",
    ),
    ("gravity_error", "inertia_error", "move at two frequencies: on one sinusoid gravity and inertia are the same"),
    ("gravity_error", "joint_limit_stop", "move through all of the range: a stop is there at its ends only"),
    ("gravity_error", "inertial_coupling", "hold several poses at rest: coupling needs acceleration, gravity does not"),
    ("gravity_error", "torque_crosstalk", "push against a neighbour while the arm rests: gravity stays the same"),
    ("gravity_error", "friction_step", "rest at the same place before and after the change, and move both ways"),
    ("cable_spring", "joint_limit_stop", "move through all of the range: a stop is there at its ends only"),
    ("cable_spring", "torque_bias", "rest at both ends of the range: a bias is the same there"),
    ("cable_spring", "inertia_error", "move at two frequencies: on one sinusoid a spring and inertia are the same"),
    ("joint_limit_stop", "contact_event", "go to the same place again: a stop is still there"),
    # sensors
    (
        "torque_bias",
        "torque_drift",
        "zero the sensor and let the joint rest unloaded for 2 s early and late: a drift comes back",
    ),
    (
        "asymmetric_coulomb",
        "torque_drift",
        "let the joint rest unloaded for 2 s early and late: a drift is read at rest too, friction is not",
    ),
    ("torque_drift", "warm_up", "pass the same places in both directions early and late, with rests"),
    (
        "torque_drift",
        "friction_step",
        "pass the same places in both directions before and after the change, with rests",
    ),
    ("time_delay", "joint_elasticity", "reverse sharply, slowly and fast: a spring rings, a delay shifts"),
    ("torque_crosstalk", "inertial_coupling", "move one joint at a time, then push against a neighbour at rest"),
    # structure
    (
        "joint_elasticity",
        "backlash",
        "reverse slowly with hardly any load: a gap gives no torque at all, a spring does",
    ),
    (
        "joint_elasticity",
        "inertia_error",
        "repeat the strokes slowly and fast: what a spring adds grows with frequency",
    ),
    ("backlash", "contact_event", "reverse again at the same places: a gap opens at every reversal"),
    ("inertia_error", "inertial_coupling", "move one joint at a time"),
    # slow changes and events
    ("warm_up", "friction_step", "record on for one and a half times as long: warming slows down, a step is over"),
    ("warm_up", "unlogged_compensation", "log the commanded torque, and repeat the same strokes early and late"),
    ("friction_step", "contact_event", "record at least 4 cycles before and after the moment: a contact passes"),
)
"""Two effects that are easily confused and what to record to tell them apart; the order of the two means nothing."""

MOTIONS: dict[str, str] = {
    "stribeck": "move steadily at speeds that differ by a factor of 8, very slow to fast",
    "stiction": "start slowly at least 15 times after rests from 0.1 to 10 s",
    "nonlinear_viscous": "move at speeds that differ by a factor of 5 and more",
    "asymmetric_coulomb": "pass the same places in both directions, with rests",
    "asymmetric_viscous": "pass the same places slowly and fast in both directions",
    "presliding": "reverse at least 20 times, over short and long ways",
    "frictional_lag": "repeat strokes of equal speed with different accelerations",
    "load_dependent_friction": "pass the same places with loads that differ by a factor of 3",
    "position_dependent_friction": "pass every place four times in each direction",
    "torque_ripple": "pass slowly and steadily over five periods of the ripple",
    "gravity_error": "move through at least 1.5 rad, with rests at several places",
    "cable_spring": "move through all of the range",
    "joint_limit_stop": "move through all of the range",
    "torque_bias": "let the joint rest unloaded for 2 s",
    "torque_drift": "let the joint rest unloaded for 2 s early and late",
    "time_delay": "reverse sharply at two or more clearly different speeds",
    "torque_crosstalk": "push against a neighbour while the arm rests",
    "joint_elasticity": "repeat the strokes at two or more clearly different speeds",
    "backlash": "reverse slowly at least 20 times with hardly any load",
    "inertia_error": "repeat the strokes at two or more clearly different speeds",
    "inertial_coupling": "move the neighbours one at a time, also while this joint rests",
    "warm_up": "record from a cold start, slow and fast strokes early and late",
    "friction_step": "record at least 4 cycles before and after the change",
    "contact_event": "record again with nobody and nothing near the arm",
    "unlogged_compensation": "log the commanded torque",
}
"""The motion on which an effect shows itself best: what its gate asks for, and what sets it apart."""


def motion_to_decide(name: str, alternatives: Sequence[str]) -> str:
    """Say what to record to tell an effect from its alternatives; empty without any.

    Args:
        name: The effect.
        alternatives: Names that a log does not tell apart from it, the most likely first.

    Returns:
        One motion, or one for each alternative with its name in front.
    """
    motions = {other: motion_between(name, other) for other in alternatives}
    if len(set(motions.values())) <= 1:
        return next(iter(motions.values()), "")
    return "; ".join(f"against {other}: {motion}" for other, motion in motions.items())


def motion_between(one: str, other: str) -> str:
    """Return what to record to tell two effects apart; of a pair that nobody confuses, the motions of both."""
    for first, second, motion in PAIRS:
        if {first, second} == {one, other}:
            return motion
    return "; ".join(dict.fromkeys([MOTIONS[one], MOTIONS[other]]))
