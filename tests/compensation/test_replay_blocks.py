"""A replay along the recorded motion does not depend on the blocks in which the log is read."""

from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import given, settings, strategies as st

from friction_audit.compensation.law import Coefficients, EnergyCompensator
from friction_audit.compensation.settings import Competitor, ReplaySettings, energy_compensator
from friction_audit.joint_log import JointLog
from friction_audit.log_in_blocks import LogInBlocks
from friction_audit.pipeline import AuditSettings, LogReplay, replay_log
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.reporting.replay import replay_document
from tests.friction.test_blocks import in_blocks, recorded
from tests.pinned.commands import pinned
from tests.pinned.test_pinned import differences

BY_HAND = AuditSettings(torque=TorqueSettings(torque="interaction", drive="hand"))
SETTINGS = {
    "energy": ReplaySettings(),
    "limited": ReplaySettings(compensator=energy_compensator(factor=2.0), max_torque_nm=0.3, max_torque_rate_nm_s=5.0),
    "over": ReplaySettings(compensator=energy_compensator("coulomb", factor=1.5)),
    "fixed": ReplaySettings(competitor=Competitor(name="fixed")),
    "sigmoid": ReplaySettings(competitor=Competitor(name="sigmoid")),
    "lugre": ReplaySettings(competitor=Competitor(name="lugre")),
    "diverges": ReplaySettings(
        compensator=EnergyCompensator(forced=Coefficients(coulomb_nm=2e4), forced_from_cycle=5, passivity=False)
    ),
}


def replayed(log: JointLog, name: str) -> LogReplay:
    return replay_log(log, BY_HAND, SETTINGS[name])


def numbers(found: LogReplay) -> dict[str, Any]:
    """Return all that the document says of the joints and warns of, path by path."""
    document = replay_document(found)
    return pinned([document["joints"], document["warnings"]], "")


@settings(max_examples=settings().max_examples // 2)  # one takes a quarter of a second
@given(
    name=st.sampled_from([*SETTINGS]),
    seed=st.integers(0, 1000),
    sizes=st.lists(st.integers(1, 4000), min_size=1, max_size=60),
    compensated=st.booleans(),
)
def test_block_borders_change_nothing(name: str, seed: int, sizes: list[int], compensated: bool) -> None:
    log = recorded(seed)
    if compensated:
        log = replace(log, tau_compensation=np.asfortranarray(0.1 * np.tanh(log.dq / 0.05)))
    borders = [border for border in np.cumsum(sizes).tolist() if border < len(log.t)]
    part, whole = replayed(in_blocks(log, borders), name), replayed(log, name)
    assert not differences({name: numbers(part)}, {name: numbers(whole)}, relative=1e-9)
    assert all(joint.replayed is None or len(joint.replayed.t) == 0 for joint in part.replay.joints)


def test_a_joint_that_moves_otherwise_takes_the_whole_log() -> None:
    log = recorded(3)
    settings = ReplaySettings(assume="same-torque")
    found = replay_log(in_blocks(log, [1000]), BY_HAND, settings)
    assert not isinstance(found.estimate.log, LogInBlocks)
    assert numbers(found) == numbers(replay_log(log, BY_HAND, settings))
