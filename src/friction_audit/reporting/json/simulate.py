"""Comparison of methods -> JSON document ``friction-audit/compare/1``."""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from friction_audit.joint_log import JointLog
from friction_audit.reporting.json.document import Document, left_out_notices, new_document, to_json


def compare_document(
    told: Mapping[str, object],
    methods: Iterable[Mapping[str, object]],
    sweeps: Iterable[Mapping[str, object]],
    figures: Iterable[tuple[str, str]],
) -> Document:
    """Return the document on a comparison.

    Args:
        told: ``arm``, ``duration_s``, ``seeds``, ``tuning_seeds``, ``margin_seeds``, ``settings`` and ``effects``.
        methods: Per method and tuning what came of it.
        sweeps: Per sweep its points.
        figures: Name and path of every figure.
    """
    return {
        **new_document("compare"),
        **to_json(told),
        "methods": [to_json(one) for one in methods],
        "sweeps": [to_json(one) for one in sweeps],
        "figures": [{"figure": name, "path": path} for name, path in figures],
    }


def reproduce_document(
    claims: Iterable[Mapping[str, object]], figures: Iterable[tuple[str, str, str]], seeds: int
) -> Document:
    """Return the document on the paper's figures.

    Args:
        claims: Per claim ``figure``, ``claim``, ``paper``, ``ours``, ``value``, ``holds`` and ``note``.
        figures: Number, title and path of every figure.
        seeds: Persons that were simulated where one moves the joint.
    """
    return {
        **new_document("reproduce"),
        "seeds": seeds,
        "claims": [to_json(claim) for claim in claims],
        "figures": [{"figure": figure, "title": title, "path": path} for figure, title, path in figures],
    }


class SimulatedLog(NamedTuple):
    """What was simulated, with everything that makes it again.

    Attributes:
        scenario: Name of the scenario.
        seed: The seed.
        settings: All settings but the hidden effects, nested, units in the keys.
        effects: Hidden effects: ``joint``, ``name``, ``form`` (or None) and ``parameters``.
        sha256: Hash of the log as it was written.
    """

    scenario: str
    seed: int
    settings: Mapping[str, object]
    effects: Sequence[Mapping[str, object]]
    sha256: str


def simulate_document(
    simulated: SimulatedLog, log: JointLog, path: str, dialect: str, left_out: Sequence[str] = ()
) -> Document:
    """Return the document on a simulation.

    Args:
        simulated: What was simulated.
        log: The log.
        path: Where it was written.
        dialect: Name of the writer.
        left_out: Channels that the format has no place for.
    """
    return {
        **new_document("simulate"),
        "scenario": simulated.scenario,
        "seed": simulated.seed,
        "output": {
            "path": path,
            "sha256": simulated.sha256,
            "dialect": dialect,
            "joints": len(log.joint_names),
            "samples": len(log.t),
            "rate_hz": to_json(log.rate_hz),
            "duration_s": to_json(log.duration_s),
        },
        "joint_names": list(log.joint_names),
        "settings": to_json(simulated.settings),
        "effects": effects_document(simulated.effects),
        "warnings": [notice._asdict() for notice in left_out_notices(path, dialect, left_out)],
    }


def effects_document(effects: Iterable[Mapping[str, object]]) -> list[Document]:
    """Return the hidden effects as documents list them."""
    return [to_json(effect) for effect in effects]


def truth_document(simulated: SimulatedLog) -> Document:
    """Return the truth of a log: everything that was simulated, and the hash that tells which log it is."""
    return {
        **new_document("truth"),
        "scenario": simulated.scenario,
        "seed": simulated.seed,
        "log_sha256": simulated.sha256,
        "settings": to_json(simulated.settings),
        "effects": effects_document(simulated.effects),
    }
