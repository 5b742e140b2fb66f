"""Tables of the terminal hold the numbers of the result in eighty columns; sentences follow them."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from friction_audit.compensation.comparison.result import Interval
from friction_audit.diagnosis.result import ContactTrace, ResidualCheck
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.joint_model import ArmModel, simple_model
from friction_audit.effects.registry import NAMES
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.pipeline import Estimate
from friction_audit.reporting.compare import claim_lines, compare_lines, count_line
from friction_audit.reporting.diagnosis import diagnose_lines
from friction_audit.reporting.diagnosis_words import joint_message, remainder_words
from friction_audit.reporting.drift import batch_lines
from friction_audit.reporting.drift_words import change_text, slope_text, span_of, total_text
from friction_audit.reporting.estimate import estimate_lines
from friction_audit.reporting.info import InfoEntry, TopicSummary, info_lines, summarize_log
from friction_audit.reporting.notices import Notice, diagnose_notices, notice_lines, reason_lines
from friction_audit.reporting.replay import replay_lines
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


@pytest.fixture(autouse=True)
def eighty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


def row(lines: list[str], start: str) -> list[str]:
    return next(line for line in lines if line.startswith(start)).split()


def width(lines: list[str]) -> int:
    """Return the width of the table in the lines."""
    rule = next(line for line in lines if line.startswith("─"))
    assert not any("…" in line for line in lines)
    return len(rule)


def test_an_estimate(seven: Estimate) -> None:
    lines = estimate_lines(seven)
    assert " ".join(row(lines, "1 ")).startswith("1 0.2450 ± 0.0074 0.400 ± 0.012 14 (1)")
    assert row(lines, "3 ")[:3] == ["3", "-", "-"]
    assert "not determined: joint 3: the joint does not move" in "\n".join(lines)
    assert width(lines) <= 80


def test_an_estimate_in_ampere(seven: Estimate) -> None:
    log = replace(seven.log, source=replace(seven.log.source, torque_unit="A"))
    text = "\n".join(estimate_lines(replace(seven, log=log)))
    assert "[A]" in text
    assert "[A s/rad]" in text
    assert "N m" not in text


def test_a_replay() -> None:
    found = log_report_by_hand.report().replay
    assert found is not None
    lines = replay_lines(found)
    numbers = found.replay.joints[0].numbers
    assert numbers is not None
    assert row(lines, "1 ")[1:4] == [
        f"{numbers.energy_without_j:.3f}", f"{numbers.energy_with_j:.3f}", f"{100 * numbers.dissipation_removed:.1f}",
    ]  # fmt: skip
    assert lines[-1].startswith("not replayed: joint 3: ")
    assert width(lines) <= 80


def test_info(seven: Estimate) -> None:
    summary = summarize_log(seven.log, seven.interaction, seven.cycles)
    text = "\n".join(info_lines(InfoEntry(path="run 1.csv", summary=summary)))
    for words in ("channel  dq = dq_{i}", "no gaps", "F_m as logged", "robot panda, 7 joints"):
        assert words in text
    topics = tuple(
        TopicSummary(name=f"/{side}/joint_states", type="sensor_msgs/JointState", messages=9, readable=side != "camera")
        for side in ("left", "right", "camera")
    )
    text = "\n".join(info_lines(InfoEntry(path="both.bag", topics=topics, message="choose one with --topic")))
    assert "/left/joint_states (sensor_msgs/JointState, 9 messages)" in text
    assert "no joint log" in text
    assert "not read: choose one with --topic" in text


def test_a_diagnosis_has_a_row_and_a_sentence_per_joint_then_its_effects() -> None:
    lines = diagnose_lines(diagnosis())
    assert row(lines, "1 ") == ["1", "named", "0.061", "0.021", "0.02", "97.6", "0.052", "0.013"]
    assert row(lines, "2 ") == ["2", "ambiguous", "0.12", "0.03", "0.03", "100", "-", "-"]
    assert row(lines, "3 ") == ["3", "adequate", "0.02", "-", "0.02", "-", "-", "-"]
    assert row(lines, "5 ") == ["5", "not", "testable", *"------"]
    for joint in diagnosis().discrepancy.joints:
        assert f"joint {joint.joint}: {joint_message(joint)}" in lines
    effects = lines[lines.index("") :]
    assert row(effects, "1 ") == ["1", "stribeck", "0.031", "9", "90", "minor", "5/5"]
    assert effects[effects.index(next(line for line in effects if line.startswith("2 "))) + 1].split() == [
        "or",
        "asymmetric_coulomb",
    ]
    numbers = "joint 1, stribeck (what stribeck does): static minus Coulomb friction 0.150 ± 0.010 N m"
    assert any(line.startswith(numbers) for line in lines)


def test_a_sentence_says_the_cause_its_size_and_what_to_do() -> None:
    assert joint_message(NAMED) == (
        "missing: stribeck (0.031 N m RMS, 9 % of friction); add it to the model (model.toml)"
    )
    assert joint_message(AMBIGUOUS).startswith("missing: torque_bias or asymmetric_coulomb (")
    assert joint_message(AMBIGUOUS).endswith("; to separate: let the joint rest unloaded for 2 s")
    assert joint_message(NONE) == "no effect above the detection limit of 0.0048 N m RMS"
    assert joint_message(UNEXPLAINED) == (
        "the residual (0.08 N m RMS, noise floor 0.02 N m) is unexplained; look at the figure residual"
    )
    named = replace(UNEXPLAINED, effects=(*NAMED.effects, *AMBIGUOUS.effects))
    assert joint_message(named).startswith("most of the residual (0.08 N m RMS, noise floor 0.02 N m) is unexplained")
    assert "; missing: stribeck (0.031 N m RMS, 9 % of friction) and 1 more; " in joint_message(named)


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
        ([("response", "past motion", 0.0)], "a linear response to past motion"),
        ([("scatter", "stroke", 0.0)], "friction that varies from cycle to cycle"),
        ([("change", "stribeck", 0.0)], "stribeck that changes within the log"),
    ],
)
def test_the_remainder_in_words(checks: list[tuple[str, str, float]], text: str) -> None:
    found = [ResidualCheck(code=code, along=along, share=0.2, frequency=f) for code, along, f in checks]
    joint = replace(NAMED, checks=tuple(found), remaining=NAMED.profiles, remainder_share=0.2)
    assert remainder_words(joint) == text
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


def test_a_parameter_that_is_not_identifiable_is_no_number() -> None:
    parameters = STRIBECK.parameters | {"stribeck_exponent": Coefficient(value=4.321, low=-math.inf, high=math.inf)}
    effect = replace(STRIBECK, parameters=parameters, not_identifiable=("stribeck_exponent",))
    text = "\n".join(diagnose_lines(diagnosis((replace(NAMED, effects=(effect,)),))))
    assert "not identifiable from this log: Stribeck exponent" in text
    assert "4.32" not in text


def test_negligible_effects_share_a_line() -> None:
    small = replace(STRIBECK, grade="negligible", size_nm=0.0004)
    joint = replace(NONE, negligible=(small, replace(small, name="warm_up")))
    assert "joint 3, negligible: stribeck 0.0004 N m RMS, warm_up 0.0004 N m RMS" in diagnose_lines(diagnosis((joint,)))


def test_a_diagnosis_fits_eighty_columns_even_with_the_longest_names() -> None:
    long = replace(BIAS, name="position_dependent_friction", alternatives=("load_dependent_friction",))
    joint = replace(NAMED, verdict="not_testable", effects=(long, STRIBECK))
    assert width(diagnose_lines(diagnosis((joint,)))) <= 80


def test_details_of_a_diagnosis_are_for_those_who_ask() -> None:
    brief, full = diagnose_lines(diagnosis()), diagnose_lines(diagnosis(), verbose=True)
    more = [line for line in full if line not in brief]
    assert f"joint 1, this log cannot show torque_crosstalk, inertial_coupling: {ALONE}" in more
    assert "joint 1, warm_up in place of stribeck: 2 ln BF +41, correlation 0.31" in more
    model = ArmModel(names=("a",), joints=(simple_model(inertia_kg_m2=1, coulomb_nm=1, viscous_nms_per_rad=1),))
    assert "nominal model: as given, its friction fitted again" in diagnose_lines(
        diagnosis(settings=DiagnosisSettings(model=model))
    )


def test_joints_with_the_same_answer_share_a_line() -> None:
    still = [replace(NOT_TESTABLE, joint=number) for number in (5, 6)]
    assert f"joints 5, 6: {NOT_TESTABLE.reason}" in diagnose_lines(diagnosis((NAMED, *still)))
    assert f"joint 6: {NOT_TESTABLE.reason}" in diagnose_lines(diagnosis(tuple(still)), verbose=True)


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({f"factor_{k}": coefficient(0.1, 0.1) for k in range(13)}, "13 parameters, in the document"),
        ({"unlogged_form": coefficient(1.0, 1e-4)}, "dead band"),
        ({"gravity_error_source": coefficient(-1.0, 1e-4)}, "base"),
        ({"gravity_error_source": coefficient(5.0, 1e-4)}, "number of the link 5"),
        ({"coupling_source": coefficient(4.0, 1e-4)}, "model of the arm"),
        (
            {"torque_bias_nm": coefficient(0.1, 0.02), "load_directed": coefficient(0.0, 1e-4)},
            "0.100 ± 0.020 N m",
        ),
        ({"motion_below_hz": coefficient(18.0, 0.1)}, "motion below 18 Hz"),
        ({"other_ratio": coefficient(0.5, 0.1), "warm_up_per_k": coefficient(1e-6, 0.0)}, "other ratio 0.5"),
    ],
)
def test_parameters_of_an_effect(parameters: dict[str, Coefficient], text: str) -> None:
    lines = diagnose_lines(diagnosis((replace(NAMED, effects=(replace(BIAS, parameters=parameters),)),)))
    assert any(line.startswith("joint 1, torque_bias (") and text in line for line in lines)


def test_drift_has_a_table_per_arm() -> None:
    lines = batch_lines(batch_by_hand.batch(ARM, batch_by_hand.arm(robot="panda-2", seed=1)))
    assert len([line for line in lines if line.startswith(tuple("1234567")) and "Coulomb" in line]) == 2 * 7
    assert " ".join(row(lines, "2 ")) == "2 Coulomb drift +15.0 ± 1.5 % 13 0 ± 0.10 % 3.3 %"
    assert width(lines) <= 80
    assert "  Coulomb: step at session 13 (12 to 14), 2026-03-21: +15.0 ± 1.5 %" in lines
    assert "  Coulomb: +0.0027 ± 0.0003 N m per session, +0.00178 ± 0.00019 per day" in lines
    assert "not compared: session 9: payload 0.7 kg, the reference had none" in lines
    assert any(line.startswith("limit exceeded: panda-1, joint 2") for line in lines)
    assert any(line.startswith("failed: logs/broken.bag: broken.bag: is truncated") for line in lines)


def test_drift_in_detail_of_many_and_of_nothing() -> None:
    verbose = batch_lines(batch_by_hand.batch(ARM), verbose=True)
    assert any(line.startswith("joint 1: no drift of Coulomb friction: a change") for line in verbose)
    assert "not compared: logs/panda-1/run_009.mcap: payload 0.7 kg, the reference had none" in verbose
    many = replace(ARM, robot="[red]arm[/red]", left_out=tuple((k, "no start") for k in range(9)))
    lines = batch_lines(batch_by_hand.batch(many))
    assert "not compared: sessions 9 of them: no start" in lines
    assert any(line.startswith("[red]arm[/red]: 24 sessions") for line in lines)
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
    lines = compare_lines([method(), other, method(method="none", label="none")], 10, 5)
    assert lines[2] == "proposed"
    assert lines[3].split() == [
        "*",
        "k",
        "=",
        "2",
        "500.0",
        "±",
        "100.0",
        "0.50",
        "±",
        "0.10",
        "0.500",
        "±",
        "0.100",
        "80%",
        "-",
    ]
    assert lines[4].endswith(" 4..>32")
    assert lines[5] == "none"
    assert sum("the median of 3 persons" in line for line in lines) == 1
    assert sum("unstable in 2 of 10 seeds, first after 3.0 s" in line for line in lines) == 1
    assert any("no setting tried is stable" in line for line in compare_lines([method(tuning_losses=3)], 10, 5))


def test_claims(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    claim = {"figure": "7b", "claim": "it holds", "paper": "yes", "ours": "1 N m", "holds": True, "note": "why"}
    lines = claim_lines([claim, claim | {"holds": False, "claim": "words and " * 20}])
    assert lines[0].split() == ["fig", "claim", "paper", "ours", "holds"]
    assert [line.split()[-1] for line in lines[2:4]] == ["yes", "NO"]
    assert lines[-1] == "7b: why"
    assert max(map(len, lines)) <= 60
    paper, own = claim | {"own": False}, claim | {"own": True, "holds": False}
    assert count_line([paper]) == "1 of 1 claims of the paper hold"
    assert count_line([paper, own]).endswith("hold; own experiments, not claims of the paper: 0 of 1")


def test_notices_of_the_same_words_share_a_line(seven: Estimate) -> None:
    notices = diagnose_notices(diagnosis())
    assert [(n.code, n.joint) for n in notices] == [("sign_unproved", None), ("standstill", 1), ("standstill", 2)]
    assert f"joints 1, 2: {LIMIT}" in notice_lines(notices)
    assert notice_lines([Notice("a", None, "late"), Notice("b", 2, "late")]) == ["late"]
    ranged = [Notice("a", k, f"{k / 10} s of 2 s, as q{k}") for k in (1, 2)]
    assert notice_lines(ranged) == ["joint 1: 0.1 s of 2 s, as q1", "joint 2: 0.2 s of 2 s, as q2"]
    ranged = [Notice("a", k, f"{k / 10} s of 2 s") for k in (2, 1, 12)]
    assert notice_lines(ranged) == ["joints 2, 1, 12: 0.1 to 1.2 s of 2 s"]
    two = [Notice("a", k, f"{k} of {k + 1}") for k in (1, 2)]
    assert notice_lines(two) == ["joint 1: 1 of 2", "joint 2: 2 of 3"]
    still = seven.friction.joints[2]
    other = replace(still, joint=5, reason="one speed only")
    assert reason_lines([seven.friction.joints[0], still, other, replace(still, joint=6)]) == [
        f"joints 3, 6: {still.reason}",
        "joint 5: one speed only",
    ]
    twice = replace(other, reason="gravity is in it. No regression either: one speed (condition 31)")
    assert reason_lines([twice, replace(twice, joint=6, reason=twice.reason.replace("31", "42.5"))]) == [
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
    ("number", "unit", "text"),
    [
        (coefficient(0.15, 0.01), "N m", "0.150 ± 0.010 N m"),
        (coefficient(0.0031, 0.0002), "s", "3.10 ± 0.20 ms"),
        (coefficient(-0.004, 0.001), "rad", "-4.0 ± 1.0 mrad"),
        (coefficient(0.0031, 0.0002), "N m", "0.0031 ± 0.0002 N m"),
        (coefficient(0.001037, 0.00002), "rad/(N m)", "1.037 ± 0.020 mrad/(N m)"),
        (coefficient(2.0, 0.0), "1", "2"),
        (UNDETERMINED, "s", "-"),
    ],
)
def test_small_times_and_angles_are_in_thousandths(number: Coefficient, unit: str, text: str) -> None:
    assert format_quantity(number, unit) == text


def test_percentages_slopes_and_p_values() -> None:
    assert format_percent(Coefficient(value=30.62, low=-1.0, high=8.9e7)) == "not identifiable"
    assert format_percent(Coefficient(value=-0.06132, low=math.nan, high=math.nan)) == "-6.1 %"
    assert format_slope(Coefficient(value=0.0026712, low=0.0024, high=0.0029424)) == "+0.0027 ± 0.0003"
    assert format_slope(Coefficient(value=-1.0, low=-1.0, high=-1.0)) == "-1"
    assert format_slope(UNDETERMINED) == format_share(math.nan) == format_p(math.nan) == "-"
    assert [format_share(share) for share in (0.0333, 0.132, 0.95, 9e4)] == ["3.3 %", "13 %", "95 %", ">100 %"]
    assert [format_p(p) for p in (1e-9, 0.0432, 1.0)] == ["< 0.001", "0.043", "1"]
    assert (enumerate_words([1]), enumerate_words([1, 2, 3])) == ("1", "1, 2 and 3")


@pytest.mark.parametrize(
    ("start_s", "shown", "iso"),
    [
        (0.0, "1970-01-01 00:00", "1970-01-01T00:00:00.000Z"),
        (1772550000.25, "2026-03-03 15:00", "2026-03-03T15:00:00.250Z"),
        (None, "-", None),
        (-5.0, "-", None),
        (math.nan, "-", None),
        (1e18, "-", None),
    ],
)
def test_starts(start_s: float | None, shown: str, iso: str | None) -> None:
    assert (format_start(start_s), iso_start(start_s)) == (shown, iso)


def test_the_span_of_sessions_is_of_those_with_a_start() -> None:
    undated = batch_by_hand.arm(2, dated=False).sessions
    assert span_of(undated) == ""
    assert span_of([*ARM.sessions[:1], *undated]) == "2026-03-03"
    assert span_of(reversed(ARM.sessions)) == "2026-03-03 to 2026-04-07"


def test_a_name_is_shown_only_where_it_adds_to_the_number() -> None:
    names = ("panda_joint3", "elbow", "joint13", "joint_03", "")
    assert [joint_label(3, name) for name in names] == ["3", "3 elbow", "3 joint13", "3", "3"]
