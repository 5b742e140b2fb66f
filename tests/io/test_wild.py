"""Wild samples are left out and named; what joints do is not."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_audit.joint_log import Float, JointLog
from tests.in_this_process import run
from tests.io.synthetic_recordings import motion, read_text, recording
from tests.io.test_checks import codes, finding, vetted

TRUTH = {"coulomb_nm": 0.3, "viscous_nms_per_rad": 0.1}


def rig() -> pd.DataFrame:
    """Return the log of a joint with friction of known size, 0.3 N m and 0.1 N m s/rad, at 100 Hz."""
    t = np.arange(1200) / 100.0
    dq = 1.5 * np.cos(3.0 * t)
    friction = 0.3 * np.sign(dq) + 0.1 * dq
    return pd.DataFrame({"t": t, "q_1": 0.5 * np.sin(3.0 * t), "dq_1": dq, "tau_interaction_1": friction})


CASES: Mapping[str, tuple[str, list[int], list[float]]] = {
    "torque": ("tau_interaction_1", [600], [300.0]),
    "torque, against the motion": ("tau_interaction_1", [600], [-300.0]),
    "torque, absurd": ("tau_interaction_1", [600], [1e8]),
    "torque, behind a filter": ("tau_interaction_1", [600, 601, 602, 603], [120.0, 300.0, 110.0, 30.0]),
    "torque, at a reversal": ("tau_interaction_1", [628], [300.0]),
    "torque, in the first row": ("tau_interaction_1", [0], [300.0]),
    "torque, in the last row": ("tau_interaction_1", [1199], [300.0]),
    "torque, four times": ("tau_interaction_1", [100, 400, 700, 1000], [300.0, -250.0, 90.0, 40.0]),
    "velocity": ("dq_1", [600], [-50.0]),
    "position": ("q_1", [600], [3.0]),
}


@pytest.mark.parametrize("case", CASES)
def test_a_wild_sample_is_left_out_and_named_and_the_estimate_is_as_without(case: str, tmp_path: Path) -> None:
    column, rows, values = CASES[case]
    table = rig()
    table.loc[rows, column] = values
    table.to_csv(tmp_path / "rig.csv", index=False)
    answer = run("estimate", tmp_path / "rig.csv", "--json")
    document = answer.document()
    assert answer.code == 6
    for coefficient, truth in TRUTH.items():
        assert document["joints"][0][coefficient]["value"] == pytest.approx(truth, abs=2e-3)
    (found,) = [one for one in document["warnings"] if one["code"] == "wild_samples"]
    assert found["joint"] == 1
    for said in (column.removesuffix("_1"), f"(row {rows[0] + 1})", f"at {rows[0] / 100:g} s"):
        assert said in found["message"]


def test_the_time_of_a_wild_sample_in_a_part_is_that_of_the_whole_log(tmp_path: Path) -> None:
    table = rig()
    table.loc[600, "tau_interaction_1"] = 300.0
    message = finding(read_text(tmp_path, table, t_start_s=4.0, t_end_s=9.0), "wild_samples").message
    assert "at 6 s" in message
    assert "(row " not in message or "(row 601)" in message


def shaken(torque: Float, q: Float, dq: Float) -> JointLog:
    """Return a log at 100 Hz whose torque, position and velocity have something added from row 600 on."""
    arrays = motion(1200, 2, 100.0)
    for channel, added in (("tau_J", torque), ("q", q), ("dq", dq)):
        arrays[channel][600 : 600 + len(added), 0] += added
    t = arrays.pop("t")
    return vetted(replace(recording(1200, 2), t=t, channels={c: np.asfortranarray(a) for c, a in arrays.items()}))


def test_an_impact_that_the_velocity_shows_is_kept() -> None:
    """A blow of 20 N m over 30 ms on 0.5 kg m^2: the velocity jumps by 1.2 rad/s, and the position follows."""
    blow = np.array([10.0, 20.0, 20.0, 10.0, -10.0, -20.0, -20.0, -10.0])
    dq = np.cumsum(blow) * 0.01 / 0.5
    q = np.cumsum(dq - 0.5 * np.diff(dq, prepend=0.0)) * 0.01
    log = shaken(blow, np.append(q, np.full(592, q[-1])), dq)
    assert "wild_samples" not in codes(log)
    assert len(log.t) == 1200


def test_a_torque_that_stays_is_a_load() -> None:
    nothing = np.empty(0)
    assert "wild_samples" not in codes(shaken(np.full(600, 40.0), nothing, nothing))
    assert "wild_samples" not in codes(shaken(np.full(20, 40.0), nothing, nothing))


def test_coarse_encoders_and_flicker_at_standstill_are_kept() -> None:
    arrays = motion(6000, 3)
    arrays["q"] = np.round(arrays["q"] / 2e-3) * 2e-3
    arrays["q"][:, 2], arrays["dq"][:, 2], arrays["tau_J"][:, 2] = 1.0, 0.0, 0.0
    arrays["q"][3000, 2], arrays["tau_J"][2000, 2] = 1.002, 1.0
    t = arrays.pop("t")
    log = vetted(replace(recording(6000), t=t, channels={c: np.asfortranarray(a) for c, a in arrays.items()}))
    assert "wild_samples" not in codes(log)


def test_the_row_s_number_is_not_named_where_rows_were_left_out_before() -> None:
    given_recording = recording()
    given_recording.channels["q"][10, 0] = np.nan
    given_recording.channels["tau_J"][20, 2] = 300.0
    message = finding(vetted(given_recording), "wild_samples").message
    assert "at 0.02 s" in message
    assert "row " not in message.replace("1 row left out", "")


@pytest.mark.parametrize(
    ("column", "rows"), [("q_1", (130, 190)), ("dq_1", (640, 700)), ("q_1", (0, 40)), ("q_1", (1170, 1200))]
)
def test_a_block_of_zeros_is_left_out(column: str, rows: tuple[int, int], tmp_path: Path) -> None:
    table = rig()
    table.loc[slice(rows[0], rows[1] - 1), column] = 0.0
    log = read_text(tmp_path, table)
    message = finding(log, "wild_samples").message
    assert f"{rows[1] - rows[0]} rows left out" in message
    assert len(log.t) == 1200 - (rows[1] - rows[0])


def test_frames_of_zeros_are_left_out(tmp_path: Path) -> None:
    table, lost = rig(), np.random.default_rng(3).choice(np.arange(1200), 60, replace=False)
    lost = lost[np.abs(table.loc[lost, "q_1"]) > 0.1]
    table.loc[lost, ["q_1", "dq_1", "tau_interaction_1"]] = 0.0
    kept = read_text(tmp_path, table).q[:, 0]
    assert np.count_nonzero(kept == 0.0) <= 1 + 0.1 * len(lost)


def test_zeros_that_a_joint_can_have_are_kept(tmp_path: Path) -> None:
    table = rig()
    rest = table["dq_1"].abs() < 0.6  # a driver that takes slow motion for rest
    table.loc[rest, "dq_1"] = 0.0
    still = pd.concat([table.assign(q_1=0.0, dq_1=0.0, tau_interaction_1=0.0)[:300], table.assign(t=table["t"] + 3.0)])
    later = table.assign(t=table["t"] + 30.0)[20:]  # a pause of the recording, in which the joint left zero
    still = pd.concat([still, table.assign(t=table["t"] + 20.0, q_1=0.0, dq_1=0.0)[:100], later])
    assert "wild_samples" not in codes(read_text(tmp_path, still))
