"""A vibration above the corner of the rows: is it the ringing of a spring, or of flanks that strike?

A regression looks below 25 Hz, and a stiff gear rings above. What rings starts anew at every reversal, with friction's
jump, and follows from the motion, as what only hums does not. So the names of what rings are looked for once more, by
the same procedure, on the fine grid, where nothing was filtered away.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from friction_audit.diagnosis.curves import build_curves
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.library import Library, build_library
from friction_audit.diagnosis.naming import LEAST_SHARE, Names, find_names
from friction_audit.diagnosis.noise import runs_of
from friction_audit.diagnosis.parameters import parameters_of
from friction_audit.diagnosis.result import Effect as NamedEffect
from friction_audit.diagnosis.result import Vibration
from friction_audit.diagnosis.spectrum import find_vibration
from friction_audit.diagnosis.tell import effects_of
from friction_audit.effects.backlash import CONTACTS_HZ
from friction_audit.effects.backlash import EFFECT as BACKLASH
from friction_audit.effects.breakaway import Breakaways
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_elasticity import EFFECT as ELASTICITY
from friction_audit.effects.joint_elasticity import HIGHER, all_springs
from friction_audit.joint_log import Float

RINGING = (ELASTICITY.name, BACKLASH.name)
LEAST_VIBRATION = 0.5
"""A vibration of less than this share of what the grown model leaves is told, and does not decide."""
CORNER_HZ = 60.0
"""Half of the amplitude passes here: above all that rings and is told, below what torque and motion were filtered with,
so that a jump is as steep in the columns as in the torque."""
CORNER_SHARE = 0.225
"""Of the rate, where that is lower: vibrations are looked for below 0.2 of it, and torque and motion end at 0.25."""
FILTER_S = 0.05
"""Reach of that low-pass to either side."""
LEAST_EXPLAINED = 0.5
"""Of a vibration's power, on the locked cycles: what its name must explain."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Ringing:
    """What rings, as a result, and the other names that are large enough beside it."""

    effect: NamedEffect
    names: Names


def shaking(ground: Ground, names: Names) -> Vibration | None:
    """A vibration with half of the rms of what the names leave on the locked cycles, and no name for it."""
    columns = [f.columns for f in names.found]
    vibration = find_vibration(ground.fine_residual(columns, fine_columns(ground, names)), ground.data)
    left = float(np.sqrt(np.mean(ground.residual(*columns)[ground.locked] ** 2)))
    shakes = vibration is not None and vibration.rms_nm > LEAST_VIBRATION * left and not rings(names, (), vibration)
    return vibration if shakes else None


def fine_columns(ground: Ground, names: Names) -> list[Float]:
    """Columns of the effects on the fine grid, shape (n, p) each."""
    return [f.candidate.regressor(ground.data, names.baseline, f.shape) for f in names.found]


def rings(names: Names, events: Sequence[NamedEffect], vibration: Vibration) -> bool:
    """Whether a vibration is that of a spring or of flanks that strike, which have a name.

    A spring's lies from its resonance with the far side up to twice that, for a light link on its other end makes it
    higher; that of flanks from where those of the model ring upwards, for the model's are as hard as rows can tell.
    What lies above the motion that a name goes along is none of it: of the measured side's own ringing it says nothing.
    """
    if any(event.name in RINGING for event in events):
        return True
    for f in names.found:
        if vibration.low_hz >= f.shape.get("motion_below_hz", np.inf):
            return True
        if f.candidate.name == ELASTICITY.name:
            lowest = _resonance(names, f.shape["spring_nm_per_rad"] / f.shape.get("far_share", 1.0))
            if vibration.high_hz >= lowest and vibration.low_hz <= HIGHER * lowest:
                return True
        if f.candidate.name == BACKLASH.name and vibration.high_hz >= f.shape["contact_hz"]:
            return True
    return False


def _resonance(names: Names, stiffness_nm_per_rad: float) -> float:
    """Frequency at which the far side rings on a spring whose other end is held. [Hz]"""
    inertia = max(names.baseline.inertia_kg_m2, np.finfo(float).tiny)
    return float(np.sqrt(stiffness_nm_per_rad / inertia)) / (2.0 * np.pi)


def find_ringing(ground: Ground, names: Names, alpha: float, rng: np.random.Generator) -> Ringing | None:
    """Name what shakes a joint above the corner; None where nothing does, or what rings does not explain it.

    Other names that are smaller than a fifth of it may be what its formula does not get right, and go.

    Args:
        ground: The joint.
        names: What was found on the rows.
        alpha: Family-wise error on the locked cycles.
        rng: Source of randomness.
    """
    vibration = shaking(ground, names)
    if (
        vibration is None
        or vibration.frequency_hz < ground.rows.corner_hz
        or ELASTICITY.name in names.library.untestable
    ):
        return None
    # A spring of the rows that does not ring so was none, or another one, if what rings explains all that it did.
    still = replace(names, found=tuple(f for f in names.found if f.candidate.name not in RINGING))
    fine = on_every_sample(ground, still)
    candidates = _near(ground, still, vibration)
    found = find_names(fine, candidates, _library(fine, candidates, still), alpha, rng)
    if len(found.found) != 1 or not _explains(fine, found, vibration) or _loses(ground, names, still, found):
        return None
    names = still
    numbers = parameters_of(fine, found.found, found.baseline)
    (effect,) = effects_of(fine, found, fine.curves, numbers)
    large = [_size(ground, names, k) >= LEAST_SHARE * effect.partial_nm for k in range(len(names.found))]
    kept = replace(names, found=tuple(f for f, enough in zip(names.found, large, strict=True) if enough))
    return Ringing(effect=_on_rows(ground, kept, effect, vibration), names=kept)


