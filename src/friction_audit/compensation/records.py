"""Settings and states of compensators as NumPy records, whose fields compiled code reads by name."""

from collections.abc import Sequence
from dataclasses import fields
from math import inf, nan

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.competitors import COMPENSATORS, Compensator
from friction_audit.compensation.law import LONGEST_WINDOW, MODELS, Coefficients, CompensatorSettings, EnergyCompensator

NOT_FORCED = Coefficients(coulomb_nm=nan, viscous_nms_per_rad=nan)
VISCOUS, COULOMB, COMBINED = range(len(MODELS))  # values of ``model``

# Values of ``status``, the result of the latest cycle, and their names. From NOT_MOVED on, it gave no equation.
STATUSES = ("no_cycle", "estimated", "too_few", "not_moved", "gap")
NO_CYCLE, ESTIMATED, TOO_FEW, NOT_MOVED, GAP = range(len(STATUSES))

NET, PATH, SQUARE = range(3)  # sums of a cycle: net energy [J], path [rad], integral of dq^2 [rad^2/s]
SHARED = [item.name for item in fields(CompensatorSettings)]  # settings of every kind of compensator
# The numbers that only one kind of compensator has, as fields of a record.
OWN = {
    kind: [(item.name, "f8") for item in fields(kind) if item.type is float and item.name not in SHARED]
    for kind in COMPENSATORS
}
# Shared settings, those of the energy compensator, and a group for each other kind.
SETTINGS = np.dtype(
    [
        *((name, "i8") for name in ("kind", "model", "window", "forced_from_cycle", "forced_until_acted", "passivity")),
        *((name, "f8") for name in ("period_s", "rest_rad_s", "corner_rad_s")),
        *((name, "f8") for name in ("forced_coulomb_nm", "forced_viscous_nms_per_rad")),
        *((item.name, "f8") for item in fields(CompensatorSettings) if item.type is float),
        *OWN[EnergyCompensator],
        *((kind.name, OWN[kind]) for kind in COMPENSATORS if kind is not EnergyCompensator),
    ]
)

# The fields of STATE that a simulation records at every tick.
TRACE = np.dtype(
    [
        *((name, "f8") for name in ("u_nm", "compensation_nm", "passivity_nm", "damping_nms_per_rad")),
        ("coulomb_nm", "f8"),
        ("viscous_nms_per_rad", "f8"),
        ("estimated_coulomb_nm", "f8"),  # NaN before the first estimate; may be negative
        ("estimated_viscous_nms_per_rad", "f8"),
        ("energy_j", "f8"),  # E_m (2)
        ("observed_energy_j", "f8"),  # left side of (21): the passivity observer
        ("active_energy_j", "f8"),  # E_m since the compensator first acted
        ("dissipated_j", "f8"),  # by the passivity controller
        ("limited_nm", "f8"),
        ("cycle", "i8"),  # cycles completed
        ("acted", "i8"),  # 1 if the passivity controller has acted in the present cycle
        ("status", "i8"),
        ("unstable", "i8"),  # 1 once the loop has diverged: from then on the torque is 0 and no energy is integrated
        ("observed_friction_nm", "f8"),
    ]
)
FIELDS = len(TRACE.names or ())
STATE = np.dtype(
    [
        *TRACE.descr,
        *((name, "i8") for name in ("ticks", "equations")),  # samples so far, and cycles that gave an equation
        ("passivity_acted", "i8"),  # 1 if the passivity controller acted in a completed cycle
        ("active", "i8"),  # 1 once the compensator applies a torque
        ("reversals", "i8"),  # consecutive ticks at which the torque, at a limit, changed direction
        *((name, "f8") for name in ("dq", "interaction_nm", "filtered_rad_s", "direction", "net_j", "path_rad")),
        *((name, "f8") for name in ("square_rad2_s", "longest_gap_s", "last_change_nm", "deflection_rad")),
        ("filtered_interaction_nm", "f8"),
        ("usable_coulomb_nm", "f8"),  # 0 before the first estimate; never negative
        ("usable_viscous_nms_per_rad", "f8"),
        ("q_rad", "f8"),  # position of the joint at the next two: friction by its model
        ("modelled_nm", "f8"),
        ("bristle_nm", "f8"),
        ("cycle_sums", "f8", (LONGEST_WINDOW, 3)),
    ]
)


def settings_records(compensators: Sequence[Compensator | None], rate: float) -> NDArray[np.void]:
    """Return records of SETTINGS of compensators, one per joint, None where none runs, for a controller rate. [Hz]"""
    records = np.zeros(len(compensators), SETTINGS)
    for record, compensator in zip(records, compensators, strict=True):
        # Estimation and passivity observer run with every kind of compensator.
        energy = compensator if isinstance(compensator, EnergyCompensator) else EnergyCompensator(passivity=False)
        crossing, forced = energy.zero_crossings, energy.forced or NOT_FORCED
        values = {name: getattr(energy, name) for name in SETTINGS.names or () if hasattr(energy, name)}
        values |= {
            "kind": 0 if compensator is None else COMPENSATORS.index(type(compensator)) + 1,
            "period_s": 1.0 / rate,
            "model": [*MODELS].index(energy.model),
            "window": energy.cycles_per_estimate,
            "forced_coulomb_nm": forced.coulomb_nm,
            "forced_viscous_nms_per_rad": forced.viscous_nms_per_rad,
            "initiation_rad_s": 0.0 if crossing else energy.initiation_rad_s,
            "termination_rad_s": inf if crossing else energy.termination_rad_s,
            "rest_rad_s": 0.0 if crossing else energy.dead_band_rad_s,
            "corner_rad_s": inf if crossing else 2.0 * np.pi * energy.cutoff_hz,
        }
        if compensator is not None:
            values |= {name: getattr(compensator, name) for name in SHARED}
            for name, _ in () if compensator is energy else OWN[type(compensator)]:
                record[compensator.name][name] = getattr(compensator, name)
        for name, value in values.items():
            record[name] = value
    return records


def initial_states(joints: int) -> NDArray[np.void]:
    """Return the states of compensators before their first tick, records of STATE, shape (joints,)."""
    state = np.zeros(joints, STATE)
    state["estimated_coulomb_nm"] = nan
    state["estimated_viscous_nms_per_rad"] = nan
    return state
