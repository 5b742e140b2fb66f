"""Tables of the terminal hold the numbers of the result in eighty columns; sentences follow them."""

import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from friction_audit.compensation.comparison.result import Interval
from friction_audit.diagnosis.result import ContactTrace, ResidualCheck
from friction_audit.effects.registry import NAMES
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.io.readers.reader import Topic
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.interaction import Caution
from friction_audit.reporting.compare import compare_lines
from friction_audit.reporting.diagnosis import diagnose_lines
from friction_audit.reporting.diagnosis_words import joint_message
from friction_audit.reporting.drift_text import batch_lines
from friction_audit.reporting.drift_words import change_text, slope_text, total_text
from friction_audit.reporting.estimate import estimate_lines
from friction_audit.reporting.info import InfoEntry, info_lines, summarize_log
from friction_audit.reporting.notices import Notice, diagnose_notices, notice_lines, reason_lines
from friction_audit.reporting.replay import replay_lines
from friction_audit.reporting.sentences import SENTENCES, WORDS, sentence_of
from friction_audit.reporting.words import (
    enumerate_words,
    format_coefficient,
    format_p,
    format_percent,
    format_quantity,
    format_share,
    format_slope,
    format_start,
    iso_start,
    joint_label,
)
from tests.reporting import batch_by_hand, log_report_by_hand
from tests.reporting.conftest import build_estimate
from tests.reporting.diagnosis_by_hand import (
    ALONE,
    AMBIGUOUS,
    BIAS,
    LIMIT,
    NAMED,
    NONE,
    NOT_TESTABLE,
    STRIBECK,
    UNEXPLAINED,
    coefficient,
    diagnosis,
)

ARM = batch_by_hand.arm()
STEP, RISE = ARM.joints[1].coefficients[0], ARM.joints[4].coefficients[0]
LONG = replace(BIAS, name="position_dependent_friction", alternatives=("load_dependent_friction",))


@pytest.fixture(autouse=True)
def eighty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


def row(lines: list[str], start: str) -> str:
    return " ".join(next(line for line in lines if line.startswith(start)).split())


def in_ampere(found: Estimate) -> Estimate:
    return replace(found, log=replace(found.log, source=replace(found.log.source, torque_unit="A")))


def _replay() -> list[str]:
    found = log_report_by_hand.report().replay
    assert found is not None
    return replay_lines(found)


@pytest.mark.parametrize(
    ("lines", "rows", "sentences"),
    [
        (
            lambda: estimate_lines(build_estimate(7)),
            ["1 0.2450 ± 0.0074 0.2450 0.400 ± 0.012 0.400 14 (1)", "3 - - - - 0 (0)"],
            ["not determined: joint 3: the joint does not move"],
        ),
        (lambda: estimate_lines(in_ampere(build_estimate(1))), ["joint [A] [A] [A s/rad] [A s/rad]"], []),
        (_replay, ["3 - - -"], ["not replayed: joint 3: "]),
        (
            lambda: diagnose_lines(diagnosis()),
            [
                "1 named 0.061 0.021 0.02 97.6 0.052 0.013",
                "2 ambiguous 0.12 0.03 0.03 100 - -",
                "3 adequate 0.02 - 0.02 - - -",
                "5 not testable - - - - - -",
            ],
            ["joint 1, stribeck (what stribeck does): static minus Coulomb friction 0.150 ± 0.010 N m"],
        ),
        (
            lambda: diagnose_lines(diagnosis((replace(NAMED, verdict="not_testable", effects=(LONG, STRIBECK)),))),
            ["1 not testable"],
            [],
        ),
        (
            lambda: batch_lines(batch_by_hand.batch(ARM, batch_by_hand.arm(robot="panda-2", seed=1))),
            ["2 Coulomb drift +15.0 ± 1.5 % 13 0 ± 0.10 % 3.3 %"],
            [
                "joint 5: Coulomb friction rises by",
                "not compared: session 9: payload 0.7 kg, the reference had none",
                "limit exceeded: panda-1, joint 2",
                "failed: logs/broken.bag: broken.bag: is truncated",
            ],
        ),
    ],
    ids=["estimate", "current", "replay", "diagnosis", "longest names", "batch"],
)
def test_a_table_of_eighty_columns_and_its_sentences(
    lines: Callable[[], list[str]], rows: list[str], sentences: list[str]
) -> None:
    found = lines()
    rule = next(line for line in found if line.startswith("─"))
    assert len(rule) <= 80
    assert not any("…" in line for line in found)
    assert [one for one in rows if not row(found, one.split()[0] + " ").startswith(one)] == []
    assert [one for one in sentences if not any(line.startswith(one) for line in found)] == []


