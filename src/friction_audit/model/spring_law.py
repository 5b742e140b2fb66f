"""Torque of a spring that is softest without torque: its stiffness grows evenly with the twist, from half to whole.

Strain-wave gears are soft at first (T. D. Tuttle, W. P. Seering, IEEE Trans. Robot. Autom. 12, 1996); makers state
three stiffnesses that grow with the torque, and no gear knows the corners between them. With s = K e of the twist e,

    T = s (1/2 + |s| / (4 b))  up to |s| = b,  beyond  T = s - sgn(s) b / 4

so that the stiffness is K from the torque 3/4 b on, which is the one that the model states.
"""

from math import copysign, sqrt

from friction_audit.compiled import compiled

NOTHING_NM = 1e-12
"""A spring that stiffens up to this is straight, whatever its curve is."""


def bend_of(soft_nm: float) -> tuple[float, float]:
    """Return b [N m] and 1 / (4 b) [1/(N m)] of a spring that stiffens up to a torque; both zero for a straight one."""
    bend = 4.0 / 3.0 * soft_nm
    return bend, 0.25 / bend if bend > NOTHING_NM else 0.0


@compiled()
def pushed(straight: float, bend: float, curve: float) -> float:
    """Return the torque of a spring, from that of one as stiff as it gets. [N m]"""
    bent = min(max(straight, -bend), bend)
    return straight - bent * (0.5 - curve * abs(bent))


@compiled()
def straightened(torque: float, bend: float) -> float:
    """Return the torque of a spring as stiff as it gets at the twist of this one under a torque. [N m]"""
    size = abs(torque)
    if size >= 0.75 * bend:
        return copysign(size + 0.25 * bend, torque) if size > 0.0 else 0.0
    return 4.0 * torque / (1.0 + sqrt(1.0 + 4.0 * size / bend))
