"""Diagnosis -> tidy tables: verdicts, effects with their numbers, how the gap shrank, the residual before and after."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from friction_audit.diagnosis.result import JointDiscrepancy, Profile, SimulationGap, Traces
from friction_audit.io.tidy_table import Column, JointRows, TidyTable, as_column
from friction_audit.pipeline import Diagnosis
from friction_audit.reporting.units import table_in_unit

VERDICTS: dict[str, type] = {
    "verdict": str,
    "message": str,
    "gap_before_nm": float,
    "gap_after_nm": float,
    "floor_nm": float,
    "shrink": float,
    "held_out_cycles": int,
    "simulation_gap_before_rad_s": float,
    "simulation_gap_after_rad_s": float,
    "detection_limit_nm": float,
    "omnibus_p_value": float,
    "remaining_p_value": float,
}
EFFECTS: dict[str, type] = {
    "rank": int,
    "effect": str,
    "label": str,
    "alternatives": str,
    "p_value": float,
    "gap_before_nm": float,
    "gap_after_nm": float,
    "where": str,
    "decide": str,
}
PARAMETERS: dict[str, type] = {
    "effect": str,
    "parameter": str,
    "value": float,
    "ci95_low": float,
    "ci95_high": float,
}
LADDER: dict[str, type] = {"step": int, "label": str, "rms_nm": float}
PROFILES: dict[str, type] = {
    "of": str,
    "axis": str,
    "axis_label": str,
    "centre": float,
    "forwards_nm": float,
    "forwards_se_nm": float,
    "backwards_nm": float,
    "backwards_se_nm": float,
}
RESIDUAL: dict[str, type] = {
    "time_s": float,
    "cycle": int,
    "held_out": bool,
    "q_rad": float,
    "dq_rad_s": float,
    "measured_nm": float,
    "declared_nm": float,
    "grown_nm": float,
    "residual_before_nm": float,
    "residual_after_nm": float,
}
SIMULATION: dict[str, type] = {
    "time_s": float,
    "dq_measured_rad_s": float,
    "dq_declared_rad_s": float,
    "dq_grown_rad_s": float,
}

DIAGNOSE_TABLES: tuple[str, ...] = (
    "verdicts",
    "effects",
    "effect_parameters",
    "gap_ladder",
    "residual_profiles",
    "residual",
    "simulated_motion",
)
"""Names of the tables of a diagnosis."""

Rows = Callable[[JointDiscrepancy], list[dict[str, Any]]]


def diagnose_tables(found: Diagnosis) -> tuple[TidyTable, ...]:
    """Return the tables of a diagnosis, in the order of DIAGNOSE_TABLES."""
    joints = found.discrepancy.joints
    tables = (
        _table("verdicts", "verdict and gap of a joint", VERDICTS, joints, _verdict),
        _table("effects", "an effect that the model of a joint misses, the strongest first", EFFECTS, joints, _effects),
        _table("effect_parameters", "a number of an effect, with its 95 % interval", PARAMETERS, joints, _parameters),
        _table("gap_ladder", "what is left of the gap after each effect, on held-out cycles", LADDER, joints, _ladder),
        _table("residual_profiles", "mean residual in a bin of one quantity", PROFILES, joints, _profiles),
        TidyTable(
            name="residual",
            summary="torque of a joint measured, of its declared model and of the grown one, low-passed alike",
            types=RESIDUAL,
            time="time_s",
            rows=tuple(_rows(one, _residual(one.traces)) for one in joints if one.traces is not None),
        ),
        TidyTable(
            name="simulated_motion",
            summary="velocity of a joint measured and simulated, on held-out cycles",
            types=SIMULATION,
            time="time_s",
            rows=tuple(_rows(one, _motion(one.simulation)) for one in joints if one.simulation is not None),
        ),
    )
    return tuple(table_in_unit(table, found.estimate.log.source.torque_unit) for table in tables)


def _table(
    name: str, summary: str, types: dict[str, type], joints: Iterable[JointDiscrepancy], rows: Rows
) -> TidyTable:
    own = ((joint, rows(joint)) for joint in joints)
    return TidyTable(
        name=name,
        summary=summary,
        types=types,
        time=None,
        rows=tuple(
            _rows(joint, {key: as_column([row[key] for row in found], kind) for key, kind in types.items()})
            for joint, found in own
            if found
        ),
    )


def _rows(joint: JointDiscrepancy, columns: dict[str, Column]) -> JointRows:
    return JointRows(joint=joint.joint, name=joint.name, columns=columns)


def _verdict(joint: JointDiscrepancy) -> list[dict[str, Any]]:
    gap, motion = joint.gap, joint.simulation
    return [
        {
            "verdict": joint.verdict,
            "message": joint.message,
            "gap_before_nm": None if gap is None else gap.before,
            "gap_after_nm": None if gap is None else gap.after,
            "floor_nm": None if gap is None else gap.floor,
            "shrink": None if gap is None else gap.shrink,
            "held_out_cycles": None if gap is None else int(gap.cycles),
            "simulation_gap_before_rad_s": None if motion is None else motion.before,
            "simulation_gap_after_rad_s": None if motion is None else motion.after,
            "detection_limit_nm": joint.detection_limit_nm,
            "omnibus_p_value": joint.omnibus_p,
            "remaining_p_value": joint.remaining_p,
        }
    ]


def _effects(joint: JointDiscrepancy) -> list[dict[str, Any]]:
    return [
        {
            "rank": rank,
            "effect": effect.name,
            "label": effect.label,
            "alternatives": " ".join((*effect.alone, *map("+".join, effect.together))),
            "p_value": effect.p_value,
            "gap_before_nm": effect.gap_before_nm,
            "gap_after_nm": effect.gap_after_nm,
            "where": effect.where,
            "decide": effect.decide,
        }
        for rank, effect in enumerate(joint.effects, start=1)
    ]


def _parameters(joint: JointDiscrepancy) -> list[dict[str, Any]]:
    return [
        {
            "effect": effect.name,
            "parameter": name,
            "value": number.value,
            "ci95_low": number.low,
            "ci95_high": number.high,
        }
        for effect in joint.effects
        for name, number in effect.parameters.items()
    ]


def _ladder(joint: JointDiscrepancy) -> list[dict[str, Any]]:
    return [{"step": step, "label": label, "rms_nm": rms} for step, (label, rms) in enumerate(joint.ladder)]


def _profiles(joint: JointDiscrepancy) -> list[dict[str, Any]]:
    every = [("declared", one) for one in joint.profiles] + [("grown", one) for one in joint.remaining]
    return [row for model, profile in every for row in _bins(model, profile)]


def _bins(model: str, profile: Profile) -> list[dict[str, Any]]:
    head = {"of": model, "axis": profile.axis, "axis_label": profile.label}
    columns = (profile.centre, profile.forwards, profile.forwards_se, profile.backwards, profile.backwards_se)
    names = ("centre", "forwards_nm", "forwards_se_nm", "backwards_nm", "backwards_se_nm")
    return [head | dict(zip(names, cells, strict=True)) for cells in zip(*columns, strict=True)]


def _residual(traces: Traces) -> dict[str, Column]:
    """Return the rows; their cycles are numbered as those of the table of cycles, from 1."""
    return {
        "time_s": traces.t,
        "cycle": traces.cycle + 1,
        "held_out": traces.locked,
        "q_rad": traces.q,
        "dq_rad_s": traces.dq,
        "measured_nm": traces.measured,
        "declared_nm": traces.before,
        "grown_nm": traces.after,
        "residual_before_nm": traces.measured - traces.before,
        "residual_after_nm": traces.measured - traces.after,
    }


def _motion(gap: SimulationGap) -> dict[str, Column]:
    """Return the motion; the gaps between cycles are no rows."""
    kept = np.isfinite(gap.t)
    return {
        "time_s": gap.t[kept],
        "dq_measured_rad_s": gap.measured[kept],
        "dq_declared_rad_s": gap.declared[kept],
        "dq_grown_rad_s": gap.grown[kept],
    }
