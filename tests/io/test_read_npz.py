import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from friction_audit.errors import InputError
from friction_audit.io.readers import ReadOptions, read_log
from tests.io.synthetic_recordings import motion


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
    with pytest.raises(InputError, match=r"array 'q' is pickled, .*numpy\.savez"):
        read_log(path)


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
        with pytest.raises(InputError, match=r"no column for q; .*array 'q' is damaged"):
            read_log(path)
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
