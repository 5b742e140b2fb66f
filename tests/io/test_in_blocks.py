"""A log that is read block by block gives what it gives in memory, in every format and whatever the blocks."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_audit.compensation.settings import ReplaySettings
from friction_audit.io.readers import ReadOptions, read_log
from friction_audit.io.writers.write_log import WRITERS, write_log
from friction_audit.joint_log import JointLog, LogInBlocks, LogPart, Source
from friction_audit.pipeline import AuditSettings, estimate_log, replay_estimate, while_read
from friction_audit.preprocessing.settings import CycleSettings, TorqueSettings
from friction_audit.preprocessing.sign import coarse_log
from friction_audit.reporting.estimate import ESTIMATE
from friction_audit.reporting.replay import REPLAY
from friction_audit.robot.arm import load_arm
from tests.each_case import thorough, with_thorough
from tests.io.synthetic_recordings import motion, refused
from tests.pinned.test_pinned import same

Change = Callable[[pd.DataFrame], pd.DataFrame]

PLAIN, FEW = ("q", "dq", "tau_interaction"), 3  # channels, and joints of a test that takes no model of the arm
CHANNELS = ("q", "dq", "tau_J", "gravity", "tau_interaction", "tau_compensation", "tau_passivity")


@pytest.fixture(autouse=True)
def _small_logs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.io.readers.table.IN_BLOCKS_BYTES", 0)
    monkeypatch.setattr("friction_audit.pipeline.LARGE_PRODUCTS", 0)
    monkeypatch.setattr("friction_audit.io.readers.parquet._BATCH_ROWS", 5003)


@pytest.fixture(scope="module")
def frame() -> pd.DataFrame:
    """Return six joints that swing and one at rest, with a gap and every channel that a torque is made from."""
    signals = motion(15_000, 7)
    t, q, dq = signals["t"], signals["q"], signals["dq"]
    q[:, 6], dq[:, 6] = 0.3, 0.0
    rng = np.random.default_rng(0)
    gravity = load_arm(None, None, (0.0, 0.0, -9.81)).gravity(q)
    friction = 0.5 * np.tanh(dq / 0.02) + 0.3 * dq + 0.02 * rng.standard_normal(q.shape)
    dq = dq + 1e-3 * rng.standard_normal(q.shape)
    arrays = (q, dq, gravity - friction, gravity, friction, 0.01 * np.sign(dq), 0.005 * np.sign(dq))
    every = {
        f"{channel}_{j + 1}": signal[:, j]
        for channel, signal in zip(CHANNELS, arrays, strict=True)
        for j in range(q.shape[1])
    }
    return pd.DataFrame({"time": t, **every}).drop(index=range(9000, 9300))


def written(frame: pd.DataFrame, folder: Path, *channels: str, joints: int = 7, **options: Any) -> Path:
    kept = frame.columns.str.fullmatch(rf"time|(?:{'|'.join(channels)})_[1-{joints}]")
    frame.loc[:, kept].to_parquet(folder / "run.parquet", index=False, row_group_size=7001, **options)
    return folder / "run.parquet"


def assert_same(found: Any, expected: Any, where: str = "") -> None:
    """Compare two documents, numbers to 1e-9."""
    if isinstance(expected, dict):
        assert found.keys() == expected.keys(), where
        for key in expected:
            assert_same(found[key], expected[key], f"{where}/{key}")
    elif isinstance(expected, list | tuple) and len(found) == len(expected):
        for number, (one, other) in enumerate(zip(found, expected, strict=True)):
            assert_same(one, other, f"{where}/{number}")
    else:
        assert same(found, expected, 1e-9), f"{where}: {expected} became {found}"


CASES: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {
    "interaction": (("q", "dq", "tau_interaction"), {}),
    "logged gravity": (("q", "dq", "tau_J", "gravity"), {}),
    "gravity in the torque": (("q", "dq", "tau_J"), {}),
    "model": (("q", "dq", "tau_J"), {"robot": "panda", "gravity": "model", "drive": "hand"}),
    "compensation": (("q", "dq", "tau_interaction", "tau_compensation", "tau_passivity"), {}),
}


ALL_AND_SOME = [*((case, None) for case in CASES), ("model", (2, 5)), ("compensation", (2, 5))]


@pytest.mark.parametrize(("case", "joints"), with_thorough(ALL_AND_SOME, CASES, (None, (2, 5))))
def test_estimates_are_the_same(frame: pd.DataFrame, tmp_path: Path, case: str, joints: tuple[int, ...] | None) -> None:
    channels, torque = CASES[case]
    path = written(frame, tmp_path, *channels)
    settings = AuditSettings(joints=joints, torque=TorqueSettings(**torque), cycles=CycleSettings(thresholds="auto"))
    found = []
    for options in (ReadOptions(), ReadOptions(in_blocks=True)):
        log = read_log(path, options)
        assert isinstance(log, LogInBlocks) is options.in_blocks
        estimate = estimate_log(log, settings)
        cycles = [len(rows) for rows in ESTIMATE.tables(estimate)[2].rows]
        found.append((ESTIMATE.of(estimate), cycles))
    assert_same(found[1], found[0])


@pytest.mark.parametrize("case", ["logged gravity", "model", "compensation"])
def test_the_replay_reads_what_the_torque_is_made_from(frame: pd.DataFrame, tmp_path: Path, case: str) -> None:
    channels, torque = CASES[case]
    path, settings = written(frame, tmp_path, *channels), AuditSettings(torque=TorqueSettings(**torque))
    whole, blocks = (
        replay_estimate(estimate_log(read_log(path, how), settings), ReplaySettings())
        for how in (ReadOptions(), ReadOptions(in_blocks=True))
    )
    assert any(joint.numbers for joint in whole.replay.joints)
    assert_same(REPLAY.of(blocks)["joints"], REPLAY.of(whole)["joints"])


def assert_same_log(
    path: Path, own: dict[str, Any], settings: AuditSettings | None = None, **loose: Any
) -> LogInBlocks:
    """Compare what is read in blocks with what is read at once, and their estimates."""
    settings = settings or AuditSettings(t_start_s=own.get("t_start_s"), t_stop_s=own.get("t_end_s"))
    options = ReadOptions(**own)
    usual, log = read_log(path, options), read_log(path, replace(options, in_blocks=True), while_read(settings))
    assert isinstance(log, LogInBlocks)
    assert replace(log.source, findings=(), **loose) == replace(usual.source, findings=(), **loose)
    found, expected = ([one._asdict() for one in source.findings] for source in (log.source, usual.source))
    assert_same(found, expected)
    parts = list(log.blocks())
    assert (log.samples, log.rate_hz) == (len(usual.t), usual.rate_hz)
    np.testing.assert_allclose(np.concatenate([part.t for part in parts]), usual.t, rtol=0, atol=1e-12)
    for name, array in usual.channels().items():
        np.testing.assert_array_equal(np.concatenate([getattr(part, name) for part in parts]), array)
    assert_same(ESTIMATE.of(estimate_log(log, settings)), ESTIMATE.of(estimate_log(usual, settings)))
    return log


def turned_later(frame: pd.DataFrame) -> pd.DataFrame:
    """Turn the torque of the first blocks: all else says that it has another sign than these."""
    early, torques = frame["time"] < 7.0, [f"tau_interaction_{j}" for j in range(1, 8)]
    return frame.assign(**{name: frame[name].where(~early, -frame[name]) for name in torques})


@pytest.mark.parametrize(
    ("change", "passes"),
    [(lambda frame: frame, 0), (lambda frame: frame.assign(time=frame["time"] + 5.0), 0), (turned_later, 1)],
)
def test_a_sound_log_is_estimated_while_it_is_checked(
    frame: pd.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: Change, passes: int
) -> None:
    """Samples are decoded once more only where the torque is not what the first block shows."""
    path, usual, counted = written(change(frame), tmp_path, *PLAIN, joints=FEW), LogInBlocks.blocks, [0]

    def blocks(log: LogInBlocks) -> Iterator[LogPart]:
        counted[0] += 1
        return usual(log)

    monkeypatch.setattr(LogInBlocks, "blocks", blocks)
    settings = AuditSettings()
    found = ESTIMATE.of(estimate_log(read_log(path, ReadOptions(in_blocks=True), while_read(settings)), settings))
    assert counted[0] == passes
    assert_same(found, ESTIMATE.of(estimate_log(read_log(path), settings)))


ROWS, JOINTS = [5000, 5003, 10006, 12_001], range(1, 8)


def changed(names: list[str], factor: float) -> Change:
    return lambda frame: frame.assign(**{name: frame[name] * factor for name in names})


def put(names: list[str], value: Any, rows: Any = slice(None)) -> Change:
    def change(frame: pd.DataFrame) -> pd.DataFrame:
        frame = frame.copy()
        frame.loc[frame.index[rows], names] = value
        return frame

    return change


def with_repeats(frame: pd.DataFrame) -> pd.DataFrame:  # as of a logger that is faster than the robot
    moving = frame.index[np.flatnonzero(np.abs(frame["dq_1"]) > 0.1)[100::500]]
    frame = frame.loc[frame.index.repeat(1 + frame.index.isin(moving))].reset_index(drop=True)
    return frame.assign(time=np.arange(len(frame)) * 1e-3)


def swapped(frame: pd.DataFrame) -> pd.DataFrame:
    order = np.arange(len(frame))
    order[[5002, 5003, 5100]] = order[[5003, 5002, 5090]]
    return frame.iloc[order]


FAULTS: dict[str, Change] = {
    "missing": put(["dq_3", "q_1", "time"], np.nan, ROWS),
    "no channel": put([f"tau_compensation_{j}" for j in JOINTS], np.nan),
    "no joint": put(["dq_2"], np.nan),
    "wild": put(["q_2", "tau_interaction_1"], 50.0, ROWS),
    "zeros": put(["q_2"], 0.0, slice(9800, 14_000)),
    "degrees": changed([f"q_{j}" for j in JOINTS], 180.0 / np.pi),
    "rpm": changed([f"dq_{j}" for j in JOINTS], 30.0 / np.pi),
    "unit of time": changed(["time"], 1e3),
    "clock": changed(["time"], 1.2),
    "dead": put(["tau_interaction_3"], 0.5),
    "turns": lambda frame: frame.assign(q_1=frame["q_1"] + 20.0),
    "wrapped": lambda frame: frame.assign(q_2=np.mod(frame["q_2"], 2.0 * np.pi)),
    "frozen": put(["q_3", "tau_interaction_3"], 0.2, slice(9800, 14_000)),
    "order": swapped,
    "repeats": with_repeats,
    "gaps": lambda frame: frame.drop(index=[*range(4990, 5010), *range(10_000, 12_000)]),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_handled_block_by_block(frame: pd.DataFrame, tmp_path: Path, fault: str) -> None:
    path = written(FAULTS[fault](frame), tmp_path, *PLAIN, "tau_compensation", joints=FEW)
    assert assert_same_log(path, {}).source.findings


DEGREES = {"q": "q_{i}:deg", "dq": "dq_{i}:deg"}
OWN: list[Any] = [
    {"t_start_s": 3.0, "t_end_s": 12.5, "flip": (2,), "torque_scale": (1.5,)},
    {"t_start_s": 9.0, "time_scale": 1.1, "mapping": DEGREES},
]


@pytest.mark.parametrize("is_large", [False, True])
@pytest.mark.parametrize("own", OWN)
def test_options_hold_block_by_block(
    frame: pd.DataFrame, tmp_path: Path, own: dict[str, Any], is_large: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if is_large:  # so that the part asked for is read alone
        monkeypatch.setattr("friction_audit.io.readers.reader.WHOLE_BYTES", 0)
    frame = frame.assign(time=frame["time"] + 7.0)
    frame.loc[frame.index[[0, 8000]], "q_1"] = np.nan
    assert_same_log(written(frame, tmp_path, *PLAIN, joints=FEW), own)


@pytest.mark.parametrize("resolution", [1e-9, 1e-3])
def test_a_late_velocity_is_put_on_time_block_by_block(frame: pd.DataFrame, tmp_path: Path, resolution: float) -> None:
    names, positions = [f"dq_{j}" for j in JOINTS], [f"q_{j}" for j in JOINTS]
    late = frame.iloc[8:].assign(**{name: frame[name].to_numpy()[:-8] for name in names})
    late[positions] = np.round(late[positions] / resolution) * resolution
    log = assert_same_log(written(late, tmp_path, *PLAIN, joints=FEW), {})
    assert "dq_late" in [one.code for one in estimate_log(log, AuditSettings()).interaction.warnings]


def assert_read_at_once(path: Path) -> None:
    usual, log = read_log(path), read_log(path, ReadOptions(in_blocks=True))
    assert not isinstance(log, LogInBlocks)
    assert log.source == usual.source
    np.testing.assert_array_equal(log.dq, usual.dq)


@pytest.mark.parametrize("fault", ["batches", "damage", "damaged begin"])
def test_what_needs_all_samples_is_read_at_once(frame: pd.DataFrame, tmp_path: Path, fault: str) -> None:
    if fault == "batches":
        frame = frame.assign(time=frame["time"] + np.where(np.arange(len(frame)) % 2, -9e-4, 0.0))
    path = written(frame, tmp_path, *PLAIN, joints=FEW, write_page_checksum=True)
    if "damage" in fault:
        content = bytearray(path.read_bytes())
        place = len(content) // 2 if fault == "damage" else 1000
        content[place : place + 100] = bytes(100)
        path.write_bytes(content)
    assert_read_at_once(path)


@pytest.mark.parametrize("clock", ["seconds", "nanoseconds", "timestamps"])
def test_lists_and_exact_clocks_are_read_in_blocks(frame: pd.DataFrame, tmp_path: Path, clock: str) -> None:
    stamps = np.round(frame["time"].to_numpy() * 1e9).astype(np.int64) + 1_700_000_000_000_000_000
    t = {"seconds": frame["time"], "nanoseconds": stamps, "timestamps": pd.to_datetime(stamps)}[clock]
    lists = {channel: frame[[f"{channel}_{j}" for j in range(1, FEW + 1)]].to_numpy().tolist() for channel in PLAIN}
    path = tmp_path / "lists.parquet"
    pd.DataFrame({"time": np.asarray(t), **lists}).to_parquet(path, index=False, row_group_size=7001)
    assert_same_log(path, {})


def test_a_long_log_is_judged_by_stretches_that_are_spread_over_it(
    frame: pd.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("friction_audit.joint_log.MOST_MEANS", 600)
    monkeypatch.setattr("friction_audit.joint_log.STRETCH", 100)
    path = written(frame, tmp_path, *PLAIN)
    usual, log = read_log(path), read_log(path, ReadOptions(in_blocks=True))
    assert isinstance(log, LogInBlocks)
    every = coarse_log(usual)
    found = coarse_log(log)
    assert log.numbers.tolist() == [n for first in range(0, 735, 200) for n in range(first, min(first + 100, 735))]
    np.testing.assert_array_equal(found.dq, every.dq[log.numbers])
    ends = np.flatnonzero(np.diff(log.numbers) > 1)
    assert not found.whole[ends].any()
    assert not found.whole[ends + 1].any()
    one, other = (estimate_log(log, AuditSettings()) for log in (usual, log))
    assert other.interaction.choice.sign_proved
    for seen, whole in zip(other.interaction.choice.sign_evidence, one.interaction.choice.sign_evidence, strict=True):
        assert seen.moving_s == pytest.approx(whole.moving_s, rel=0.1)  # of the log, not of the stretches
    for own, same_joint in zip(other.friction.joints, one.friction.joints, strict=True):
        assert own.coulomb.value == pytest.approx(same_joint.coulomb.value, rel=1e-9, nan_ok=True)


def test_files_that_are_joined_are_not_read_in_blocks(frame: pd.DataFrame, tmp_path: Path) -> None:
    torque = written(frame, tmp_path, "tau_interaction").rename(tmp_path / "torque.parquet")
    path = written(frame, tmp_path, "q", "dq")
    one, other = (read_log(path, ReadOptions(join=(str(torque),), in_blocks=is_so)) for is_so in (False, True))
    np.testing.assert_array_equal(one.tau_interaction, other.tau_interaction)


FORMS = ("csv", "npz", "mcap", "rosbag1-joint-state", "rosbag2-sqlite3")
MORE_FORMS = ("csv-rostopic", "mcap-json", "mcap-franka-robot-state")  # as csv and mcap, decoded otherwise


@pytest.fixture(scope="module")
def log() -> JointLog:
    arrays = {name: np.delete(array, slice(2000, 2300), axis=0) for name, array in motion(4000, 7).items()}
    arrays["tau_J"] += 0.02 * np.random.default_rng(0).standard_normal(arrays["q"].shape)
    names = tuple(f"panda_joint{j}" for j in range(1, 8))
    source = Source(path="made", sha256="0" * 64, format="made", robot="panda", start_s=1.7e9)
    return JointLog(**arrays, joint_names=names, source=source)


def cut_into(rows: int, patch: pytest.MonkeyPatch) -> None:
    """Read logs of any size in blocks of about so many rows."""
    for module in ("table", "messages"):
        patch.setattr(f"friction_audit.io.readers.{module}.IN_BLOCKS_BYTES", 0)
    for module in ("npz", "messages"):
        patch.setattr(f"friction_audit.io.readers.{module}._BLOCK_ROWS", rows)
    patch.setattr("friction_audit.io.readers.csv_lines._BLOCK_BYTES", 400 * rows)
    patch.setattr("friction_audit.io.readers.rosbag2_sqlite._LOT_BYTES", 400 * rows)


@pytest.mark.parametrize("dialect", [*FORMS, *thorough(MORE_FORMS)])
def test_blocks_are_the_whole(log: JointLog, tmp_path: Path, dialect: str, monkeypatch: pytest.MonkeyPatch) -> None:
    cut_into(333, monkeypatch)
    shorter = log.take_window(1.0, 3.0) if dialect == "mcap-json" else log  # decoded one by one
    path = tmp_path / f"run{next(one.suffix for one in WRITERS if one.name == dialect)}"
    write_log(shorter, path, dialect=dialect)
    settings = AuditSettings(torque=TorqueSettings(gravity="removed"), cycles=CycleSettings(thresholds="auto"))
    # The clock is compared with the motion on means of the samples, which may begin or end a window otherwise.
    assert len(list(assert_same_log(path, {}, settings, clock_windows=0).blocks())) > 1


@pytest.mark.parametrize("fault", ["word", "blank line", "cut", "libfranka"])
def test_a_text_table_with_a_fault_is_read_at_once(
    log: JointLog, tmp_path: Path, fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of libfranka the first row may hold no numbers."""
    cut_into(1000, monkeypatch)
    path = tmp_path / "run.csv"
    write_log(log, path, dialect="csv-libfranka" if fault == "libfranka" else "csv")
    lines = path.read_text().splitlines()
    line = lines[2500].split(",")
    faults = {"word": [*line[:3], "oops", *line[4:]], "blank line": []}
    lines[2500] = ",".join(faults.get(fault, line))
    lines[-1] = ",".join(lines[-1].split(",")[:5]) if fault == "cut" else lines[-1]
    path.write_text("\n".join(lines) + "\n")
    assert_read_at_once(path)


@pytest.mark.parametrize("name", ["run.csv", "run.npz"])
def test_a_file_that_changes(log: JointLog, tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    cut_into(1000, monkeypatch)
    write_log(log, tmp_path / name)
    found = read_log(tmp_path / name, ReadOptions(in_blocks=True))
    assert isinstance(found, LogInBlocks)
    (tmp_path / name).write_bytes((tmp_path / name).read_bytes()[:90_000])
    refused("changed while it was read", list, found.blocks())
    (tmp_path / name).unlink()
    refused("changed while it was read", list, found.blocks())


def test_a_damaged_archive_is_refused(log: JointLog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cut_into(1000, monkeypatch)
    path = tmp_path / "run.npz"
    np.savez(path, time=log.t, **log.channels())  # type: ignore[arg-type]
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(content)
    for options in (ReadOptions(), ReadOptions(in_blocks=True)):
        refused("damaged NumPy archive", read_log, path, options)
