"""Tables of the terminal hold the numbers of the result in eighty columns; sentences follow them."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.result import ContactTrace
from friction_audit.effects.registry import NAMES
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.interaction import Caution, quoted
from friction_audit.reporting import drift_words, words
from friction_audit.reporting.diagnosis import diagnose_lines
from friction_audit.reporting.diagnosis_words import joint_message
from friction_audit.reporting.drift import batch_lines
from friction_audit.reporting.estimate import estimate_lines
from friction_audit.reporting.notices import Notice, diagnose_notices, notice_lines, reason_lines, sentence_of, text_of
from friction_audit.reporting.replay import replay_lines
from tests.reporting import batch_by_hand, log_report_by_hand
from tests.reporting.conftest import build_estimate
from tests.reporting.diagnosis_by_hand import ALONE, BIAS, LIMIT, NAMED, NOT_TESTABLE, STRIBECK, coefficient, diagnosis

ARM = batch_by_hand.arm()
LONG = replace(BIAS, name="position_dependent_friction", alternatives=("load_dependent_friction",))


@pytest.fixture(autouse=True)
def eighty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


def row(lines: list[str], start: str) -> str:
    return " ".join(next(line for line in lines if line.startswith(start)).split())


def in_ampere(found: Estimate, unit: str = "A") -> Estimate:
    return replace(found, log=replace(found.log, source=replace(found.log.source, torque_unit=unit)))


@pytest.mark.parametrize(("lines", "rows", "sentences"), [
    (
        lambda: estimate_lines(build_estimate(7)),
        ["1 0.2467 ± 0.0040 0.2459 0.3966 ± 0.0054 0.3974 15 (0)", "3 - - - - 0 (0)"],
        ["not determined: joint 3: did not move"],
    ),
    (lambda: estimate_lines(in_ampere(build_estimate(1))), ["joint [A] [A] [A s/rad] [A s/rad]"], []),
    (lambda: replay_lines(log_report_by_hand.report().replay),  # type: ignore[arg-type]
     ["3 - - -"], ["not replayed: joint 3: "]),
    (
        lambda: diagnose_lines(diagnosis()),
        ["1 named 0.061 0.021 0.02 97.6 0.052 0.013", "2 ambiguous 0.12 0.03 0.03 100 - -",
         "3 adequate 0.02 - 0.02 - - -", "5 not testable - - - - - -"],
        ["joint 1: missing: stribeck (0.031 N m RMS, 9 % of friction); add it to the model (model.toml)",
         "joint 2: missing: torque_bias or asymmetric_coulomb (0.031 N m RMS, 9 % of friction); to separate: ",
         "joint 3: no effect below 17 Hz exceeds the detection limit of 0.0048 N m RMS",
         "joint 4: 30 % of the residual (0.08 N m RMS, noise floor 0.02 N m) is unexplained; look at the figure",
         "joint 1, stribeck (what stribeck does): static minus Coulomb friction 0.150 ± 0.010 N m"],
    ),
    (
        lambda: diagnose_lines(diagnosis(), verbose=True), [],
        [f"joint 1, this log cannot show torque_crosstalk, inertial_coupling: {ALONE}",
         "joint 1, warm_up in place of stribeck: 2 ln BF +41, correlation 0.31",
         "joint 4, 30 % of the residual is unexplained: a spectral line at 13 Hz"],
    ),
    (lambda: diagnose_lines(diagnosis(replace(NAMED, verdict="not_testable", effects=(LONG, STRIBECK)))),
     ["1 not testable"], []),
    (
        lambda: batch_lines(batch_by_hand.batch(ARM, batch_by_hand.arm(robot="panda-2"))),
        ["2 Coulomb drift +15.0 ± 1.5 % 13 0 ± 0.10 % 3.3 %"],
        ["panda-1: 24 sessions, 2026-03-03 to 2026-04-07, 23 compared; joint 2: Coulomb friction rose by 15 % (14 to",
         "not compared: session 9 (run_009.mcap): payload 0.7 kg, the reference had none",
         "Where friction drifts: check", "limit exceeded: panda-1, joint 2", "Friction drifts on 2 of 2 arms: panda-1",
         "failed: logs/broken.bag: broken.bag: is truncated"],
    ),
], ids=["estimate", "current", "replay", "diagnosis", "verbose", "longest names", "batch"])  # fmt: skip
def test_a_table_and_its_sentences(lines: Callable[[], list[str]], rows: list[str], sentences: list[str]) -> None:
    found = lines()
    rule = next(line for line in found if line.startswith("─"))
    assert len(rule) <= 80
    assert not any("…" in line for line in found)
    assert [one for one in rows if not row(found, one.split()[0] + " ").startswith(one)] == []
    assert [one for one in sentences if not any(line.startswith(one) for line in found)] == []


def test_a_narrow_terminal_cuts_no_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "22")
    found = estimate_lines(build_estimate(1))
    assert row(found, "1 ").startswith("1 0.2473 ± 0.0051 0.2480 0.3965 ± 0.0061 0.3957 16 (0)")
    assert all(line == line.rstrip() for line in found)


def test_the_longest_sentence_has_two_hundred_characters() -> None:
    for name in NAMES:
        unsure = replace(BIAS, name=name, label="", alternatives=())
        for other in NAMES:
            pair = replace(unsure, alternatives=(other, "backlash", "stribeck"))
            for effects in ((pair, unsure), (replace(unsure, name="position_dependent_friction"), pair)):
                for verdict in ("ambiguous", "unexplained"):
                    text = joint_message(replace(NAMED, verdict=verdict, effects=effects))
                    assert len(text) <= 200, text


def test_contacts_are_left_out_and_joints_with_the_same_answer_share_a_line() -> None:
    spans = tuple((float(k), k + 0.5) for k in range(5))
    trace = ContactTrace(t=np.zeros(2), residual_nm=np.zeros(2), spans_s=spans)
    touched = replace(STRIBECK, name="contact_event", friction_share=math.nan, folds=0, chosen_in=0)
    lines = "\n".join(diagnose_lines(diagnosis(replace(NAMED, effects=(touched,), contacts=trace)), verbose=True))
    assert "5 contacts left out; no other effect is missing; record again without contact" in lines
    assert "at 0.0 s (0.5 s long), at 1.0 s (0.5 s long), at 2.0 s (0.5 s long) and 2 more" in lines
    still = [replace(NOT_TESTABLE, joint=number) for number in (5, 6)]
    assert f"joints 5, 6: {text_of(NOT_TESTABLE.reason)}" in diagnose_lines(diagnosis(NAMED, *still))
    assert f"joint 6: {text_of(NOT_TESTABLE.reason)}" in diagnose_lines(diagnosis(*still), verbose=True)


@pytest.mark.parametrize(("parameters", "text"), [
    ({f"factor_{k}": coefficient(0.1, 0.1) for k in range(13)}, "13 parameters, in the document"),
    ({"unlogged_form": coefficient(1.0, 1e-4)}, "dead band"),
    ({"other_ratio": coefficient(0.5, 0.1), "warm_up_per_k": coefficient(1e-6, 0.0)}, "other ratio 0.5"),
    ({"delay_s": coefficient(0.003, 1e-4), "delayed_load": coefficient(1.0, 0.0)}, " ms, the load is late too"),
    ({"stribeck_exponent": Coefficient(value=4.321, low=-math.inf, high=math.inf)}, "not identifiable from this"),
])  # fmt: skip
def test_parameters_of_an_effect(parameters: dict[str, Coefficient], text: str) -> None:
    lost = tuple(name for name, one in parameters.items() if math.isinf(one.high))
    effect = replace(BIAS, parameters=parameters, not_identifiable=lost)
    lines = diagnose_lines(diagnosis(replace(NAMED, effects=(effect,))))
    assert any(line.startswith("joint 1, torque_bias (") and text in line for line in lines)
    assert "in the document" not in "".join(diagnose_lines(diagnosis(replace(NAMED, effects=(effect,))), verbose=True))


def test_drift_in_detail_of_many_and_of_nothing() -> None:
    verbose = batch_lines(batch_by_hand.batch(ARM), verbose=True)
    for line in (
        "not compared: logs/panda-1/run_009.mcap: payload 0.7 kg, the reference had none",
        "joint 2, Coulomb: step at session 13 (12 to 14), 2026-03-21: +15.0 ± 1.5 %",
        "joint 5, Coulomb: +0.0027 ± 0.0003 N m per session, +0.00178 ± 0.00019 N m per day",
    ):
        assert line in verbose
    many = replace(ARM, robot="[red]arm[/red]", left_out=tuple((k, quoted("no start")) for k in range(9)))
    lines = batch_lines(batch_by_hand.batch(many))
    assert "not compared: 9 sessions: no start" in lines
    assert any(line.startswith("[red]arm[/red]: 24 sessions, 2026-03-03 to 2026-04-07") for line in lines)
    assert batch_lines(batch_by_hand.empty())[0].startswith("0 sessions of 0 arms: 0 computed, 0 known from the ledger")
    fall = Coefficient(value=-3.97, low=-6.2, high=-0.25)
    assert drift_words.how_much(fall, UNDETERMINED, "N m") == "397 % (25 to 620 %)"
    wide = replace(ARM.joints[0].coefficients[0], smallest_drift=2.28)
    assert drift_words.smallest_text(wide) == "228 %"
    assert "a change of 228 % is" in drift_words.headline(wide, ())
    assert drift_words.smallest_text(replace(wide, smallest_drift=math.inf)) == ">1000 %"


def test_sessions_that_do_not_fit_are_named_with_the_fault_of_their_torque() -> None:
    """A recording with two exchanged joints was left out without a word."""
    arm = batch_by_hand.arm()
    first = replace(arm.joints[0], coefficients=tuple(replace(c, isolated=(3,)) for c in arm.joints[0].coefficients))
    second = replace(arm.joints[1], coefficients=tuple(replace(c, isolated=(3,)) for c in arm.joints[1].coefficients))
    fault = Caution(code="sign_disagrees", joint=2, numbers={"verdict": "falls", "torque": -0.3, "error": 0.1})
    sessions = list(arm.sessions)
    sessions[3] = replace(sessions[3], codes=("sign_disagrees",), warnings=(fault,))
    found = arm.joints[2].coefficients[0]
    unsure = replace(found.values[5], low=found.values[5].low - 1.0, high=found.values[5].high + 1.0)
    found = replace(found, values=(*found.values[:5], unsure, *found.values[6:]))
    third = replace(arm.joints[2], coefficients=(found, *arm.joints[2].coefficients[1:]))
    odd = replace(arm, joints=(first, second, third, *arm.joints[3:]), sessions=tuple(sessions))
    lines = batch_lines(batch_by_hand.batch(odd))
    assert row(lines, "does not fit: session 4 (").endswith("joints 1 and 2: exchanged columns, another sign or unit?")
    assert row(lines, f"does not fit: session {found.sessions[5] + 1} (").endswith(": joint 3")  # a wide interval
    assert sentence_of(fault) in row(lines, "only in session 4 (")
    assert not any(line.startswith(("does not fit", "only in")) for line in batch_lines(batch_by_hand.batch(arm)))


def ranged(*messages: str) -> list[str]:
    return notice_lines(Notice("a", k, message) for k, message in enumerate(messages, start=1))


def test_notices_of_the_same_words_share_a_line(seven: Estimate) -> None:
    notices = diagnose_notices(diagnosis())
    assert [(n.code, n.joint) for n in notices] == [("standstill", 1), ("standstill", 2)]
    assert f"joints 1, 2: {LIMIT}" in notice_lines(notices)
    assert notice_lines([Notice("a", None, "late"), Notice("b", 2, "late")]) == ["late"]
    assert ranged("0.2 s of 2 s", "0.1 s of 2 s", "1.2 s of 2 s") == ["joints 1, 2, 3: 0.1 to 1.2 s of 2 s"]
    assert ranged("1.5 N m over 2 rad", "3 N m over 1 rad") == ["joints 1, 2: 1.5 to 3 N m over 1 to 2 rad"]
    assert ranged("1 ± 2 A", "3 ± 4 A", "-1 to 2 s", "-3 to 4 s")[1::2] == ["joint 2: 3 ± 4 A", "joint 4: -3 to 4 s"]
    assert ranged("0.1 s, as q1", "0.2 s, as q2") == ["joint 1: 0.1 s, as q1", "joint 2: 0.2 s, as q2"]
    still = seven.friction.joints[2]
    reasons = [(Caution("constant_position"), Caution("one_speed_in_rows", numbers={"mean": v})) for v in (0.31, 0.4)]
    alike = [replace(still, joint=5 + place, reason=reason) for place, reason in enumerate(reasons)]
    position, speed = reason_lines([seven.friction.joints[0], *alike])
    assert position.startswith("joints 5, 6: the position never changes")
    assert speed.startswith("joints 5, 6: no torque regression either: all motion has one speed (0.31 to 0.4 rad/s)")


@pytest.mark.parametrize(("shown", "text"), [
    (words.format_coefficient(coefficient(0.245, 0.006)), "0.2450 ± 0.0060"),
    (words.format_coefficient(Coefficient(value=0.25, low=0.22, high=0.26)), "0.250 +0.010/-0.030"),
    (words.format_coefficient(coefficient(-0.02, 0.45)), "-0.02 ± 0.45"),
    (words.format_coefficient(coefficient(0.25, 0.0)), "0.2500 ± 0.0001"),
    (words.format_coefficient(coefficient(0.25, math.nan)), "0.25"),
    (words.format_coefficient(UNDETERMINED), "-"),
    (words.format_start(1772550000.25), "2026-03-03 15:00"),
    (words.iso_start(1772550000.25), "2026-03-03T15:00:00.250Z"),
    *((f"{words.format_start(one)} {words.iso_start(one)}", "- None") for one in (None, -5.0, math.nan, 1e18)),
    (words.with_unit(coefficient(0.15, 0.01), "N m"), "0.150 ± 0.010 N m"),
    (words.with_unit(coefficient(0.0031, 0.0002), "s"), "3.10 ± 0.20 ms"),
    (words.with_unit(coefficient(0.001037, 0.00002), "rad/(N m)"), "1.037 ± 0.020 mrad/(N m)"),
    (words.with_unit(coefficient(2.0, 0.0), "1"), "2"),
    (words.with_unit(UNDETERMINED, "s"), "-"),
    (words.format_percent(Coefficient(value=30.62, low=-1.0, high=8.9e7)), "not identifiable"),
    (words.format_percent(Coefficient(value=-0.06132, low=math.nan, high=math.nan)), "-6.1 %"),
    (words.format_slope(Coefficient(value=0.0026712, low=0.0024, high=0.0029424)), "+0.0027 ± 0.0003"),
    (" ".join((words.format_slope(UNDETERMINED), words.format_share(math.nan), words.format_p(math.nan))), "- - -"),
    (", ".join(map(words.format_share, (0.0333, 0.132, 0.95, 9e4))), "3.3 %, 13 %, 95 %, >100 %"),
    (", ".join(map(words.format_p, (1e-9, 0.0432, 1.0))), "< 0.001, 0.043, 1"),
    (words.in_unit("left 12.1 J in its ledger", "A"), "left 12.1 A rad in its ledger"),
    (words.enumerate_words([1, 2, 3]), "1, 2 and 3"),
    (words.joint_label(2, "left_arm_shoulder_lift_joint", 16), "2 left…oulder_lift"),
    (" ".join(words.joint_label(3, n) for n in ("panda_joint3", "elbow", "joint13", "")), "3 3 elbow 3 joint13 3"),
])  # fmt: skip
def test_numbers_and_lists(shown: str, text: str) -> None:
    assert shown == text


def test_what_noise_hides_and_what_a_recorder_does_is_said_where_the_answer_stands() -> None:
    assert NAMED.traces is not None
    assert NAMED.simulation is not None
    lines = "\n".join(diagnose_lines(diagnosis(NAMED)))
    assert "lost in the noise" not in lines
    assert "motion is worse" not in lines
    noisy = replace(NAMED, traces=replace(NAMED.traces, corner_hz=4.0), effects=(replace(STRIBECK, name="time_delay"),))
    noisy = replace(noisy, simulation=replace(NAMED.simulation, after=9.0))
    lines = "\n".join(diagnose_lines(diagnosis(noisy)))
    assert "joint 1, what is faster than 4 Hz is lost in the noise of the acceleration" in lines
    assert "time_delay: a low-pass filter in the recorder" in lines
    assert "joint 1, the simulated motion is worse with the effects" in lines
    assert "; what is faster than 4 Hz" in joint_message(replace(noisy, verdict="adequate", effects=()))
