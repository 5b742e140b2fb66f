"""A log that was simulated -> JSON document ``friction-audit/simulate/1``."""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from friction_audit.joint_log import JointLog
from friction_audit.report.convert_document import left_out_notices
from friction_audit.report.document import Document, new_document, to_json


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
