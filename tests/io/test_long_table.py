"""Long tables, and tables of one joint whose torque has no clear name."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_audit.errors import InputError
from tests.io.synthetic_recordings import motion, read_text

SAMPLES = 300


def long_frame(joints: int = 3, **names: str) -> pd.DataFrame:
    arrays = motion(SAMPLES, joints)
    table: dict[str, Any] = {"time": np.repeat(arrays["t"], joints), "joint": list(range(1, joints + 1)) * SAMPLES}
    return pd.DataFrame(table | {names.get(c, c): arrays[c].reshape(-1) for c in ("q", "dq", "tau_J")})


@pytest.mark.parametrize("mapping", [{"tau_J": "effort"}, {"tau_J": "#5"}, {"t": "time:s", "tau_J": "effort"}])
def test_a_mapping_names_single_columns(tmp_path: Path, mapping: dict[str, str]) -> None:
    log = read_text(tmp_path, long_frame(tau_J="effort"), mapping=mapping)
    np.testing.assert_array_equal(log.tau_J, motion(SAMPLES)["tau_J"])
    assert log.source.channels["tau_J"] == "effort"


def test_a_mapping_wins_over_the_guess(tmp_path: Path) -> None:
    frame = long_frame(dq="speed", tau_J="effort")
    log = read_text(tmp_path, frame, mapping={"dq": "speed", "tau_interaction": "effort"})
    np.testing.assert_array_equal(log.dq, motion(SAMPLES)["dq"])
    np.testing.assert_array_equal(log.tau_interaction, motion(SAMPLES)["tau_J"])
    assert log.tau_J is None


def test_a_mapped_column_that_a_long_table_lacks(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no column for --map tau_J=efort \(did you mean effort"):
        read_text(tmp_path, long_frame(tau_J="effort"), mapping={"tau_J": "efort"})


@pytest.mark.parametrize(("name", "stated"), [("q_deg", "q_deg"), ("angle", "angle:deg"), ("q_deg", "q_deg:deg")])
def test_degrees_of_a_mapped_column(tmp_path: Path, name: str, stated: str) -> None:
    frame = long_frame(q=name)
    frame[name] = np.degrees(frame[name])
    log = read_text(tmp_path, frame, mapping={"q": stated})
    np.testing.assert_allclose(log.q, motion(SAMPLES)["q"], atol=1e-12)
    assert log.source.findings == ()


@pytest.mark.parametrize("label", ["{}", "{}.0", "J{}"])
def test_numbers_of_joints_are_sorted_as_numbers(tmp_path: Path, label: str) -> None:
    frame = long_frame(12)
    frame["joint"] = frame["joint"].map(label.format)
    shuffled = frame.sample(frac=1.0, random_state=1).sort_values("time", kind="stable")
    log = read_text(tmp_path, shuffled)
    np.testing.assert_array_equal(log.q, motion(SAMPLES, 12)["q"])
    assert log.joint_names[10:] == (("J11", "J12") if label == "J{}" else ("joint11", "joint12"))


def test_shuffled_rows_are_told_in_the_right_unit(tmp_path: Path) -> None:
    frame = long_frame(1).drop(columns="joint").sample(frac=1.0, random_state=1)
    with pytest.raises(InputError, match=r"time \(time \[s\]\) goes back at"):
        read_text(tmp_path, frame)


@pytest.mark.parametrize("name", ["torque", "tau", "effort", "torque_1"])
@pytest.mark.parametrize("is_long", [True, False])
def test_a_torque_of_the_only_joint_may_be_either(tmp_path: Path, name: str, *, is_long: bool) -> None:
    if is_long and name == "torque_1":
        pytest.skip("a long table has no numbers in its columns' names")
    frame = long_frame(1, tau_J=name)
    frame = frame if is_long else frame.drop(columns="joint")
    findings = read_text(tmp_path, frame).source.findings
    assert [finding.code for finding in findings] == ["torque_ambiguous"]
    assert f"--map tau_interaction={name}" in findings[0].message
    log = read_text(tmp_path, frame, mapping={"tau_interaction": name})
    assert (log.tau_J, log.source.findings) == (None, ())
    assert read_text(tmp_path, frame, mapping={"tau_J": name}).source.findings == ()


def test_a_clear_torque_is_not_doubted(tmp_path: Path) -> None:
    one = long_frame(1).drop(columns="joint")
    assert read_text(tmp_path, one).source.findings == ()
    gravity = one.rename(columns={"tau_J": "torque"}).assign(gravity=0.0)
    assert read_text(tmp_path, gravity).source.findings == ()
    assert read_text(tmp_path, long_frame(3, tau_J="torque")).source.findings == ()
