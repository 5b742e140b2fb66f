"""Tables say in eighty columns what the result says."""

import io
import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest
from friction_audit.reporting.json.estimate import InfoEntry, TopicSummary
from friction_audit.reporting.log_summary import summarize_log
from friction_audit.reporting.terminal.estimate import estimate_table, format_coefficient, info_table, joint_label
from friction_audit.reporting.terminal.plain import reason_lines
from rich.console import Console

from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.pipeline import Estimate

if TYPE_CHECKING:
    from rich.console import RenderableType


def shown(parts: "Iterable[RenderableType]") -> str:
    console = Console(file=io.StringIO(), width=80)
    for part in parts:
        console.print(part, soft_wrap=isinstance(part, str))
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def test_a_row_per_joint_and_the_reason_of_the_one_without(seven: Estimate) -> None:
    text = shown(estimate_table(seven))
    assert "0.2450 ± 0.0074" in text
    assert "0.400 ± 0.012" in text
    assert "14 (1)" in text
    assert "not determined: joint 3: the joint does not move" in text
    assert "estimator: weighted, combined model" in text
    assert max(map(len, text.splitlines())) <= 80
    assert "…" not in text


def test_joints_with_the_same_reason_share_a_line(seven: Estimate) -> None:
    still = seven.friction.joints[2]
    other = replace(still, joint=5, reason="one speed only")
    assert reason_lines([seven.friction.joints[0], still, other, replace(still, joint=6)]) == [
        f"joints 3, 6: {still.reason}",
        "joint 5: one speed only",
    ]


@pytest.mark.parametrize(("jitter_s", "words"), [(1.25e-4, "jitter 0.125 ms"), (2e-15, "no jitter")])
def test_jitter_that_is_rounding_is_none(jitter_s: float, words: str, seven: Estimate) -> None:
    summary = replace(summarize_log(seven.log, seven.interaction, seven.cycles), jitter_s=jitter_s)
    assert summary.jitter == words


def test_info_shows_the_mapping_the_torque_and_the_motion(seven: Estimate) -> None:
    entry = InfoEntry(path="run 1.csv", summary=summarize_log(seven.log, seven.interaction, seven.cycles))
    text = shown(info_table(entry))
    for words in ("channel  dq = dq_{i}", "no gaps", "F_m as logged", "robot panda, 7 joints"):
        assert words in text


def test_a_file_with_several_arms_lists_them() -> None:
    topics = tuple(
        TopicSummary(name=f"/{side}/joint_states", type="sensor_msgs/JointState", messages=9, readable=side != "camera")
        for side in ("left", "right", "camera")
    )
    text = shown(info_table(InfoEntry(path="both.bag", topics=topics, message="choose one with --topic")))
    assert "/left/joint_states (sensor_msgs/JointState, 9 messages)" in text
    assert "no joint log" in text
    assert "not read: choose one with --topic" in text


@pytest.mark.parametrize(
    ("coefficient", "text"),
    [
        (Coefficient(value=0.245, low=0.239, high=0.251), "0.2450 ± 0.0060"),
        (Coefficient(value=0.246, low=0.146, high=0.346), "0.25 ± 0.10"),
        (Coefficient(value=0.25, low=0.22, high=0.26), "0.250 +0.010/-0.030"),
        (Coefficient(value=-0.02, low=-0.47, high=0.43), "-0.02 ± 0.45"),
        (Coefficient(value=12.0, low=-18.0, high=42.0), "12 ± 30"),
        (Coefficient(value=0.25, low=0.25, high=0.25), "0.2500 ± 0.0001"),
        (Coefficient(value=0.25, low=math.nan, high=math.nan), "0.25"),
        (UNDETERMINED, "-"),
    ],
)
def test_digits_follow_the_interval(coefficient: Coefficient, text: str) -> None:
    assert format_coefficient(coefficient) == text


def test_a_name_is_shown_only_where_it_says_more_than_the_number() -> None:
    assert joint_label(3, "panda_joint3") == "3"
    assert joint_label(3, "elbow") == "3 elbow"
    assert joint_label(3, "joint13") == "3 joint13"
    assert joint_label(3, "joint_03") == "3"
    assert joint_label(3, "") == "3"