def test_info(seven: Estimate) -> None:
    summary = summarize_log(seven.log, seven.interaction, seven.cycles)
    text = "\n".join(info_lines(InfoEntry(path="run 1.csv", summary=summary)))
    for words in ("channel  dq = dq_{i}", "no gaps", "F_m as logged", "robot panda, 7 joints"):
        assert words in text
    topics = tuple(
        Topic(name=f"/{side}/state", type="JointState", messages=9, readable=side == "left") for side in ("left", "top")
    )
    text = "\n".join(info_lines(InfoEntry(path="both.bag", topics=topics, message="choose one with --topic")))
    assert "/left/state (JointState, 9 messages)" in text
    assert "/top/state (JointState, 9 messages; no joint log)" in text


def test_a_diagnosis_has_a_sentence_per_joint_then_its_effects() -> None:
    lines = diagnose_lines(diagnosis())
    for joint in diagnosis().discrepancy.joints:
        assert f"joint {joint.joint}: {joint_message(joint)}" in lines
    effects = lines[lines.index("") :]
    assert row(effects, "1 ") == "1 stribeck 0.031 9 90 minor 5/5"
    assert row(effects[effects.index(next(line for line in effects if line.startswith("2 "))) + 1 :], " ").startswith(
        "or asymmetric_coulomb"
    )
    more = [line for line in diagnose_lines(diagnosis(), verbose=True) if line not in lines]
    assert f"joint 1, this log cannot show torque_crosstalk, inertial_coupling: {ALONE}" in more
    assert "joint 1, warm_up in place of stribeck: 2 ln BF +41, correlation 0.31" in more


def test_a_sentence_says_the_cause_its_size_and_what_to_do() -> None:
    assert joint_message(NAMED) == (
        "missing: stribeck (0.031 N m RMS, 9 % of friction); add it to the model (model.toml)"
    )
    assert joint_message(AMBIGUOUS).startswith("missing: torque_bias or asymmetric_coulomb (")
    assert joint_message(AMBIGUOUS).endswith("; to separate: let the joint rest unloaded for 2 s")
    assert joint_message(NONE) == "no effect above the detection limit of 0.0048 N m RMS"
    unknown = "the residual (0.08 N m RMS, noise floor 0.02 N m) is unexplained"
    assert joint_message(UNEXPLAINED) == f"{unknown}; look at the figure residual"
    named = joint_message(replace(UNEXPLAINED, effects=(*NAMED.effects, *AMBIGUOUS.effects)))
    assert named.startswith(f"most of {unknown}; missing: stribeck (0.031 N m RMS, 9 % of friction) and 1 more; ")


def test_the_longest_sentence_has_two_hundred_characters() -> None:
    for name in NAMES:
        unsure = replace(BIAS, name=name, label="", alternatives=())
        for other in NAMES:
            pair = replace(unsure, alternatives=(other, "backlash", "stribeck"))
            for effects in ((pair, unsure), (replace(unsure, name="position_dependent_friction"), pair)):
                for verdict in ("ambiguous", "unexplained"):
                    text = joint_message(replace(NAMED, verdict=verdict, effects=effects))
                    assert len(text) <= 200, text


@pytest.mark.parametrize(
    ("checks", "text"),
    [
        ([("line", "path", 0.5), ("line", "path", 2.0)], "spectral lines at 0.5 and 2 waves per rad of path"),
        ([("curve", "speed", 0.0)], "a curve below 0.15 rad/s (against the motion)"),
        ([("curve", "displacement", 0.0)], "a curve over displacement since a reversal"),
        ([("change", "stribeck", 0.0)], "stribeck that changes within the log"),
    ],
)
def test_the_remainder_in_words(checks: list[tuple[str, str, float]], text: str) -> None:
    found = [ResidualCheck(code=code, along=along, share=0.2, frequency=f) for code, along, f in checks]
    joint = replace(NAMED, checks=tuple(found), remaining=NAMED.profiles, remainder_share=0.2)
    assert f"joint 1, 20 % of the residual is unexplained: {text}" in diagnose_lines(diagnosis((joint,)))


