"""Compressed text, NumPy arrays, MATLAB files and LeRobot data sets, each written by the library that people use."""

import gzip
import json
import struct
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
import scipy.io

from friction_audit.errors import InputError
from friction_audit.io.readers import ReadOptions, list_topics, read_log
from friction_audit.io.readers.reader import SeveralLogsError
from tests.io.synthetic_recordings import motion, refused, write_tidy_csv

JOINTS = ["shoulder_pan", "elbow", "gripper"]
BY_NUMBER = {"t": "#1", "q": "#2-#4", "dq": "#5-#7", "tau_J": "#8-#10"}


@pytest.mark.parametrize("suffix", [".gz", ".zst"])
def test_compressed_text_whole_and_cut_off(tmp_path: Path, suffix: str) -> None:
    content, path = write_tidy_csv(tmp_path / "run.csv").read_bytes(), tmp_path / f"run.csv{suffix}"
    path.write_bytes(gzip.compress(content) if suffix == ".gz" else pa.compress(content, codec="zstd", asbytes=True))
    log = read_log(path)
    np.testing.assert_array_equal(log.q, motion(300)["q"])
    assert (log.source.format, log.source.findings) == ("csv", ())
    assert list_topics(path)[1][0].messages == 300
    content = path.read_bytes()
    for kept in (0.9, 0.02):
        path.write_bytes(content[: int(kept * len(content))])
        refused(r"stream breaks off or is damaged .*; copy it again, or read the part", read_log, path)


def test_a_plain_array(tmp_path: Path) -> None:
    arrays = motion(300)
    np.save(tmp_path / "run.npy", np.column_stack(list(arrays.values())))
    log = read_log(tmp_path / "run.npy", ReadOptions(mapping=BY_NUMBER))
    np.testing.assert_array_equal(log.tau_J, arrays["tau_J"])
    refused(r"an array of 10 columns without names.*--map t=#1", read_log, tmp_path / "run.npy")


def test_an_array_of_records(tmp_path: Path) -> None:
    records = np.zeros(300, dtype=[(name, float, array.shape[1:]) for name, array in motion(300).items()])
    for name, array in motion(300).items():
        records[name] = array
    np.save(tmp_path / "run.npy", records)
    np.testing.assert_array_equal(read_log(tmp_path / "run.npy").dq, motion(300)["dq"])


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.zeros((3, 500)), "3 rows, 500 columns; expected one row per sample"),
        (np.zeros(500), r"shape \(500,\) float64; expected numbers of shape \(samples, columns\)"),
        (np.array({"q": 1}, dtype=object), r"could run foreign code; save plain arrays"),
    ],
)
def test_an_array_that_is_no_table(tmp_path: Path, array: Any, message: str) -> None:
    np.save(tmp_path / "run.npy", array, allow_pickle=True)
    refused(message, read_log, tmp_path / "run.npy", ReadOptions(mapping=BY_NUMBER))


def test_a_log_of_panda_py(tmp_path: Path) -> None:
    """What get_log() returns: lists of vectors, time in ms as vectors of length 1."""
    arrays = motion(300, 7)
    time = [np.array([5_000 + n]) for n in range(300)]
    signals: dict[str, Any] = {name: arrays[name] for name in ("q", "dq", "tau_J")} | {"time": time}
    signals |= {"tau_ext_hat_filtered": arrays["q"], "control_command_success_rate": time}
    signals |= {"O_T_EE": np.zeros((300, 16)), "elbow": np.zeros((300, 2))}
    path = tmp_path / "run.npz"
    np.savez(path, **{name: list(array) for name, array in signals.items()})  # type: ignore[arg-type]
    log = read_log(path)
    np.testing.assert_array_equal(log.q, arrays["q"])
    np.testing.assert_array_equal(log.tau_ext_hat_filtered, arrays["q"])
    np.testing.assert_array_equal(log.t, np.arange(300) / 1e3)
    assert (log.source.format, log.source.clock, log.source.robot) == ("npz", "robot_time", "unknown")
    assert log.source.channels["t"] == "time [ms]"


def test_house_names_compressed_and_one_joint(tmp_path: Path) -> None:
    arrays = motion(300, 1)
    path = tmp_path / "run.npz"
    np.savez_compressed(path, t=arrays["t"], q=arrays["q"], dq=arrays["dq"][:, 0], tau_interaction=arrays["tau_J"])
    log = read_log(path)
    np.testing.assert_array_equal(log.dq, arrays["dq"])
    assert log.tau_J is None


