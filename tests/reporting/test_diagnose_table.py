"""The table of a diagnosis says in eighty columns what was found; sentences below it say the rest."""

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import takewhile

import pytest
from friction_audit.reporting.terminal.diagnose import diagnose_table, format_quantity
from friction_audit.reporting.terminal.plain import Notice, diagnose_notices, notice_lines
from rich.text import Text

from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.joint_model import ArmModel, simple_model
from friction_audit.friction.history import Coefficient
from tests.reporting.diagnosis_by_hand import (
    ALONE,
    BIAS,
    LIMIT,
    NAMED,
    NONE,
    NOT_TESTABLE,
    STRIBECK,
    VERDICTS_BY_HAND,
    coefficient,
    diagnosis,
)


def lines_of(parts: Sequence[Text]) -> list[str]:
    """Return everything, line by line."""
    return [part.plain for part in parts]


def table_of(parts: Sequence[Text]) -> list[str]:
    """Return the lines of the table alone."""
    lines = lines_of(parts)
    head = next(place for place, line in enumerate(lines) if line.startswith("joint  verdict"))
    return list(takewhile(lambda line: not re.match(r"joints? \d", line), lines[head - 1 :]))


def test_a_row_per_joint_with_its_verdict_effect_size_and_gap() -> None:
    lines = table_of(diagnose_table(diagnosis()))
    rows = {line.split()[0]: line.split() for line in lines if line[:1].isdigit()}
    assert rows["1"] == ["1", "named", "stribeck", "0.061", "0.021", "0.020", "97.6"]
    assert rows["2"] == ["2", "ambiguous", "torque_bias", "0.120", "0.030", "0.030", "100.0"]
    assert rows["3"] == ["3", "none", "-", "0.020", "-", "0.020", "-"]
    assert rows["4"] == ["4", "unexplained", "-", "0.080", "-", "0.020", "-"]
    assert rows["5"] == ["5", "not", "testable", *"-----"]
    assert rows["6"] == ["6", "data", "fault", *"-----"]


def test_the_size_stands_below_the_name_and_the_alternatives() -> None:
    lines = [line.strip() for line in table_of(diagnose_table(diagnosis()))]
    assert lines[lines.index("0.150 ± 0.010 N m") - 1].split()[2] == "stribeck"
    assert lines[lines.index("0.031 N m rms") - 1] == "or asymmetric_coulomb"


def test_the_table_fits_eighty_columns_even_with_the_longest_names() -> None:
    long = replace(BIAS, name="position_dependent_friction", alternatives=("load_dependent_friction",))
    joint = replace(NAMED, verdict="not_testable", effects=(long, STRIBECK))
    lines = table_of(diagnose_table(diagnosis((joint,))))
    assert max(map(len, lines)) <= 80
    assert not any("…" in line for line in lines)
    assert not any(line.endswith(" ") for line in lines)


def test_that_gaps_are_on_locked_cycles_is_said_once() -> None:
    lines = lines_of(diagnose_table(diagnosis()))
    assert sum("no choice was made on (9 per joint)" in line for line in lines) == 1


def test_without_any_fit_no_cycles_are_counted() -> None:
    lines = lines_of(diagnose_table(diagnosis(VERDICTS_BY_HAND[4:])))
    assert any("no choice was made on; intervals" in line for line in lines)


def test_every_joint_has_its_sentence() -> None:
    lines = lines_of(diagnose_table(diagnosis()))
    for joint in VERDICTS_BY_HAND:
        assert f"joint {joint.joint}: {joint.message}" in lines


def test_an_effect_is_told_in_numbers_and_words() -> None:
    lines = lines_of(diagnose_table(diagnosis()))
    assert (
        "  stribeck: friction above Coulomb at rest 0.150 ± 0.010 N m, speed of fading 0.100 ± 0.010 rad/s, "
        "exponent of fading 2; gap 0.061 -> 0.021 N m; p < 0.001"
    ) in lines
    assert "  simulated motion strays by 0.052 -> 0.013 rad/s rms" in lines


def test_alternatives_come_with_the_motion_that_decides() -> None:
    lines = lines_of(diagnose_table(diagnosis()))
    assert f"    to decide: {BIAS.decide}" in lines
    assert "rest" in BIAS.decide


def test_where_is_not_said_twice() -> None:
    lines = lines_of(diagnose_table(diagnosis((NAMED,))))
    assert sum("where stribeck is" in line for line in lines) == 1
    two = replace(NAMED, effects=(STRIBECK, BIAS))
    assert "    where: where torque_bias is" in lines_of(diagnose_table(diagnosis((two,))))


def test_what_the_log_cannot_show_is_for_those_who_ask() -> None:
    brief = lines_of(diagnose_table(diagnosis()))
    full = lines_of(diagnose_table(diagnosis(), verbose=True))
    said = [line for line in full if line not in brief]
    assert f"  this log cannot show torque_crosstalk, inertial_coupling: {ALONE}" in said
    assert "  warm_up in place of stribeck: BIC +41, correlation 0.31" in said
    assert "  what else is missing is below 0.0043 N m rms" in said
    assert not any("cannot show" in line for line in brief)


def test_a_declared_model_is_named() -> None:
    model = ArmModel(names=("a",), joints=(simple_model(inertia_kg_m2=1, coulomb_nm=1, viscous_nms_per_rad=1),))
    lines = lines_of(diagnose_table(diagnosis(settings=DiagnosisSettings(model=model))))
    assert "declared model: as given, its friction fitted again" in lines
    assert "declared model: inertia, Coulomb and viscous friction, fitted" in lines_of(diagnose_table(diagnosis()))


