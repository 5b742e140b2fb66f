"""What stands: names by stability, size and held-out gain, what cannot be separated, and the verdict."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.diagnosis import residual_checks, selection
from friction_audit.diagnosis.dictionary import Block
from friction_audit.diagnosis.procedure import State, accepted, nominal, sizes
from friction_audit.diagnosis.result import ResidualCheck, Verdict
from friction_audit.diagnosis.validation import Gain, gains

NEGLIGIBLE = 0.01  # of the joint's friction torque, rms
MINOR = 0.1
ENOUGH = 0.5  # share of the explainable power that names must explain, or nothing holds


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Named:
    """One effect that stands.

    Attributes:
        block: Its columns and nonlinear parameters.
        alternatives: Names that the log cannot separate from it.
        competing: Effects in its place, the closest first.
        folds: In how many of the selections without one fold it is chosen, or what is the same thing there.
        gain: On held-out cycles.
        size_nm: Rms of its torque free of the nominal model. [N m]
        friction_share: Of the rms of the joint's friction torque.
        grade: ``major``, ``minor`` or ``negligible``.
    """

    block: Block
    alternatives: tuple[str, ...]
    competing: tuple[selection.Competing, ...]
    folds: int
    gain: Gain
    size_nm: float
    friction_share: float
    grade: str


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Conclusion:
    """What a log says of a joint.

    Attributes:
        verdict: ``adequate``, ``named``, ``ambiguous``, ``unexplained`` or ``not_testable``.
        named: Effects that count, the largest first.
        negligible: Effects that stand and are too small to count.
        checks: Structures in what is left.
        remainder: Share of the residual's power without a name, 0..1.
        lacking: Motion that would test slow effects where the residual follows the time; empty elsewhere.
    """

    verdict: Verdict
    named: tuple[Named, ...]
    negligible: tuple[Named, ...]
    checks: tuple[ResidualCheck, ...]
    remainder: float
    lacking: str


def conclude(state: State, least_nm: float = 0.0) -> Conclusion:
    """Judge an active set.

    Args:
        state: After selection.
        least_nm: Effects below this are negligible. [N m]
    """
    _stable(state)
    named = sorted((_named(state, block, least_nm) for block in _with_gains(state)), key=lambda one: -one.size_nm)
    checks = residual_checks.run(state.gram, state.active)
    remainder = max((c.share for c in checks), default=0.0)
    large = tuple(one for one in named if one.grade != "negligible")
    small = tuple(one for one in named if one.grade == "negligible")
    return Conclusion(
        verdict=verdict_of(state, large, checks),
        named=large,
        negligible=small,
        checks=checks,
        remainder=remainder,
        lacking=lacking(state, checks),
    )


def verdict_of(state: State, named: Sequence[Named], checks: Sequence[ResidualCheck]) -> Verdict:
    """The one word."""
    if not named:
        if checks:
            return "not_testable" if lacking(state, checks) else "unexplained"
        return "named" if state.contacts else "adequate"
    # No torque of a named effect holds a spectral line, so that a line says nothing against a name.
    remainder = max((c.share for c in checks if c.code != "line"), default=0.0)
    before, after = (float(np.mean(residual_checks.residual_of(state.gram, a) ** 2)) for a in ((), state.active))
    if before - after < ENOUGH * (before - after + remainder * after):
        return "unexplained"
    return "ambiguous" if any(one.alternatives for one in named) else "named"


def lacking(state: State, checks: Sequence[ResidualCheck]) -> str:
    """The motion that would test slow effects where the residual follows the time; empty elsewhere."""
    if not checks or (checks[0].code, checks[0].along) != ("curve", "time"):
        return ""
    why = state.dictionary.not_testable
    return next((why[e.name] for e in state.dictionary.effects if e.name in why and e.axis == "time"), "")


def _stable(state: State) -> None:
    """Drop effects that too few of the folds choose, or that structure outside the catalogue replaces."""
    numbers = state.search.most_numbers
    while state.active:
        state.folds = selection.shares_of_folds(state.gram, state.active, numbers)
        unsteady = [
            b
            for b in state.active
            if state.folds[b.name] < selection.LEAST_FOLDS * state.problem.folds
            or residual_checks.competing_structure(state.gram, state.active, b)
        ]
        if not unsteady:
            return
        kept = [b for b in state.active if b not in unsteady]
        state.active = accepted(state, kept)


def _with_gains(state: State) -> list[tuple[Block, Gain, float]]:
    return list(
        zip(state.active, gains(state.gram, state.active), sizes(state.gram, state.active).tolist(), strict=True)
    )


def _named(state: State, one: tuple[Block, Gain, float], least_nm: float) -> Named:
    block, gain, size = one
    competing = selection.competing_effects(state.search, state.active, block)
    baseline = nominal(state.problem, state.search.training, state.active)
    friction = np.abs(
        baseline.coulomb_nm * state.problem.data.way + baseline.viscous_nms_per_rad * state.problem.data.dq
    )
    share = size / max(float(np.sqrt(np.mean(friction[state.problem.data.used] ** 2))), 1e-12)
    grade = "negligible" if share < NEGLIGIBLE or size < least_nm else ("minor" if share < MINOR else "major")
    return Named(
        block=block,
        alternatives=selection.indistinguishable(competing, block, state.active),
        competing=competing,
        folds=(state.folds or {}).get(block.name, 0),
        gain=gain,
        size_nm=size,
        friction_share=share,
        grade=grade,
    )
