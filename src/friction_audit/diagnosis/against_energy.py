"""Where the energy method and the regression of the torque disagree, and what that may mean.

Both see the same friction in another way: energy sums up whole cycles, the regression weighs single samples. What the
declared model misses enters the two differently, so that their disagreement is news of its own.
"""

from collections.abc import Mapping

from friction_audit.friction.history import Coefficient


def differences_from_energy(
    declared: Mapping[str, Coefficient], from_energy: Mapping[str, Coefficient]
) -> tuple[str, ...]:
    """Name what it may mean that the intervals of the two do not meet.

    Args:
        declared: Factors of the declared model from the torque, by name.
        from_energy: Coefficients of the energy method, by the same names.

    Returns:
        One sentence for each coefficient that both give and that differs.
    """
    found = []
    for name, say in (("viscous_nms_per_rad", _viscous), ("coulomb_nm", _coulomb)):
        if name in declared and name in from_energy and _apart(from_energy[name], declared[name]):
            found.append(say(from_energy[name].value, declared[name].value))
    return tuple(found)


def _viscous(energy: float, torque: float) -> str:
    meaning = (
        "a delay between velocity and torque, or a viscous friction that is not linear"
        if energy > torque
        else "a friction that is larger at low speed, or energy that goes to other joints"
    )
    return f"viscous friction {energy:.3g} N m s/rad from energy, {torque:.3g} from torque: {meaning}"


def _coulomb(energy: float, torque: float) -> str:
    return (
        f"Coulomb friction {energy:.3g} N m from energy, {torque:.3g} from torque: "
        "an offset of the torque, an error of gravity, or energy that goes to other joints"
    )


def _apart(one: Coefficient, other: Coefficient) -> bool:
    """Whether two intervals do not meet; never where one of them is not known."""
    return one.low > other.high or one.high < other.low