def test_pickled_arrays_are_never_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    np.savez(path, t=np.arange(3), q=np.array([[1.0], None, "x"], dtype=object))
    refused(r"array 'q' is pickled, .*numpy\.savez", read_log, path)


def test_transposed_arrays_are_refused_also_where_they_are_wide(tmp_path: Path) -> None:
    arrays = motion(3000)
    np.savez(tmp_path / "run.npz", t=arrays["t"], **{name: arrays[name].T for name in ("q", "dq", "tau_J")})  # type: ignore[arg-type]
    refused(r"q has shape \(3, 3000\), .*transpose it", read_log, tmp_path / "run.npz")


def rewrite(path: Path, name: str, change: Callable[[bytes], bytes]) -> None:
    """Change an entry, and make its checksum right."""
    with zipfile.ZipFile(path) as archive:
        contents = {info.filename: archive.read(info) for info in archive.infolist()}
    with zipfile.ZipFile(path, "w") as archive:
        for entry, content in contents.items():
            archive.writestr(entry, change(content) if entry == f"{name}.npy" else content)


@pytest.mark.parametrize(
    "change",
    [
        lambda content: b"X" + content[1:],
        lambda content: content.replace(b"(300, 3)", b"(2147483648,)"[:8]),
        lambda content: content.replace(b"(300, 3), }", b"(3000000000, 3), }"),
        lambda content: content[:100],
        lambda _: b"",
    ],
    ids=["magic", "shape", "claim", "short", "empty"],
)
@pytest.mark.parametrize("name", ["q", "tau_J_d"])
def test_an_entry_that_is_no_array_is_said(tmp_path: Path, name: str, change: Callable[[bytes], bytes]) -> None:
    path = tmp_path / "run.npz"
    np.savez(path, **motion(300), tau_J_d=motion(300)["tau_J"])  # type: ignore[arg-type]
    rewrite(path, name, change)
    if name == "q":
        refused(r"no column for q; .*array 'q' is damaged", read_log, path)
    else:
        log = read_log(path)
        assert log.tau_J_d is None
        assert [(finding.code, finding.damaged) for finding in log.source.findings] == [("damaged_numbers", True)]


def test_a_bomb_is_refused_by_its_header(tmp_path: Path) -> None:
    path = tmp_path / "bomb.npz"
    np.savez(path, **motion(300))  # type: ignore[arg-type]
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive, archive.open("time.npy", "w") as entry:
        np.lib.format.write_array_header_1_0(entry, {"descr": "<f8", "fortran_order": False, "shape": (20_000_000,)})
        for _ in range(20):
            entry.write(bytes(8_000_000))
    tracemalloc.start()
    with pytest.raises(InputError):
        read_log(path, ReadOptions(mapping={"t": "time"}))
    assert tracemalloc.get_traced_memory()[1] < 20_000_000
    tracemalloc.stop()


@pytest.mark.parametrize("structure", [False, True])
@pytest.mark.parametrize("turned", [False, True])
def test_a_matlab_file(tmp_path: Path, *, structure: bool, turned: bool) -> None:
    arrays = motion(300)
    kept = {name: array.T if turned else array for name, array in arrays.items()} | {"note": "warm", "gain": 3.0}
    scipy.io.savemat(tmp_path / "run.mat", {"log": kept} if structure else kept, do_compression=turned)
    log = read_log(tmp_path / "run.mat")
    np.testing.assert_array_equal(log.q, arrays["q"])
    np.testing.assert_array_equal(log.tau_J, arrays["tau_J"])
    assert log.source.format == "mat"


