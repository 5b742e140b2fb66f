"""The compensator of the paper: Coulomb and viscous friction estimated from energy, cycle by cycle."""

from dataclasses import dataclass
from math import inf

from friction_audit.compensation.compensators.law import Guard
from friction_audit.errors import UsageError

MODELS = ("viscous", "coulomb", "combined")
LONGEST_WINDOW = 64  # cycles that the memory of a compensator holds
# Values of ``ridge``. With less than 0.001 two cycles of one speed still separate what is noise; with more than 0.003 a
# step of friction takes more than the two cycles that it spans (benchmarks/bench_compensation.py).
RIDGE, PUBLISHED = 0.003, 0.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Coefficients:
    """Friction coefficients of one joint."""

    coulomb_nm: float = 0.0  # Coulomb friction [N m]
    viscous_nms_per_rad: float = 0.0  # viscous friction [N m s/rad]


@dataclass(frozen=True, kw_only=True, slots=True)
class EnergyCompensator(Guard):
    """The compensator of the paper: estimates at the end of each energy cycle, applies the estimate in the next.

    The Coulomb term is silent up to ``dead_band_rad_s`` and rises linearly over the next ``ramp_rad_s``. A sign
    function of a velocity that is held for a tick and carries noise would flip between plus and minus the whole
    coefficient at standstill. With the ramp the Coulomb term stays at or below the friction it meets, so that what is
    left is still friction, and its slope, a negative damping, stays small against inertia over tick.
    """

    positive = (*Guard.positive, "minimum_path_rad", "maximum_gap_s", "cutoff_hz")
    not_negative = (*Guard.not_negative, "ridge", "factor", "dead_band_rad_s", "ramp_rad_s")
    gains = ("factor",)

    model: str = "combined"  # ``"viscous"`` (8), ``"coulomb"`` (14) or ``"combined"`` (20)
    window: int | None = None  # number k of cycles an estimate is made from; None for the fewest, 1 or, combined, 2
    # weight of the coefficients in use, by which the combined model is a ridge regression (Hoerl and Kennard 1970)
    # towards them; ``PUBLISHED`` for (20) as printed, which divides by the difference of two cycles
    ridge: float = RIDGE
    minimum_path_rad: float = 0.02  # a cycle in which the joint moved less gives no equation [rad]
    maximum_gap_s: float = 0.05  # a cycle with a longer gap between two ticks gives no equation [s]
    # the estimate is multiplied by this before it is applied; above 1, over-compensation on purpose
    factor: float = 1.0
    # speed up to which the Coulomb term is silent and the joint counts as at rest [rad/s]
    dead_band_rad_s: float = 0.01
    ramp_rad_s: float = 0.03  # range of speed over which the Coulomb term then rises to all of it [rad/s]
    forced: Coefficients | None = None  # coefficients applied, instead of the estimate, or None
    forced_from_cycle: int = 2  # first cycle in which they are applied; cycles count from 1
    # if True, the estimate takes over after the first cycle in which the passivity controller acted
    forced_until_acted: bool = True
    # if True, cycles end where the velocity as measured changes its sign, without filter and thresholds: for signals
    # free of noise
    zero_crossings: bool = False
    initiation_rad_s: float = 0.2  # filtered speed above which a cycle begins [rad/s]
    termination_rad_s: float = 0.05  # filtered speed below which it may end; it ends when the joint then rests [rad/s]
    cutoff_hz: float = 20.0  # corner of the causal first-order low-pass on the velocity, for detection only [Hz]
    passivity: bool = True

    def __post_init__(self) -> None:
        if self.model not in MODELS:
            raise UsageError(f"compensator: model {self.model}: expected one of {', '.join(MODELS)}")
        if not self.unknowns <= self.cycles_per_estimate <= LONGEST_WINDOW:
            raise UsageError(
                f"compensator: window {self.window}: expected {self.unknowns} to {LONGEST_WINDOW} cycles with the "
                f"{self.model} model"
            )
        if not inf > self.initiation_rad_s > self.termination_rad_s > 0:
            raise UsageError(
                f"compensator: thresholds {self.initiation_rad_s:g}, {self.termination_rad_s:g}: expected initiation "
                f"above termination and both above zero, in rad/s"
            )
        if self.forced_from_cycle < 1:
            raise UsageError(f"compensator: forced_from_cycle {self.forced_from_cycle}: cycles count from 1")
        Guard.__post_init__(self)

    @property
    def unknowns(self) -> int:
        """Number of coefficients of the model."""
        return 2 if self.model == "combined" else 1

    @property
    def cycles_per_estimate(self) -> int:
        """The window k in force."""
        return self.unknowns if self.window is None else self.window
