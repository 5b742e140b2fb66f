"""What a diagnosis says of a joint, and all that a figure of it needs."""

from dataclasses import dataclass, field
from typing import Literal, get_args

from friction_audit.diagnosis.data_audit import DataFinding
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Bool, Float, Int
from friction_audit.preprocessing.interaction import Caution, Reason

Verdict = Literal["adequate", "named", "ambiguous", "unexplained", "not_testable", "data_fault", "failed"]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
UNANSWERED: tuple[Verdict, ...] = ("not_testable", "data_fault", "failed")  # verdicts that are no answer
CONTACT_EVENT = "contact_event"


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Profile:
    """The residual against one quantity, in bins, for each direction of motion."""

    axis: str  # the quantity: one of ``AXES``
    label: str  # the quantity with its unit, for people
    edges: Float  # where the bins begin and end, shape (b + 1,)
    centre: Float  # mean of the quantity in each bin, shape (b,)
    forwards: Float  # mean residual while the joint moves forwards, NaN in empty bins, shape (b,) [N m]
    backwards: Float  # the same backwards, shape (b,) [N m]
    forwards_se: Float  # standard error of the mean from cycles, shape (b,) [N m]
    backwards_se: Float  # the same backwards, shape (b,) [N m]
    # share of the residual's mean square that a curve over this axis takes, of cycles it has not seen, 0..1
    share: float
    p_value: float  # that nothing depends on this axis, adjusted for all axes that were looked at


@dataclass(frozen=True, kw_only=True, slots=True)
class Gap:
    """Held-out residual of the nominal and of the augmented model."""

    before: float  # root mean square of what the nominal model leaves [unit of the response]
    after: float  # the same for the augmented model
    floor: float  # root mean square of the noise
    shrink: float  # (before - after) / (before - floor); NaN where before is at the floor
    shrink_se: float  # standard error of shrink from leaving out one cycle at a time, the floor taken as known
    over_floor: float  # after / floor; infinite for a floor of 0
    cycles: int  # number of held-out cycles


@dataclass(frozen=True, kw_only=True, slots=True)
class ResidualCheck:
    """A structure in what is left."""

    code: str  # ``curve``, ``response``, ``line``, ``scatter`` or ``change``
    along: str  # the quantity, or the effect that changes
    share: float  # of the mean square, 0..1
    frequency: float = 0.0  # of a line: in Hz, or waves per rad; 0 for the others