def test_contacts_are_left_out_and_the_rest_is_judged() -> None:
    spans = tuple((float(k), k + 0.5) for k in range(5))
    trace = ContactTrace(t=np.zeros(2), residual_nm=np.zeros(2), spans_s=spans)
    touched = replace(STRIBECK, name="contact_event", friction_share=math.nan, folds=0, chosen_in=0)
    alone = replace(NAMED, effects=(touched,), contacts=trace)
    assert joint_message(alone) == "5 contacts left out; no other effect is missing; record again without contact"
    places = "at 0.0 s (0.5 s long), at 1.0 s (0.5 s long), at 2.0 s (0.5 s long) and 2 more"
    assert any(places in line for line in diagnose_lines(diagnosis((alone,)), verbose=True))
    both = joint_message(replace(NAMED, effects=(touched, STRIBECK), contacts=trace))
    assert both.startswith("5 contacts left out; missing: stribeck")


def test_joints_and_effects_with_the_same_answer_share_a_line() -> None:
    small = replace(STRIBECK, grade="negligible", size_nm=0.0004)
    joint = replace(NONE, negligible=(small, replace(small, name="warm_up")))
    assert "joint 3, negligible: stribeck 0.0004 N m RMS, warm_up 0.0004 N m RMS" in diagnose_lines(diagnosis((joint,)))
    still = [replace(NOT_TESTABLE, joint=number) for number in (5, 6)]
    assert f"joints 5, 6: {NOT_TESTABLE.reason}" in diagnose_lines(diagnosis((NAMED, *still)))
    assert f"joint 6: {NOT_TESTABLE.reason}" in diagnose_lines(diagnosis(tuple(still)), verbose=True)


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({f"factor_{k}": coefficient(0.1, 0.1) for k in range(13)}, "13 parameters, in the document"),
        ({"unlogged_form": coefficient(1.0, 1e-4)}, "dead band"),
        ({"gravity_error_source": coefficient(5.0, 1e-4)}, "number of the link 5"),
        ({"torque_bias_nm": coefficient(0.1, 0.02), "load_directed": coefficient(0.0, 1e-4)}, "0.100 ± 0.020 N m"),
        ({"motion_below_hz": coefficient(18.0, 0.1)}, "motion below 18 Hz"),
        ({"other_ratio": coefficient(0.5, 0.1), "warm_up_per_k": coefficient(1e-6, 0.0)}, "other ratio 0.5"),
        ({"stribeck_exponent": Coefficient(value=4.321, low=-math.inf, high=math.inf)}, "not identifiable from this"),
    ],
)
def test_parameters_of_an_effect(parameters: dict[str, Coefficient], text: str) -> None:
    lost = tuple(name for name, one in parameters.items() if math.isinf(one.high))
    effect = replace(BIAS, parameters=parameters, not_identifiable=lost)
    lines = diagnose_lines(diagnosis((replace(NAMED, effects=(effect,)),)))
    assert any(line.startswith("joint 1, torque_bias (") and text in line for line in lines)
    assert "4.32" not in "\n".join(lines)


def test_drift_in_detail_of_many_and_of_nothing() -> None:
    brief, verbose = (batch_lines(batch_by_hand.batch(ARM), verbose=asked) for asked in (False, True))
    assert any(line.startswith("joint 1: no drift of Coulomb friction: a change") for line in verbose)
    for line in (
        "not compared: logs/panda-1/run_009.mcap: payload 0.7 kg, the reference had none",
        "joint 2, Coulomb: step at session 13 (12 to 14), 2026-03-21: +15.0 ± 1.5 %",
        "joint 5, Coulomb: +0.0027 ± 0.0003 N m per session, +0.00178 ± 0.00019 N m per day",
    ):
        assert line in verbose
    assert sum("Coulomb friction rose by 15" in line for line in brief) == 1
    many = replace(ARM, robot="[red]arm[/red]", left_out=tuple((k, "no start") for k in range(9)))
    lines = batch_lines(batch_by_hand.batch(many))
    assert "not compared: 9 sessions: no start" in lines
    assert any(line.startswith("[red]arm[/red]: 24 sessions, 2026-03-03 to 2026-04-07") for line in lines)
    lines = batch_lines(batch_by_hand.empty())
    assert lines[0] == "0 sessions of 0 arms: 0 computed, 0 known from the ledger, 1 of these failed"


