"""Everything the user must know about a result, from every step of the chain, in one list."""

from collections.abc import Iterable
from typing import NamedTuple

from friction_audit.audit import Diagnosis, Estimate, LogReplay
from friction_audit.interaction.interaction import Interaction
from friction_audit.joint_log import JointLog
from friction_audit.report.units import NEWTON_METRES, in_unit

IN_AMPERE = (
    "{0}: the torque column is a motor current: coefficients are in {1} and {1} s/rad, energies in {1} rad; keys of "
    "the JSON document that end in _nm hold {1}; gravity and inertia of a model are not removed; for newton metres, "
    "multiply the column by torque constant and gear ratio"
)


class Notice(NamedTuple):
    """A warning: stable short name, joint number for people or None, one sentence."""

    code: str
    joint: int | None
    message: str

    def __str__(self) -> str:
        """Return the sentence, led by the joint that it is about unless it names it already."""
        if self.joint is None or self.message.lower().startswith(f"joint {self.joint}"):
            return self.message
        return f"joint {self.joint}: {self.message}"


def log_notices(log: JointLog) -> tuple[Notice, ...]:
    """Return what was noticed while the log was read."""
    unit = log.source.torque_unit
    own = () if unit == NEWTON_METRES else (Notice("torque_in_ampere", None, IN_AMPERE.format(log.source.path, unit)),)
    return own + tuple(Notice(found.code, found.joint, found.message) for found in log.source.findings)


def interaction_notices(interaction: Interaction) -> tuple[Notice, ...]:
    """Return what was noticed while the interaction torque was made."""
    return tuple(Notice(found.code, found.joint, found.message) for found in interaction.warnings)


def estimate_notices(estimate: Estimate) -> tuple[Notice, ...]:
    """Return what was noticed on the way from the log to the coefficients, each once."""
    friction = tuple(Notice(found.code, found.joint, found.message) for found in estimate.friction.warnings)
    every = log_notices(estimate.log) + interaction_notices(estimate.interaction) + friction
    return _each_once(every, estimate.log)


def replay_notices(found: LogReplay) -> tuple[Notice, ...]:
    """Return what was noticed on the way from the log to the replay, each once; not what only concerns the estimate."""
    own = tuple(Notice(one.code, one.joint, one.message) for one in found.replay.warnings)
    every = log_notices(found.estimate.log) + interaction_notices(found.estimate.interaction) + own
    return _each_once(every, found.estimate.log)


def diagnose_notices(found: Diagnosis) -> tuple[Notice, ...]:
    """Return what was noticed on the way from the log to the diagnosis, each once.

    With limits of the data, and where energy and torque tell different friction.

    Of joints without an answer nothing: what is wrong with them is their answer.
    """
    limits = tuple(
        Notice(finding.code, joint.joint, finding.message)
        for joint in found.discrepancy.joints
        for finding in joint.findings
        if finding.verdict == "limit" and joint.gap is not None
    )
    # Where an effect was found, it is what makes the two differ.
    disagreements = tuple(
        Notice("energy_against_torque", joint.joint, sentence)
        for joint in found.discrepancy.joints
        for sentence in joint.disagreements
        if not joint.effects
    )
    of_log = log_notices(found.estimate.log) + interaction_notices(found.estimate.interaction)
    every = of_log + limits + disagreements
    return _each_once(every, found.estimate.log)


def _each_once(every: Iterable[Notice], log: JointLog) -> tuple[Notice, ...]:
    unit = log.source.torque_unit
    return tuple(dict.fromkeys(one._replace(message=in_unit(one.message, unit)) for one in every))


def notice_lines(notices: Iterable[Notice]) -> list[str]:
    """Return one line per sentence, led by the joints that it is about."""
    about: dict[str, list[Notice]] = {}
    for notice in notices:
        about.setdefault(notice.message, []).append(notice)
    return [_line(message, same) for message, same in about.items()]


def _line(message: str, same: list[Notice]) -> str:
    joints = list(dict.fromkeys(notice.joint for notice in same))
    if len(joints) == 1 or None in joints:
        return str(same[0])
    return f"joints {', '.join(map(str, joints))}: {message}"
