"""Discrepancy: what a diagnosis says of every joint, and all that a figure of it needs."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.data_audit import DataFinding
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

Verdict = Literal["adequate", "named", "ambiguous", "unexplained", "not_testable", "data_fault", "failed"]
VERDICTS: tuple[Verdict, ...] = (
    "adequate",
    "named",
    "ambiguous",
    "unexplained",
    "not_testable",
    "data_fault",
    "failed",
)
UNANSWERED: tuple[Verdict, ...] = ("not_testable", "data_fault", "failed")
"""Verdicts that are no answer."""
CONTACT_EVENT = "contact_event"


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Profile:
    """The residual against one quantity, in bins, for each direction of motion.

    Attributes:
        axis: The quantity: one of ``AXES``.
        label: The quantity with its unit, for people.
        edges: Where the bins begin and end, shape (b + 1,).
        centre: Mean of the quantity in each bin, shape (b,).
        forwards: Mean residual while the joint moves forwards, NaN in empty bins, shape (b,). [N m]
        backwards: The same backwards, shape (b,). [N m]
        forwards_se: Standard error of the mean from cycles, shape (b,). [N m]
        backwards_se: The same backwards, shape (b,). [N m]
        share: Share of the residual's mean square that a curve over this axis takes, of cycles it has not seen, 0..1.
        p_value: That nothing depends on this axis, adjusted for all axes that were looked at.
    """

    axis: str
    label: str
    edges: Float
    centre: Float
    forwards: Float
    backwards: Float
    forwards_se: Float
    backwards_se: Float
    share: float
    p_value: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Gap:
    """Held-out residual of the nominal and of the augmented model.

    Attributes:
        before: Root mean square of what the nominal model leaves. [unit of the response]
        after: The same for the augmented model.
        floor: Root mean square of the noise.
        shrink: (before - after) / (before - floor); NaN where before is at the floor.
        shrink_se: Standard error of shrink from leaving out one cycle at a time, the floor taken as known.
        over_floor: after / floor; infinite for a floor of 0.
        cycles: Number of held-out cycles.
    """

    before: float
    after: float
    floor: float
    shrink: float
    shrink_se: float
    over_floor: float
    cycles: int


@dataclass(frozen=True, kw_only=True, slots=True)
class ResidualCheck:
    """A structure in what is left.

    Attributes:
        code: ``curve``, ``response``, ``line``, ``scatter`` or ``change``.
        along: The quantity, or the effect that changes.
        share: Of the mean square, 0..1.
        frequency: Of a line: in Hz, or waves per rad; 0 for the others.
    """

    code: str
    along: str
    share: float
    frequency: float = 0.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Evidence:
    """How well another candidate does in the place of a named effect.

    Attributes:
        name: Name of the candidate; the effect itself stands first.
        two_ln_bayes_factor: 2 ln of the Bayes factor of the effect over this one; from 6 on strong evidence
            (R. E. Kass, A. E. Raftery, J. Am. Stat. Assoc. 90 (1995) 773).
        correlation: Of its torque with that of the effect, free of all else in the model, 0..1.
    """

    name: str
    two_ln_bayes_factor: float
    correlation: float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class OwnAxis:
    """The axis of an effect that no axis of the joint's motion shows: one wave of a ripple, or its fitted torque.

    Attributes:
        label: The quantity with its unit.
        values: The quantity at the samples, shape (m,).
        curve: What the augmented model leaves plus the effect's torque, along the axis.
        before: The residual of the nominal model along it.
        after: The residual of the augmented model along it.
    """

    label: str
    values: Float
    curve: Profile
    before: Profile
    after: Profile


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class NamedEffect:
    """An effect that the nominal model misses.

    Attributes:
        name: From the vocabulary.
        label: A few words for people.
        alternatives: Names that this log does not tell apart from it.
        parameters: Values with 95 % intervals by name with its unit: linear factors, then shape.
        p_value: Family-wise p-value of its improvement on cycles that no choice was made on.
        axis: The quantity on which it shows itself.
        gap_before_nm: Residual on locked cycles without it, all stronger effects added. [N m]
        gap_after_nm: The same with it. [N m]
        torque: Its torque at the rows, shape (m,). [N m]
        curve: What the augmented model leaves plus this torque, along the axis: the effect as the log shows it.
        evidence: The candidates in its place, the best first.
        own: The axis that it is drawn along; None where ``axis`` shows it.
        size_nm: Rms of its torque free of the nominal model. [N m]
        friction_share: Of the rms of the joint's friction torque.
        residual_share: Of the residual's power, with the nominal model alone, that it takes.
        grade: ``major``, ``minor`` or ``negligible``.
        folds: Selections, each without one fold of the cycles.
        chosen_in: Those that chose it, or what is the same thing there.
        not_identifiable: Names of its parameters that this log does not hold.
    """

    name: str
    label: str
    alternatives: tuple[str, ...]
    parameters: dict[str, Coefficient]
    p_value: float
    axis: str
    gap_before_nm: float
    gap_after_nm: float
    torque: Float
    curve: Profile
    evidence: tuple[Evidence, ...]
    size_nm: float
    friction_share: float
    residual_share: float
    grade: str
    folds: int
    chosen_in: int
    not_identifiable: tuple[str, ...] = ()
    own: OwnAxis | None = None


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Traces:
    """Measured and simulated torque at the rows of the regression, shape (m,) each.

    Attributes:
        t: Time. [s]
        q: Position. [rad]
        dq: Velocity. [rad/s]
        displacement: Position less that at the last reversal. [rad]
        cycle: Number of the cycle.
        held_out: Rows of cycles that no choice was made on.
        measured: Torque. [N m]
        before: Torque of the nominal model. [N m]
        after: Torque of the augmented model. [N m]
        along: The quantity of every axis that was looked at, by the axis' name, shape (m,) each.
        corner_hz: Corner of the low-pass filter that all torques went through. [Hz]
    """

    t: Float
    q: Float
    dq: Float
    displacement: Float
    cycle: NDArray[np.int64]
    held_out: NDArray[np.bool_]
    measured: Float
    before: Float
    after: Float
    along: dict[str, Float]
    corner_hz: float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class SimulationGap:
    """How far a forward simulation under the measured torque strays from the measured motion, on locked cycles.

    Attributes:
        before: Root mean square of the velocity's error with the nominal model. [unit]
        after: The same with the augmented model. [unit]
        unit: ``"rad/s"``.
        t: Time of the cycles simulated, NaN between them, shape (k,). [s]
        measured: Velocity as measured, shape (k,). [rad/s]
        nominal: Velocity of the nominal model, shape (k,). [rad/s]
        augmented: Velocity of the augmented model, shape (k,). [rad/s]
    """

    before: float
    after: float
    unit: str
    t: Float
    measured: Float
    nominal: Float
    augmented: Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class ContactTrace:
    """Contact events over the whole log.

    Attributes:
        t: Time, shape (k,). [s]
        residual_nm: What the augmented model leaves of the low-passed torque, NaN at rest, shape (k,). [N m]
        spans_s: Beginning and end of each contact. [s]
    """

    t: Float
    residual_nm: Float
    spans_s: tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointDiagnosis:
    """What a diagnosis says of one joint.

    Attributes:
        joint: Number for people (1..n of the log).
        name: Name of the joint.
        verdict: The one word.
        effects: What is missing, the strongest first.
        nominal: Factors of the nominal model with their intervals; empty where it could not be fitted.
        augmented: The same factors as fitted together with the effects; those of the augmented model.
        from_energy: The coefficients that the energy method gives, for comparison; empty where there are none.
        gap: The gap in torque on locked cycles; None where nothing was fitted.
        simulation: The gap in motion; None where nothing was simulated.
        ladder: Root mean square of the residual on locked cycles: of the nominal model, after each effect, and the
            noise floor, with a label each. [N m]
        omnibus_p: That nothing is missing from the nominal model; NaN where not tested.
        remaining_p: That nothing is missing from the augmented model; NaN where not tested.
        detection_limit_nm: Smallest root mean square of an effect that would have been seen with 90 % power. [N m]
        profiles: The residual of the nominal model against every axis, the most telling first.
        remaining: The residual of the augmented model likewise.
        negligible: Effects that stand and are too small to count.
        checks: Structures in what the augmented model leaves.
        remainder_share: Share of the residual's power without a name, 0..1.
        share_explained: Share of the gap that the effects close, gravity in the model before and after.
        untestable: Why the log cannot show an effect, by name of the effect.
        findings: What the audit of the data found.
        traces: Measured against simulated; None where nothing was fitted.
        contacts: Contact events; None without any.
        reason: Why there is no answer; empty with one.
        traceback: Of the error, a bug, that ended the diagnosis of the joint; empty without one.
    """

    joint: int
    name: str
    verdict: Verdict
    reason: str = ""
    effects: tuple[NamedEffect, ...] = ()
    nominal: dict[str, Coefficient] = field(default_factory=dict)
    augmented: dict[str, Coefficient] = field(default_factory=dict)
    from_energy: dict[str, Coefficient] = field(default_factory=dict)
    gap: Gap | None = None
    simulation: SimulationGap | None = None
    ladder: tuple[tuple[str, float], ...] = ()
    omnibus_p: float = float("nan")
    remaining_p: float = float("nan")
    detection_limit_nm: float = float("nan")
    profiles: tuple[Profile, ...] = ()
    remaining: tuple[Profile, ...] = ()
    negligible: tuple[NamedEffect, ...] = ()
    checks: tuple[ResidualCheck, ...] = ()
    remainder_share: float = 0.0
    share_explained: float = float("nan")
    untestable: dict[str, str] = field(default_factory=dict)
    findings: tuple[DataFinding, ...] = ()
    traces: Traces | None = None
    contacts: ContactTrace | None = None
    traceback: str = ""

    def __repr__(self) -> str:
        names = " and ".join(" or ".join((effect.name, *effect.alternatives)) for effect in self.effects)
        gap = f", residual {self.gap.before:.4g}, augmented {self.gap.after:.4g}" if self.gap else ""
        why = f" ({self.reason.partition(';')[0]})" if self.reason else ""
        return f"joint {self.joint} {self.name}: {self.verdict}{why}{f': {names}' if names else ''}{gap}"

    @property
    def added(self) -> tuple[NamedEffect, ...]:
        """The effects of the augmented model: contact events are in no model, their samples are left out."""
        return tuple(effect for effect in self.effects if effect.name != CONTACT_EVENT)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Discrepancy:
    """What a diagnosis says of a log: one entry per joint."""

    joints: tuple[JointDiagnosis, ...]