def test_a_matlab_file_of_version_7_3(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "run.mat"
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .".ljust(124) + b"\x00\x02IM"
    for size, start in ((0, b""), (512, head)):
        with h5py.File(path, "w", userblock_size=size) as file:
            for name, array in motion(300).items():
                file.create_dataset(name, data=np.atleast_2d(array.T)).attrs["MATLAB_class"] = np.bytes_("double")
        with path.open("r+b") as stream:
            stream.write(start)
        np.testing.assert_array_equal(read_log(path).q, motion(300)["q"])
    monkeypatch.setattr("friction_audit.io.readers.mat.find_spec", lambda _: None)
    refused(r"needs h5py: pip install 'friction-audit\[hdf5\]'", read_log, path)


def test_matlab_files_without_a_log(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, {"gain": 3.0, "note": "warm"})
    refused(r"no array of numbers with several samples; found .*; expected time, q, dq", read_log, path)
    scipy.io.savemat(path, motion(300))
    content = bytearray(path.read_bytes())
    struct.pack_into("<I", content, 176, 200)  # SciPy ends the process at an element of this type
    path.write_bytes(content)
    refused(r"a damaged MATLAB file: an element of type 200", read_log, path)
    path.write_bytes(content[:100])
    refused(r"a damaged MATLAB file: it ends within its header", read_log, path)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda m: {"tau_J": m["tau_J"][:-1]}, r"no column for a torque.*left out: tau_J of 299x3; expected 300 sam"),
        (lambda m: {"q": m["q"][:, :, None].repeat(2, 2)}, r"no column for q.*left out: q of 300x3x2"),
        (lambda m: {"tau_J": m["tau_J"].ravel()}, r"left out: dq of 300x3, q of 300x3, t of 300; expected 900 sam"),
        (lambda m: {"dq": m["dq"][:, :2]}, r"do not cover the same joints: expected 3 joints.*dq \(2 joints"),
    ],
)
def test_matlab_arrays_of_wrong_shapes(tmp_path: Path, wrong: Any, message: str) -> None:
    arrays = motion(300)
    scipy.io.savemat(tmp_path / "run.mat", arrays | wrong(arrays))
    refused(message, read_log, tmp_path / "run.mat")


def data_set(root: Path, version: str, episodes: int, features: dict[str, list[str]]) -> Path:
    """Write a data set: the layout of ``info.json`` and of the Parquet files is that of huggingface/lerobot."""
    folder = root / "data" / "chunk-000"
    folder.mkdir(parents=True)
    (root / "meta").mkdir()
    described = {name: {"dtype": "float32", "shape": [len(one)], "names": one} for name, one in features.items()}
    (root / "meta" / "info.json").write_text(json.dumps({"codebase_version": version, "features": described}))
    frames = []
    for episode in range(episodes):
        arrays = motion(600 + 10 * episode, 3, rate_hz=100.0)
        columns: dict[str, Any] = {"timestamp": arrays["t"].astype(np.float32), "episode_index": episode}
        parts = [arrays["q"], arrays["dq"], arrays["tau_J"]]
        if len(features) == 1:
            parts = [np.stack(parts, axis=2).reshape(len(arrays["t"]), -1)]
        columns |= {name: list(part.astype(np.float32)) for name, part in zip(features, parts, strict=True)}
        frames.append(pd.DataFrame(columns))
        if version == "v2.1":
            frames[-1].to_parquet(folder / f"episode_{episode:06d}.parquet")
    if version == "v3.0":
        pd.concat(frames).to_parquet(folder / "file-000.parquet")
    return root


APART = dict.fromkeys(("observation.state", "observation.velocity", "observation.effort"), JOINTS)
TOGETHER = {"observation.state": [f"joint_{i}.{part}" for i in (1, 2, 3) for part in ("pos", "vel", "torque")]}


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_an_episode_of_a_data_set(tmp_path: Path, version: str) -> None:
    root = data_set(tmp_path / "set", version, 3, APART)
    with pytest.raises(SeveralLogsError, match=r"3 episodes in one data set; choose one with --topic") as caught:
        read_log(root)
    assert caught.value.topics == tuple(f"episode_{episode:06d}" for episode in range(3))
    assert [topic.messages for topic in list_topics(root)[1]] == [600, 610, 620]
    log = read_log(root, ReadOptions(topic="episode_000001"))
    assert log.joint_names == ("shoulder_pan", "elbow")
    assert log.source.channels["dq"] == "observation.velocity[{i}]"
    np.testing.assert_allclose(log.q, motion(610, 3, rate_hz=100.0)["q"][:, :2], atol=1e-6)
    refused("no episode 'episode_000007'", read_log, root, ReadOptions(topic="episode_000007"))


def test_a_state_whose_elements_say_their_quantity(tmp_path: Path) -> None:
    log = read_log(data_set(tmp_path / "set", "v3.0", 1, TOGETHER))
    assert log.joint_names == ("joint_1", "joint_2", "joint_3")
    assert log.tau_J is not None
    np.testing.assert_allclose(log.tau_J, motion(600, 3, rate_hz=100.0)["tau_J"], atol=1e-6)


def test_data_sets_without_numbers(tmp_path: Path) -> None:
    root = data_set(tmp_path / "set", "v2.1", 1, APART)
    file = root / "data" / "chunk-000" / "episode_000000.parquet"
    file.write_bytes(b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n")
    refused("a Git LFS pointer", read_log, root)
    file.unlink()
    refused("0 frames; expected episodes", read_log, root)