def _near(ground: Ground, names: Names, vibration: Vibration) -> tuple[Effect, ...]:
    """Straight springs on which the far side rings from half of the vibration's frequencies on, and hard flanks."""
    lowest, highest = vibration.low_hz / HIGHER, vibration.high_hz
    # Ringing tells how stiff a spring is where it rings, not how it bends.
    springs = [
        shape
        for shape in all_springs(ground.data)
        if not {"soft_nm", "damping_ratio", "far_share"} & shape.keys()
        and lowest <= _resonance(names, shape["spring_nm_per_rad"]) <= highest
    ]
    hard = max(CONTACTS_HZ)
    flanks = [
        shape
        for shape in BACKLASH.grid(ground.data)
        if shape["contact_hz"] == hard and not {"motion_below_hz", "far_share"} & shape.keys()
    ]
    pairs = ((ELASTICITY, springs), (BACKLASH, flanks))
    return tuple(candidate.with_grid(shapes) for candidate, shapes in pairs if shapes)


def _library(fine: Ground, candidates: Sequence[Effect], names: Names) -> Library:
    return build_library(candidates, fine.data, names.baseline, fine.rows)


def _explains(fine: Ground, found: Names, vibration: Vibration) -> bool:
    """Whether half of the vibration's power is gone on the locked cycles."""
    columns = [f.columns for f in found.found]
    before, after = (float(np.mean(left[fine.locked] ** 2)) for left in (fine.residual(), fine.residual(*columns)))
    return before - after >= LEAST_EXPLAINED * vibration.rms_nm**2


def _loses(ground: Ground, names: Names, still: Names, found: Names) -> bool:
    """Whether what the rows found among springs and plays leaves less of the locked rows than what rings instead.

    A play takes the torque from the sensor below the corner, and its flanks ring above it: the torque below tells more
    of it than a spring that rings alike above.
    """
    if len(still.found) == len(names.found):
        return False
    columns = [f.columns for f in still.found]
    rung = [ground.rows.of(f.candidate.regressor(ground.data, found.baseline, f.shape)) for f in found.found]
    left, instead = ground.residual(*(f.columns for f in names.found)), ground.residual(*columns, *rung)
    return float(np.sum(left[ground.locked] ** 2)) < float(np.sum(instead[ground.locked] ** 2))


def _size(ground: Ground, names: Names, k: int) -> float:
    """Root mean square of one effect's torque on the rows, free of all else. [N m]"""
    columns = [f.columns for f in names.found]
    left = (ground.residual(*columns), ground.residual(*columns[:k], *columns[k + 1 :]))
    with_it, without = (float(np.mean(one**2)) for one in left)
    return sqrt(max(without - with_it, 0.0))


def _on_rows(ground: Ground, names: Names, effect: NamedEffect, vibration: Vibration) -> NamedEffect:
    """The effect as told beside those of the rows, which hardly see it: their gap is the same with and without it."""
    left = float(np.sqrt(np.mean(ground.residual(*(f.columns for f in names.found))[ground.locked] ** 2)))
    return replace(
        effect,
        where=f"ringing at {vibration.frequency_hz:.3g} Hz, above what a regression sees",
        gap_before_nm=left,
        gap_after_nm=left,
        torque=np.zeros(len(ground.y)),
    )


def on_every_sample(ground: Ground, names: Names) -> Ground:
    """The same joint with the samples of the fine grid as rows, and what was found in its declared model."""
    from scipy.signal import firwin

    data, declared = ground.data, ground.declared
    used = data.used & np.isin(data.cycle, ground.rows.cycle)
    columns = np.hstack([declared.fine, *fine_columns(ground, names)])
    y = data.torque - declared.stated
    corner_hz = min(CORNER_HZ, CORNER_SHARE / data.step_s)
    extra = tuple(f"found_{k}" for k in range(columns.shape[1] - declared.fine.shape[1]))
    bare = replace(
        ground.rows,
        kernel=firwin(2 * round(FILTER_S / data.step_s) + 1, corner_hz, fs=1.0 / data.step_s),
        corner_hz=corner_hz,
        every=1,
        used=used,
        t=data.t[used],
        y=y,
        cycle=data.cycle[used],
        breakaways=Breakaways(
            first=np.zeros(0, np.int64),
            onset=np.zeros(0, np.int64),
            certain=np.zeros(0, np.int64),
            direction=np.zeros(0),
            weights=ground.rows.breakaways.weights,
        ),
        breakaway_row=np.zeros(0, np.int64),
    )
    rows = replace(bare, y=bare.of(y))
    return replace(
        ground,
        rows=rows,
        declared=replace(declared, names=(*declared.names, *extra), fine=columns, columns=rows.of(columns), y=rows.y),
        working=np.isin(rows.cycle, ground.rows.cycle[ground.working]),
        run=runs_of(used, data.cycle)[used],
        curves=build_curves(data, rows),
        surface=replace(ground.surface, shapes=()),
        rigid=np.zeros((int(used.sum()), 0)),
    )
