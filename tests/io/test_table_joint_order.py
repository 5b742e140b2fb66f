"""Joints of a table come by name, in any order, by columns or by rows; a torque of a single joint is ambiguous."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from friction_audit.errors import InputError, UsageError
from friction_audit.io.readers import ReadOptions, read_log
from friction_audit.io.writers.write_log import write_log
from friction_audit.joint_log import JointLog, Source
from tests.io.synthetic_recordings import motion, read_text, refused, tidy_frame

SAMPLES = 300
FIELDS = {"position": "q", "velocity": "dq", "effort": "tau_J"}
ORDER = (3, 1, 6, 0, 2, 5, 4)
PANDA = tuple(f"panda_joint{i}" for i in range(1, 8))
FINGERS = ("panda_finger_joint1", "panda_finger_joint2")
SCRAMBLED = (FINGERS[0], *(PANDA[joint] for joint in ORDER), FINGERS[1])


def values_of(names: Sequence[str], field: str) -> Any:
    """Return the motion of joints 1 to 7 in the columns of their names, shape (n, names); fingers hold 9."""
    arrays = motion(SAMPLES, 7)[FIELDS[field]]
    columns = [np.full(SAMPLES, 9.0) if "finger" in name else arrays[:, int(name[-1]) - 1] for name in names]
    return np.column_stack(columns)


def write(folder: Path, names: Sequence[str], dialect: str, name: str) -> Path:
    channels = {channel: values_of(names, field) for field, channel in FIELDS.items()}
    source = Source(path="made", sha256="", format="made")
    log = JointLog(t=motion(SAMPLES)["t"], **channels, joint_names=tuple(names), source=source)
    write_log(log, folder / name, dialect=dialect, overwrite=True)
    return folder / name


write_rostopic = partial(write, dialect="csv-rostopic", name="rostopic.csv")


def write_long_parquet(folder: Path, names: Sequence[str]) -> Path:
    pd.read_csv(write(folder, names, "csv-long", "long.csv")).to_parquet(folder / "long.parquet")
    return folder / "long.parquet"


def write_lists(folder: Path, names: Sequence[str], kind: pa.DataType | None = None) -> Path:
    table: dict[str, Any] = {"time": motion(SAMPLES)["t"]}
    table["name"] = pa.array([list(names)] * SAMPLES, type=kind or pa.list_(pa.string()))
    table |= {field: values_of(names, field).tolist() for field in FIELDS}
    pq.write_table(pa.table(table), folder / "lists.parquet")
    return folder / "lists.parquet"


def write_columns(folder: Path, names: Sequence[str]) -> Path:
    table: dict[str, Any] = {"time": motion(SAMPLES)["t"]}
    table |= {f"{name}.{f}": values_of(names, f)[:, i] for f in FIELDS for i, name in enumerate(names)}
    pd.DataFrame(table).to_csv(folder / "columns.csv", index=False)
    return folder / "columns.csv"


WRITERS = pytest.mark.parametrize(
    "write",
    [
        partial(write, dialect="csv-long", name="long.csv"),
        partial(write, dialect="npz", name="run.npz"),
        write_rostopic,
        write_long_parquet,
        write_lists,
        write_columns,
    ],
    ids=["long", "npz", "rostopic", "long parquet", "lists", "columns"],
)


@WRITERS
def test_joints_are_sorted_by_name_and_fingers_left_out(tmp_path: Path, write: Callable[..., Path]) -> None:
    log = read_log(write(tmp_path, SCRAMBLED))
    assert (log.joint_names, log.source.robot) == (PANDA, "panda")
    for channel in FIELDS.values():
        np.testing.assert_array_equal(getattr(log, channel), motion(SAMPLES, 7)[channel])


@WRITERS
def test_the_user_chooses_among_several_arms(tmp_path: Path, write: Callable[..., Path]) -> None:
    path = write(tmp_path, [f"{side}_joint{i}" for i in (3, 1, 2) for side in ("left", "right")])
    with pytest.raises((UsageError, InputError), match=r"several arms .*--topic '#left' or --topic '#right'"):
        read_log(path)
    log = read_log(path, ReadOptions(topic="#right"))
    assert log.joint_names == ("right_joint1", "right_joint2", "right_joint3")
    np.testing.assert_array_equal(log.dq, motion(SAMPLES)["dq"])
    refused("no arm 'middle' in this table; it has left, right", read_log, path, ReadOptions(topic="#middle"))
    refused("a table has no topics", read_log, path, ReadOptions(topic="/joint_states#right"))


def test_an_arm_of_a_table_without_joint_names(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no arm 'left' in this table; it has no joints by name; leave --topic out"):
        read_text(tmp_path, tidy_frame(SAMPLES, 1), topic="#left")


@pytest.mark.parametrize("mapping", [{"tau_interaction": "field.effort{i}"}, {"q": "field.position{i}"}])
def test_columns_named_by_the_user_are_sorted_too(tmp_path: Path, mapping: dict[str, str]) -> None:
    log = read_log(write_rostopic(tmp_path, SCRAMBLED), ReadOptions(mapping=mapping))
    torque = log.tau_J if log.tau_J is not None else log.tau_interaction
    np.testing.assert_array_equal(log.q, motion(SAMPLES, 7)["q"])
    np.testing.assert_array_equal(torque, motion(SAMPLES, 7)["tau_J"])


def test_columns_given_one_by_one_keep_their_order(tmp_path: Path) -> None:
    path = write_rostopic(tmp_path, tuple(PANDA[joint] for joint in ORDER))
    efforts = ",".join(f"field.effort{ORDER.index(joint)}" for joint in range(7))
    log = read_log(path, ReadOptions(mapping={"tau_J": efforts}))
    np.testing.assert_array_equal(log.tau_J, motion(SAMPLES, 7)["tau_J"])


@pytest.mark.parametrize("text", [pa.large_string(), pa.dictionary(pa.int32(), pa.string())])
def test_names_of_every_type_of_text(tmp_path: Path, text: pa.DataType) -> None:
    assert read_log(write_lists(tmp_path, SCRAMBLED, pa.list_(text))).joint_names == PANDA


@pytest.mark.parametrize("change", [PANDA, PANDA[:5], None])
def test_joints_that_change_their_places_are_refused(tmp_path: Path, change: Sequence[str] | None) -> None:
    table = pq.read_table(write_lists(tmp_path, SCRAMBLED))
    names: list[list[str] | None] = [list(SCRAMBLED)] * SAMPLES
    names[200] = None if change is None else [*change]
    pq.write_table(table.set_column(1, "name", pa.array(names)), tmp_path / "lists.parquet")
    refused(r"row 201 of name holds .*; the order of the joints changes", read_log, tmp_path / "lists.parquet")


def test_names_of_another_message_are_not_taken(tmp_path: Path) -> None:
    table = {name: array.tolist() for name, array in motion(SAMPLES, 7).items()}
    pq.write_table(pa.table({**table, "gripper.name": [list(SCRAMBLED)] * SAMPLES}), tmp_path / "run.parquet")
    log = read_log(tmp_path / "run.parquet")
    assert log.joint_names[0] == "joint1"
    np.testing.assert_array_equal(log.q, table["q"])


def long_frame(joints: int = 3, samples: int = SAMPLES, **names: str) -> pd.DataFrame:
    arrays = motion(samples, joints)
    table: dict[str, Any] = {"time": np.repeat(arrays["t"], joints), "joint": list(range(1, joints + 1)) * samples}
    return pd.DataFrame(table | {names.get(c, c): arrays[c].reshape(-1) for c in ("q", "dq", "tau_J")})


@pytest.mark.parametrize(
    "mapping", [{"tau_J": "effort"}, {"tau_J": "#5"}, {"t": "time:s", "tau_J": "effort"}, {"tau_interaction": "effort"}]
)
def test_a_mapping_names_single_columns_and_wins_over_the_guess(tmp_path: Path, mapping: dict[str, str]) -> None:
    log = read_text(tmp_path, long_frame(dq="speed", tau_J="effort"), mapping={"dq": "speed", **mapping})
    np.testing.assert_array_equal(log.dq, motion(SAMPLES)["dq"])
    (torque,) = log.channels().keys() - {"q", "dq"}
    np.testing.assert_array_equal(log.channels()[torque], motion(SAMPLES)["tau_J"])
    assert log.source.channels[torque] == "effort"
    assert torque in mapping


@pytest.mark.parametrize("stated", ["q_deg", "angle:deg", "q_deg:deg", "ticks:4096/rev", "q_deg:512.5/rev"])
def test_degrees_or_counts_of_a_mapped_column(tmp_path: Path, stated: str) -> None:
    (name, _, unit), frame = stated.partition(":"), long_frame(q=stated.partition(":")[0])
    frame[name] *= float(unit.partition("/")[0] if "/" in unit else 360) / (2 * np.pi)
    log = read_text(tmp_path, frame, mapping={"q": stated})
    np.testing.assert_allclose(log.q, motion(SAMPLES)["q"], atol=1e-12)
    assert log.source.findings == ()


@pytest.mark.parametrize("stated", ["Winkel {i} (deg)", "Winkel {i} (deg):deg/s", "#2-#4"])
def test_a_name_that_says_degrees_is_believed_when_it_is_mapped(tmp_path: Path, stated: str) -> None:
    """Friction at 57 times the speed is a viscous coefficient 57 times too small."""
    frame = tidy_frame(SAMPLES).rename(columns={f"q_{i}": f"Winkel {i} (deg)" for i in range(1, 4)})
    frame.iloc[:, 1:4] = np.degrees(frame.iloc[:, 1:4])
    log = read_text(tmp_path, frame, mapping={"q": stated})
    np.testing.assert_allclose(log.q, motion(SAMPLES, 3)["q"], atol=1e-9)
    assert log.source.findings == ()


@pytest.mark.parametrize("label", ["{}", "{}.0", "J{}"])
def test_numbers_of_joints_are_sorted_as_numbers(tmp_path: Path, label: str) -> None:
    frame = long_frame(12)
    frame["joint"] = frame["joint"].map(label.format)
    shuffled = frame.sample(frac=1.0, random_state=1).sort_values("time", kind="stable")
    log = read_text(tmp_path, shuffled)
    np.testing.assert_array_equal(log.q, motion(SAMPLES, 12)["q"])
    assert log.joint_names[10:] == (("J11", "J12") if label == "J{}" else ("joint11", "joint12"))


@pytest.mark.parametrize("name", ["Joint Name", "joint id", "motor_id", "Axis"])
def test_the_column_of_joints_by_other_names(tmp_path: Path, name: str) -> None:
    log = read_text(tmp_path, long_frame().rename(columns={"joint": name}))
    np.testing.assert_array_equal(log.q, motion(SAMPLES)["q"])


@pytest.mark.parametrize(
    ("late_s", "words"), [(0.0, "q jumps by .* rows of several joints"), (2e-4, "joint of each row")]
)
def test_rows_of_several_joints_are_never_read_as_one(tmp_path: Path, late_s: float, words: str) -> None:
    frame = long_frame()
    frame["time"] += late_s * (frame["joint"] - 1)
    refused(words, read_text, tmp_path, frame.rename(columns={"joint": "id"}))


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_rows_of_two_robots_are_refused_by_the_column_that_says_it(tmp_path: Path, suffix: str) -> None:
    path, one = tmp_path / f"two.{suffix}", tidy_frame(SAMPLES)
    for other, refusal in (("left", None), ("right", "several robots: column Arm_ID holds left, right")):
        both = pd.concat([one.assign(Arm_ID="left")[::2], one.assign(Arm_ID=other)[1::2]]).sort_values("time")
        both.to_csv(path, index=False) if suffix == "csv" else both.to_parquet(path)
        refused(refusal, read_log, path) if refusal else read_log(path)


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_the_beginning_of_a_table_whose_joints_follow_each_other(
    tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("friction_audit.io.readers.parquet._BATCH_ROWS", 1000)
    monkeypatch.setattr("friction_audit.io.readers.csv_lines._BLOCK_BYTES", 20_000)
    frame, path = long_frame(samples=3000).sort_values("joint", kind="stable"), tmp_path / f"long.{suffix}"
    frame.to_csv(path, index=False) if suffix == "csv" else frame.to_parquet(path)
    log = read_log(path, ReadOptions(t_end_s=0.2, hashed=False, largest_whole=-1.0))
    np.testing.assert_array_equal(log.q, motion(200)["q"])


def test_joints_with_stamps_of_their_own_are_interpolated(tmp_path: Path) -> None:
    frame = long_frame()
    frame["time"] += 2e-4 * (frame["joint"] - 1)
    log = read_text(tmp_path, frame)
    assert [finding.code for finding in log.source.findings] == ["joined"]
    whole = motion(SAMPLES)["q"]
    expected = whole[1:] - 0.2 * np.diff(whole, axis=0) * np.arange(3)
    np.testing.assert_allclose(log.q, expected, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "is_long"),
    [*((name, is_long) for name in ("torque", "tau", "effort") for is_long in (True, False)), ("torque_1", False)],
)
def test_a_torque_of_the_only_joint_may_be_either(tmp_path: Path, name: str, *, is_long: bool) -> None:
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
