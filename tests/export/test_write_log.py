from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.errors import UsageError
from friction_audit.io.readers import read_log
from friction_audit.io.writers.tables import Writer
from friction_audit.io.writers.write_log import WRITERS, write_log
from friction_audit.joint_log import JOINT_CHANNELS, Float, JointLog, Source
from tests.each_case import EACH_WRITER

NAMES = [writer.name for writer in WRITERS]
JOINT_STATE = ("q", "dq", "tau_J")


def make_log(
    *, joints: int = 7, samples: int = 400, channels: tuple[str, ...] = JOINT_CHANNELS, start_s: float | None = None
) -> JointLog:
    """A log of random numbers with stamps of whole nanoseconds and steps of a little more than 1 ms."""
    rng = np.random.default_rng(1)
    steps = rng.integers(1_010_000, 1_300_000, samples - 1)
    t = np.concatenate(([0], np.cumsum(steps))) / 1e9
    q = np.cumsum(rng.normal(0.0, 1e-3, (samples, joints)), axis=0)
    arrays: dict[str, Float] = {name: rng.normal(0.0, 0.3, (samples, joints)) for name in channels}
    dq = np.gradient(q, t, axis=0)
    names = tuple(f"panda_joint{number}" for number in range(1, joints + 1))
    source = Source(path="made.bag", sha256="", format="test", robot="panda", start_s=start_s)
    return JointLog(t=t, **{**arrays, "q": q, "dq": dq}, joint_names=names, source=source)


def place(folder: Path, writer: Writer) -> Path:
    return folder / f"log{writer.suffix}"


@pytest.mark.parametrize("writer", WRITERS, ids=NAMES)
def test_file_reads_back(writer: Writer, tmp_path: Path) -> None:
    channels = ("q", "dq", *(name for name in writer.holds if name not in ("q", "dq")))
    log = make_log(channels=channels, start_s=1_700_000_000.25)
    path = place(tmp_path, writer)
    assert write_log(log, path, dialect=writer.name) is writer
    back = read_log(path)
    has_start = not writer.name.startswith(("csv", "npz")) or writer.name in ("csv-rostopic", "csv-bag")
    assert back.source.start_s == (pytest.approx(1_700_000_000.25, abs=1e-6) if has_start else None)
    assert back.channels().keys() == log.channels().keys()
    compare = assert_array_equal if writer.lossless else assert_nearly_equal
    compare(back.t, log.t)
    for name, channel in back.channels().items():
        compare(channel, log.channels()[name])


@EACH_WRITER
@pytest.mark.parametrize("unit", ["A", "mA"])
def test_a_motor_current_reads_back_as_one_or_is_said_to_be_none(writer: Writer, unit: str, tmp_path: Path) -> None:
    log = make_log(channels=JOINT_STATE)
    log = replace(log, source=replace(log.source, torque_unit=unit))
    path = place(tmp_path, writer)
    write_log(log, path, dialect=writer.name)
    lost = [one for one in writer.left_out(log) if one.startswith(f"the unit of the torque, {unit}")]
    assert (read_log(path).source.torque_unit == unit) != bool(lost)


def assert_nearly_equal(actual: Float, desired: Float) -> None:
    """Six digits, and milliseconds."""
    assert_allclose(actual, desired, rtol=1e-5, atol=0.51e-3)


INTERACTION, SIX = make_log(channels=("q", "dq", "tau_interaction"), samples=10), make_log(joints=6, samples=10)
TAU_J = r"needs tau_J \(the log has q, dq, tau_interaction\).* parquet, parquet-lists, csv"
SEVEN = r"made.bag: .* needs 7 joints \(the log has 6\)"
CASES = [(one, log, words) for log, words in ((INTERACTION, TAU_J), (SIX, SEVEN)) for one in WRITERS if one.lacks(log)]


@pytest.mark.parametrize(("writer", "log", "words"), CASES, ids=[f"{one.name}-{words[6]}" for one, _, words in CASES])
def test_a_log_that_a_dialect_cannot_hold_is_refused(writer: Writer, log: JointLog, words: str, tmp_path: Path) -> None:
    assert len(CASES) == len(WRITERS) - 4 + 6  # all but tables of every channel need tau_J, those of Franka 7 joints
    with pytest.raises(UsageError, match=words):
        write_log(log, place(tmp_path, writer), dialect=writer.name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["csv", "csv-long", "mcap", "mcap-json", "parquet-lists"])
@settings(max_examples=20, deadline=None)
@given(number=st.floats(allow_nan=False, allow_infinity=False, min_value=-9e8, max_value=9e8))
def test_any_number_survives(name: str, number: float, tmp_path_factory: pytest.TempPathFactory) -> None:
    log: Any = make_log(channels=JOINT_STATE, joints=2, samples=10)
    torque = log.tau_J.copy()
    torque[3, 1] = number
    path = tmp_path_factory.mktemp("log") / f"log{next(w.suffix for w in WRITERS if w.name == name)}"
    write_log(replace(log, tau_J=torque), path, dialect=name)
    assert_array_equal(read_log(path).channels()["tau_J"], torque)
