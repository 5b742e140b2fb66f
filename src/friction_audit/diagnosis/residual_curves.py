"""The mean residual along each quantity with its bands, and where along it an effect shows itself."""

import numpy as np

from friction_audit.diagnosis import contact_events
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.procedure import State, fine_torques
from friction_audit.diagnosis.profiles import profile_all
from friction_audit.diagnosis.result import ContactTrace, Evidence, NamedEffect, Profile
from friction_audit.diagnosis.samples import filter_matrix
from friction_audit.diagnosis.screening import Screening
from friction_audit.effects.contact_event import EFFECT as CONTACT
from friction_audit.effects.contact_event import Contact
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float


def profiles_of(problem: RegressionProblem, residual: Float, test: Screening) -> tuple[Profile, ...]:
    """The residual along every quantity, what takes most of it first."""
    return profile_all(residual, problem.curves, problem.kinematics[1], problem.samples.cycle, test.curves)


def along_effect(problem: RegressionProblem, shown: Float, axis: str) -> Profile:
    """What an effect and the noise leave along the effect's quantity."""
    own = [one for one in problem.curves if one.axis.name == axis] or problem.curves
    return profile_all(shown, own, problem.kinematics[1], problem.samples.cycle, {})[0]


def contact_effects(
    problem: RegressionProblem, contacts: tuple[Contact, ...], profiles: tuple[Profile, ...]
) -> tuple[NamedEffect, ...]:
    """Contacts as one effect of the answer."""
    if not contacts:
        return ()
    whole = RegressionProblem.build(problem.data, problem.nominal.model)
    X = problem.X
    coefficients = np.linalg.lstsq(X @ X.T, X @ problem.y, rcond=1e-12)[0]
    left = (whole.y - coefficients @ whole.X) / whole.samples.weight
    inside = contact_events.touched(whole, contacts)
    before, after = (float(np.sqrt(np.mean(one**2))) for one in (left, left[~inside]))
    largest = float(left[inside][np.argmax(np.abs(left[inside]))]) if inside.any() else 0.0
    lengths = [one.stop_s - one.start_s for one in contacts]
    numbers = {"contacts": float(len(contacts)), "first_contact_s": contacts[0].start_s,
               "longest_contact_s": max(lengths), "largest_contact_nm": largest}  # fmt: skip
    size = float(np.sqrt(max(before**2 - after**2, 0.0)))
    return (
        NamedEffect(
            name=CONTACT.name,
            label=CONTACT.label,
            alternatives=(),
            parameters={k: Coefficient(value=v, low=float("nan"), high=float("nan")) for k, v in numbers.items()},
            p_value=float("nan"),
            axis=CONTACT.axis,
            gap_before_nm=before,
            gap_after_nm=after,
            torque=np.zeros(len(problem.y)),
            curve=next((one for one in profiles if one.axis == CONTACT.axis), profiles[0]),
            evidence=(Evidence(name=CONTACT.name, delta_bic=0.0, correlation=1.0),),
            size_nm=size,
            friction_share=float("nan"),
            residual_share=(size / before) ** 2 if before > 0 else 0.0,
            grade="major",
            folds=0,
            chosen_in=0,
        ),
    )


def contact_trace(state: State) -> ContactTrace | None:
    """What the augmented model leaves over the whole log, samples of contacts included; None without contacts."""
    if not state.contacts:
        return None
    data, samples = state.problem.data, state.problem.samples
    _, fine = fine_torques(state)
    left = filter_matrix(len(fine), samples.kernel, samples.every) @ fine
    seen = (data.moving & data.valid)[:: samples.every]
    return ContactTrace(
        t=data.t[:: samples.every],
        residual_nm=np.where(seen, left, np.nan),
        spans_s=tuple((contact.start_s, contact.stop_s) for contact in state.contacts),
    )