@dataclass(frozen=True, kw_only=True, slots=True)
class Evidence:
    """How well another candidate does in the place of a named effect."""

    name: str  # name of the candidate
    # 2 ln of the Bayes factor of the effect over this one; from 6 on strong evidence (R. E. Kass, A. E. Raftery, J. Am.
    # Stat. Assoc. 90 (1995) 773).
    two_ln_bayes_factor: float
    correlation: float  # of its torque with that of the effect, free of all else in the model, 0..1


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class OwnAxis:
    """The axis of an effect that no axis of the joint's motion shows: one wave of a ripple, or its fitted torque."""

    label: str  # the quantity with its unit
    values: Float  # the quantity at the samples, shape (m,)
    curve: Profile  # what the augmented model leaves plus the effect's torque, along the axis
    before: Profile  # the residual of the nominal model along it
    after: Profile  # the residual of the augmented model along it


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class NamedEffect:
    """An effect that the nominal model misses."""

    name: str  # from the vocabulary
    label: str  # a few words for people
    alternatives: tuple[str, ...] = ()  # names that this log cannot separate from it
    parameters: dict[str, Coefficient]  # with 95 % intervals, by name with its unit
    p_value: float = float("nan")  # family-wise p-value of its improvement on held-out cycles
    axis: str  # the quantity on which it shows itself
    gap_before_nm: float  # residual on held-out cycles without it, all stronger effects added [N m]
    gap_after_nm: float  # the same with it [N m]
    torque: Float  # its torque at the samples, shape (m,) [N m]
    curve: Profile  # what the augmented model leaves plus this torque, along the axis: the effect as the log shows it
    evidence: tuple[Evidence, ...] = ()  # other candidates in its place, the best first
    size_nm: float  # rms of its torque free of the nominal model [N m]
    friction_share: float = float("nan")  # of the rms of the joint's friction torque
    residual_share: float  # of the mean square that the nominal model leaves on held-out cycles, with the larger named
    grade: str  # ``major``, ``minor`` or ``negligible``
    folds: int = 0  # selections, each without one fold of the cycles
    chosen_in: int = 0  # those that chose it, or what is the same thing there
    not_identifiable: tuple[str, ...] = ()  # names of its parameters that this log does not hold
    own: OwnAxis | None = None  # the axis that it is drawn along; None where ``axis`` shows it


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Traces:
    """Measured and simulated torque at the samples, shape (m,) each."""

    t: Float  # time [s]
    q: Float  # position [rad]
    dq: Float  # velocity [rad/s]
    cycle: Int  # number of the cycle
    held_out: Bool  # samples of held-out cycles
    measured: Float  # torque [N m]
    before: Float  # torque of the nominal model [N m]
    after: Float  # torque of the augmented model [N m]
    along: dict[str, Float]  # the quantity of every axis that was looked at, by the axis' name, shape (m,) each
    corner_hz: float  # corner of the low-pass filter that all torques went through [Hz]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class SimulationGap:
    """Velocity error of a forward simulation under the measured torque, on held-out cycles."""

    before: float  # root mean square of the velocity's error with the nominal model [rad/s]
    after: float  # the same with the augmented model [rad/s]
    t: Float  # time of the cycles simulated, NaN between them, shape (k,) [s]
    measured: Float  # velocity as measured, shape (k,) [rad/s]
    nominal: Float  # velocity of the nominal model, shape (k,) [rad/s]
    augmented: Float  # velocity of the augmented model, shape (k,) [rad/s]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class ContactTrace:
    """Contact events over the whole log."""

    t: Float  # time, shape (k,) [s]
    residual_nm: Float  # what the augmented model leaves of the low-passed torque, NaN at rest, shape (k,) [N m]
    spans_s: tuple[tuple[float, float], ...]  # beginning and end of each contact [s]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointDiagnosis:
    """What a diagnosis says of one joint."""

    joint: int  # number for people (1..n of the log)
    name: str  # name of the joint
    verdict: Verdict  # the one word
    reason: Reason = ()  # why there is no answer; empty with one
    effects: tuple[NamedEffect, ...] = ()  # what is missing, the strongest first
    # coefficients of the nominal model with their intervals; empty where it could not be fitted
    nominal: dict[str, Coefficient] = field(default_factory=dict)
    # the same coefficients as fitted together with the effects; those of the augmented model
    augmented: dict[str, Coefficient] = field(default_factory=dict)
    # the coefficients that the energy method gives, for comparison; empty where there are none
    from_energy: dict[str, Coefficient] = field(default_factory=dict)
    gap: Gap | None = None  # the gap in torque on held-out cycles; None where nothing was fitted
    simulation: SimulationGap | None = None  # the gap in motion; None where nothing was simulated
    # rms of the residual on held-out cycles with labels: of the nominal model, after each effect, of the noise [N m]
    ladder: tuple[tuple[str, float], ...] = ()
    omnibus_p: float = float("nan")  # that nothing is missing from the nominal model; NaN where not tested
    remaining_p: float = float("nan")  # that nothing is missing from the augmented model; NaN where not tested
    detection_limit_nm: float = float("nan")  # smallest rms of an effect that would have been seen with 90 % power
    profiles: tuple[Profile, ...] = ()  # the residual of the nominal model against every axis, the most telling first
    remaining: tuple[Profile, ...] = ()  # the residual of the augmented model likewise
    negligible: tuple[NamedEffect, ...] = ()  # effects that stand and are too small to count
    checks: tuple[ResidualCheck, ...] = ()  # structures in what the augmented model leaves
    remainder_share: float = 0.0  # share of the residual's power without a name, 0..1
    share_explained: float = float("nan")  # of the gap, by the effects, gravity in the model before and after
    # why the log cannot show an effect, by name of the effect
    untestable: dict[str, Caution] = field(default_factory=dict)
    findings: tuple[DataFinding, ...] = ()  # what the audit of the data found
    traces: Traces | None = None  # measured against simulated; None where nothing was fitted
    contacts: ContactTrace | None = None  # contact events; None without any
    traceback: str = ""  # of the error, a bug, that ended the diagnosis of the joint; empty without one

    def __repr__(self) -> str:
        names = " and ".join(" or ".join((effect.name, *effect.alternatives)) for effect in self.effects)
        gap = f", residual {self.gap.before:.4g}, augmented {self.gap.after:.4g}" if self.gap else ""
        why = f" ({'; '.join(map(str, self.reason))})" if self.reason else ""
        return f"joint {self.joint} {self.name}: {self.verdict}{why}{f': {names}' if names else ''}{gap}"

    @property
    def added(self) -> tuple[NamedEffect, ...]:
        """The effects of the augmented model: contact events are in no model, their samples are left out."""
        return tuple(effect for effect in self.effects if effect.name != CONTACT_EVENT)