def test_near_a_level_of_zero_drift_is_absolute() -> None:
    change = Coefficient(value=0.02, low=0.01, high=0.03)
    zero = replace(RISE, total=UNDETERMINED, change=change, smallest_drift=math.nan)
    assert total_text(zero) == "+0.020 ± 0.010 N m"
    assert slope_text(zero, zero.trend_per_session) == "+0.0027 ± 0.0003 N m"
    step = replace(STEP.change_points[0], relative=UNDETERMINED)
    assert change_text(ARM, step).endswith("2026-03-21: 0.1520 ± 0.0023 to 0.1748 ± 0.0023")
    sharp = replace(STEP.change_points[0], low=12, high=12)
    assert change_text(batch_by_hand.arm(dated=False), sharp) == "session 13: +15.0 ± 1.5 %"


def method(**changed: Any) -> Any:
    known = {"method": "energy", "label": "proposed", "tuning": SimpleNamespace(name="k = 2"), "role": "paper"}
    none = Interval(math.nan, math.nan, math.nan)
    rest = {"stable_share": 0.8, "lost_s": (), "tuning_losses": None, "margins": (), "margin": none}
    return SimpleNamespace(interval=lambda _: Interval(0.5, 0.4, 0.6), **(known | rest | changed))


def test_a_comparison_has_a_row_per_tuning_below_its_method() -> None:
    margin = Interval(8.0, 4.0, math.inf)
    other = method(role="best", margin=margin, margins=(4.0, 8.0, math.inf), lost_s=(5.0, 3.0))
    lines = compare_lines([method(), other, method(method="none", label="none", tuning_losses=3)], 10, 5)
    assert lines[2] == "proposed"
    assert " ".join(lines[3].split()) == "* k = 2 500.0 ± 100.0 0.50 ± 0.10 0.500 ± 0.100 80% -"
    assert lines[4].endswith(" 4..>32")
    assert lines[5] == "none"
    for words in ("the median of 3 persons", "unstable in 2 of 10 seeds, first after 3.0 s", "no setting tried is"):
        assert sum(words in line for line in lines) == 1


def test_every_caution_has_a_sentence() -> None:
    """The words that a sentence takes from numbers are made for codes that there are."""
    assert WORDS.keys() <= SENTENCES.keys()
    lags = {"joints": [1, 3], "lags_s": [0.002, 0.006]}
    assert sentence_of(Caution(code="dq_late", numbers=lags)).startswith("joints 1, 3: dq lags q by 2.0 to 6.0 ms (")
    arm = {"formula": "F_m = g - tau_J", "drive": "hand", "source": "tau_J", "asked": "", "compensated": True}
    assert sentence_of(Caution(code="sign_contradicts_drive", numbers=arm)) == (
        "with F_m = g - tau_J (drive hand) the net energy falls on most of the moving joints, which friction cannot "
        "do, nor does it rise with the other row of the balance; perhaps tau_compensation has the wrong sign (it is "
        "positive towards positive motion): flip it in the log, or gravity or the payload is wrong"
    )


def ranged(*messages: str) -> list[str]:
    return notice_lines(Notice("a", k, message) for k, message in enumerate(messages, start=1))