@pytest.mark.parametrize(
    ("number", "unit", "text"),
    [
        (coefficient(0.15, 0.01), "N m", "0.150 ± 0.010 N m"),
        (coefficient(0.0031, 0.0002), "s", "3.10 ± 0.20 ms"),
        (coefficient(-0.004, 0.001), "rad", "-4.0 ± 1.0 mrad"),
        (coefficient(0.0031, 0.0002), "N m", "0.0031 ± 0.0002 N m"),
        (coefficient(0.5, 0.1), "s", "0.50 ± 0.10 s"),
        (coefficient(0.001037, 0.00002), "rad/(N m)", "1.037 ± 0.020 mrad/(N m)"),
        (Coefficient(value=2.0, low=float("nan"), high=float("nan")), "1", "2"),
        (coefficient(2.0, 0.0), "1", "2"),
        (Coefficient(value=float("nan"), low=float("nan"), high=float("nan")), "s", "-"),
    ],
)
def test_small_times_and_angles_are_told_in_thousandths(number: Coefficient, unit: str, text: str) -> None:
    assert format_quantity(number, unit) == text


def test_joints_of_which_the_same_is_to_be_said_share_a_line() -> None:
    still = [replace(NOT_TESTABLE, joint=number) for number in (5, 6)]
    lines = lines_of(diagnose_table(diagnosis((NAMED, *still))))
    assert f"joints 5, 6: {NOT_TESTABLE.message}" in lines
    assert f"joint 6: {NOT_TESTABLE.message}" in lines_of(diagnose_table(diagnosis(tuple(still)), verbose=True))


def test_more_numbers_than_people_read_are_left_to_the_document() -> None:
    many = replace(BIAS, parameters={f"factor_{k}": coefficient(0.1, 0.1) for k in range(13)})
    lines = lines_of(diagnose_table(diagnosis((replace(NAMED, effects=(many,)),))))
    assert "  torque_bias: 13 numbers, see the JSON document; gap 0.120 -> 0.030 N m; p < 0.001" in lines


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("unlogged_form", 1.0, "dead band"),
        ("gravity_error_source", -1.0, "base"),
        ("gravity_error_source", -2.0, "several links"),
        ("gravity_error_source", 5.0, "number of the link 5"),
        ("coupling_source", 4.0, "model of the arm"),
    ],
)
def test_a_number_that_chooses_a_form_is_told_as_the_form(name: str, value: float, text: str) -> None:
    chosen = replace(BIAS, parameters={"torque_bias_nm": coefficient(0.1, 0.02), name: coefficient(value, 1e-4)})
    lines = lines_of(diagnose_table(diagnosis((replace(NAMED, effects=(chosen,)),))))
    assert any(f"0.100 ± 0.020 N m, {text}; gap" in line for line in lines)


def test_a_form_that_needs_no_words_gets_none() -> None:
    usual = {"torque_bias_nm": coefficient(0.1, 0.02), "load_directed": coefficient(0.0, 1e-4)}
    lines = lines_of(diagnose_table(diagnosis((replace(NAMED, effects=(replace(BIAS, parameters=usual),)),))))
    assert any("0.100 ± 0.020 N m; gap" in line for line in lines)


def test_a_number_of_no_term_is_told_with_the_unit_of_its_name() -> None:
    parameters = {"gap_rad": coefficient(0.002, 0.0001), "motion_below_hz": coefficient(18.0, 0.1)}
    parameters |= {"other_ratio": coefficient(0.5, 0.1), "warm_up_per_k": coefficient(1e-6, 0.0)}
    lines = lines_of(diagnose_table(diagnosis((replace(NAMED, effects=(replace(BIAS, parameters=parameters),)),))))
    words = "full width of the play 2.00 ± 0.10 mrad, motion below 18 Hz, other ratio 0.5; gap"
    assert any(words in line for line in lines)


def test_the_size_of_a_play_is_its_width() -> None:
    parameters = {"backlash_share": coefficient(1.2, 0.1), "gap_rad": coefficient(0.002, 0.0001)}
    play = replace(BIAS, name="backlash", parameters=parameters)
    assert any(
        "  2.00 ± 0.10 mrad" in line for line in table_of(diagnose_table(diagnosis((replace(NAMED, effects=(play,)),))))
    )


def test_what_the_locked_cycles_do_not_prove_is_told_to_be_plain_on_all() -> None:
    late = replace(BIAS, p_value=0.49)
    lines = lines_of(diagnose_table(diagnosis((replace(NAMED, effects=(late,)),))))
    assert any("p = 0.49 on the locked cycles alone, plain on all together" in line for line in lines)


def test_contacts_say_that_their_rows_are_left_out() -> None:
    touched = replace(BIAS, name="contact_event", p_value=float("nan"))
    lines = lines_of(diagnose_table(diagnosis((replace(NAMED, effects=(touched,)),))))
    assert any("gap 0.120 -> 0.030 N m as its rows are left out" in line for line in lines)


def test_limits_of_the_data_are_warnings_and_joints_share_a_line() -> None:
    notices = diagnose_notices(diagnosis())
    assert [(n.code, n.joint) for n in notices] == [("gravity_absent", None), ("standstill", 1), ("standstill", 2)]
    lines = notice_lines(notices)
    assert f"joints 1, 2: {LIMIT}" in lines
    assert "the torque column is taken as it is" in lines


def test_what_is_about_the_whole_log_is_about_no_joint() -> None:
    assert notice_lines([Notice("a", None, "late"), Notice("b", 2, "late")]) == ["late"]


def test_nothing_missing_names_what_would_have_been_seen() -> None:
    assert f"joint 3: {NONE.message}" in lines_of(diagnose_table(diagnosis((NONE,))))