def test_notices_of_the_same_words_share_a_line(seven: Estimate) -> None:
    notices = diagnose_notices(diagnosis())
    assert [(n.code, n.joint) for n in notices] == [("sign_unproved", None), ("standstill", 1), ("standstill", 2)]
    assert f"joints 1, 2: {LIMIT}" in notice_lines(notices)
    assert notice_lines([Notice("a", None, "late"), Notice("b", 2, "late")]) == ["late"]
    assert ranged("0.2 s of 2 s", "0.1 s of 2 s", "1.2 s of 2 s") == ["joints 1, 2, 3: 0.1 to 1.2 s of 2 s"]
    assert ranged("1.5 N m over 2 rad", "3 N m over 1 rad") == ["joints 1, 2: 1.5 to 3 N m over 1 to 2 rad"]
    assert ranged("0.1 s, as q1", "0.2 s, as q2") == ["joint 1: 0.1 s, as q1", "joint 2: 0.2 s, as q2"]
    still = seven.friction.joints[2]
    one_speed = replace(still, joint=5, reason="gravity is in it. No regression either: one speed (condition 31)")
    other = replace(one_speed, joint=6, reason=one_speed.reason.replace("31", "42.5"))
    assert reason_lines([seven.friction.joints[0], still, one_speed, other]) == [
        f"joint 3: {still.reason}",
        "joints 5, 6: gravity is in it",
        "joints 5, 6: no regression either: one speed (condition 31 to 42.5)",
    ]


@pytest.mark.parametrize(
    ("value", "low", "high", "text"),
    [
        (0.245, 0.239, 0.251, "0.2450 ± 0.0060"),
        (0.246, 0.146, 0.346, "0.25 ± 0.10"),
        (0.25, 0.22, 0.26, "0.250 +0.010/-0.030"),
        (-0.02, -0.47, 0.43, "-0.02 ± 0.45"),
        (12.0, -18.0, 42.0, "12 ± 30"),
        (0.25, 0.25, 0.25, "0.2500 ± 0.0001"),
        (0.25, math.nan, math.nan, "0.25"),
        (math.nan, math.nan, math.nan, "-"),
    ],
)
def test_digits_follow_the_interval(value: float, low: float, high: float, text: str) -> None:
    assert format_coefficient(Coefficient(value=value, low=low, high=high)) == text


@pytest.mark.parametrize(
    ("shown", "text"),
    [
        (format_quantity(coefficient(0.15, 0.01), "N m"), "0.150 ± 0.010 N m"),
        (format_quantity(coefficient(0.0031, 0.0002), "s"), "3.10 ± 0.20 ms"),
        (format_quantity(coefficient(0.0031, 0.0002), "N m"), "0.0031 ± 0.0002 N m"),
        (format_quantity(coefficient(0.001037, 0.00002), "rad/(N m)"), "1.037 ± 0.020 mrad/(N m)"),
        (format_quantity(coefficient(2.0, 0.0), "1"), "2"),
        (format_quantity(UNDETERMINED, "s"), "-"),
        (format_percent(Coefficient(value=30.62, low=-1.0, high=8.9e7)), "not identifiable"),
        (format_percent(Coefficient(value=-0.06132, low=math.nan, high=math.nan)), "-6.1 %"),
        (format_slope(Coefficient(value=0.0026712, low=0.0024, high=0.0029424)), "+0.0027 ± 0.0003"),
        (format_slope(Coefficient(value=-1.0, low=-1.0, high=-1.0)), "-1"),
        (" ".join((format_slope(UNDETERMINED), format_share(math.nan), format_p(math.nan))), "- - -"),
        (", ".join(map(format_share, (0.0333, 0.132, 0.95, 9e4))), "3.3 %, 13 %, 95 %, >100 %"),
        (", ".join(map(format_p, (1e-9, 0.0432, 1.0))), "< 0.001, 0.043, 1"),
        (enumerate_words([1]), "1"),
        (enumerate_words([1, 2, 3]), "1, 2 and 3"),
        (
            ", ".join(joint_label(3, name) for name in ("panda_joint3", "elbow", "joint13", "")),
            "3, 3 elbow, 3 joint13, 3",
        ),
    ],
)
def test_numbers_and_lists(shown: str, text: str) -> None:
    assert shown == text


@pytest.mark.parametrize(
    ("start_s", "shown", "iso"),
    [
        (1772550000.25, "2026-03-03 15:00", "2026-03-03T15:00:00.250Z"),
        *((no_date, "-", None) for no_date in (None, -5.0, math.nan, 1e18)),
    ],
)
def test_starts(start_s: float | None, shown: str, iso: str | None) -> None:
    assert (format_start(start_s), iso_start(start_s)) == (shown, iso)
