"""Small logs in every form, and files with every fault: the documented exit code, one message, nothing half-written."""

import copy
import os
import re
import shutil
from collections.abc import Callable, Mapping
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_audit.io.readers import choose_reader
from friction_audit.io.readers.reader import ReadOptions
from friction_audit.io.writers.write_log import WRITERS
from friction_audit.joint_log import Float, JointLog, Source
from tests.each_case import with_thorough
from tests.in_this_process import Run
from tests.io.synthetic_recordings import motion

SAMPLES = 400
JOINTS = ("shoulder", "elbow")

TABLES = {"csv": "log.csv", "csv-long": "log.csv", "parquet": "log.parquet", "npz": "log.npz"}
MCAPS = dict.fromkeys(("mcap", "mcap-ros1", "mcap-json", "mcap-protobuf"), "log.mcap")
BAGS = {"rosbag1-joint-state": "log.bag", "rosbag2-db3": "log.db3", "rosbag2-sqlite3": "log_bag"}
BAGS |= {"rosbag2-mcap": "log_bag", **MCAPS}
FORMS: Mapping[str, str] = {**TABLES, **BAGS}
"""Dialect of a writer -> name of the file or directory, at least one for every reader and every encoding."""


def swinging_log(samples: int = SAMPLES) -> JointLog:
    arrays = motion(max(samples, 2), len(JOINTS), rate_hz=200.0)
    source = Source(path="made", sha256="0" * 64, format="made", start_s=1.7e9)
    log = JointLog(**arrays, joint_names=JOINTS, source=source)
    return with_arrays(log, **{name: array[:samples] for name, array in arrays.items()})


def with_arrays(log: JointLog, **arrays: Float) -> JointLog:
    """Return a log with other arrays, without the checks of a JointLog: files promise nothing."""
    spoiled = copy.copy(log)
    for name, array in arrays.items():
        object.__setattr__(spoiled, name, array)
    return spoiled


def write(folder: Path, dialect: str, log: JointLog | None = None) -> Path:
    path = folder / FORMS[dialect]
    writer = next(writer for writer in WRITERS if writer.name == dialect)
    writer.write(swinging_log() if log is None else log, path)
    return path


def storage_of(path: Path) -> Path:
    """Return the file itself, or the storage file in the directory of a bag."""
    return next(file for file in path.iterdir() if file.suffix in (".db3", ".mcap")) if path.is_dir() else path


def cut(path: Path, share: float = 0.6) -> Path:
    """Leave the beginning of a file, as a broken copy does."""
    storage = storage_of(path)
    content = storage.read_bytes()
    storage.write_bytes(content[: int(len(content) * share)])
    return path


def _not_finite(log: JointLog, value: float) -> JointLog:
    spoiled = np.array(log.tau_J)
    spoiled[100:110, 1] = value
    return with_arrays(log, tau_J=spoiled)


def copy_of(path: Path, folder: Path) -> Path:
    target = folder / path.name
    shutil.copytree(path, target) if path.is_dir() else shutil.copy(path, target)
    return target


UNREADABLE, DAMAGED = 3, 6
NAN = r"10 of 400 rows hold NaN, infinity"
EMPTY, BACK = r"tau_J .*none of the 400 rows holds a number", r"time .*goes back at 399 of 399 rows"
STILL = r"time does not advance|time .*is the same in all 400 rows"
COARSE = r"time .*takes 3 values in 400 rows, too few"
SPOILED: Mapping[str, tuple[Callable[[JointLog], JointLog], int, str]] = {
    "nan": (lambda log: _not_finite(log, np.nan), DAMAGED, NAN),
    "infinity": (lambda log: _not_finite(log, np.inf), DAMAGED, NAN),
    "only nan": (lambda log: with_arrays(log, tau_J=np.full((SAMPLES, 2), np.nan)), UNREADABLE, EMPTY),
    "zero samples": (lambda _: swinging_log(0), UNREADABLE, r"0 (samples|messages)"),
    "one sample": (lambda _: swinging_log(1), UNREADABLE, r"1 sample; at least 2 are needed"),
    "constant time": (lambda log: with_arrays(log, t=np.zeros(SAMPLES)), UNREADABLE, STILL),
    "coarse time": (lambda log: with_arrays(log, t=np.floor(2.0 * log.t / log.t[-1])), UNREADABLE, COARSE),
    "time runs back": (lambda log: with_arrays(log, t=log.t[::-1].copy()), UNREADABLE, BACK),
}
"""Fault -> what gives a log that has it, exit code and message."""
NOTHING = r"no text|nothing but zero bytes|0 samples|Parquet|zip archive|does not begin"


@pytest.fixture(scope="session")
def sound(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return {form: write(tmp_path_factory.mktemp("sound"), form) for form in FORMS}


@pytest.fixture(params=FORMS)
def log(request: pytest.FixtureRequest, sound: dict[str, Path], tmp_path: Path) -> Path:
    return copy_of(sound[request.param], tmp_path)


def refuse(run: Run, path: Path, message: str, *words: object) -> None:
    """Assert that commands say one thing, what is wrong with the file, and leave nothing behind."""
    before = set(path.parent.iterdir())
    for command in (("convert", path, path.parent / "new.parquet"), ("estimate", path, "-o", path.parent / "new")):
        answer = run(*command, *words)
        assert (answer.code, answer.out, "Traceback" in answer.err) == (UNREADABLE, "", False), answer
        (error,) = [line for line in answer.err.splitlines() if line.startswith("error: ")]
        assert error.startswith(f"error: {path}"), answer.err
        assert re.search(message, error), answer.err
        assert set(path.parent.iterdir()) == before


def judge(run: Run, path: Path, code: int, message: str) -> None:
    """Assert that a log is refused, or is read and what is wrong with it is said."""
    if code == UNREADABLE:
        refuse(run, path, message)
        return
    answer = run("convert", path, path.parent / "new.parquet")
    assert (answer.code, (path.parent / "new.parquet").exists()) == (code, True), answer
    assert re.search(message, answer.err)


TRUNCATED = {
    "csv": (DAMAGED, r"line \d+, the last one, is cut short \(5 of 7 fields\); it is left out"),
    "csv-long": (DAMAGED, r"line \d+, the last one, is cut short \(3 of 5 fields\); it is left out"),
    "parquet": (UNREADABLE, r"damaged or unfinished Parquet file.*copy or record it again"),
    "npz": (UNREADABLE, r"damaged NumPy archive.*copy or save it again"),
    "rosbag1-joint-state": (DAMAGED, r"breaks off|broken|no end"),
    "rosbag2-db3": (DAMAGED, r"damaged at byte \d+ of \d+ .*cut off there"),
    "rosbag2-sqlite3": (DAMAGED, r"damaged at byte \d+ of \d+ .*cut off there"),
    "rosbag2-mcap": (DAMAGED, r"damaged at byte \d+ of \d+ .*the last chunk is cut off"),
    **dict.fromkeys(MCAPS, (UNREADABLE, r"breaks off at byte \d+ of \d+ before the first whole chunk")),
}


@pytest.mark.parametrize("form", FORMS)
def test_truncated(run: Run, form: str, sound: dict[str, Path], tmp_path: Path) -> None:
    path = copy_of(sound[form], tmp_path)
    code, message = TRUNCATED[form]
    if form in ("csv", "csv-long"):
        lines = path.read_text().splitlines()[:240]
        path.write_text("\n".join(lines).rsplit(",", 2)[0])
    else:
        cut(path)
    judge(run, path, code, message)


SUFFIXES = (".csv", ".parquet", ".npz", ".bag", ".db3", ".mcap", ".txt")
OTHERS = [(form, [one for one in SUFFIXES if one not in name]) for form, name in FORMS.items() if "." in name]
# Of each form another name: all names are taken, and every reader is misled by the name and not by the content.
RENAMED = [*((form, others[place % 6]) for place, (form, others) in enumerate(OTHERS)), ("csv", ".txt")]


@pytest.mark.parametrize(("form", "suffix"), RENAMED)
def test_a_wrong_extension_is_noticed(run: Run, form: str, suffix: str, sound: dict[str, Path], tmp_path: Path) -> None:
    path = copy_of(sound[form], tmp_path)
    path = path.rename(path.with_suffix(suffix))
    answer = run("convert", path, tmp_path / "new.parquet")
    assert answer.code == 0, answer.err
    both_text = FORMS[form].endswith(".csv") and suffix == ".txt"
    assert ("the name ends in" in answer.err) is not both_text


@pytest.mark.parametrize(("content", "message"), [
    (b"", r"empty"),
    (b"hello world\nthis is a text\n", r"no column for t and q and a torque|does not begin as"),
    (b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 4, NOTHING),
    (b"\0" * 5000, NOTHING),
    (b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 9\n", r"git lfs pull|does not begin"),
    (b"<html><body>Not found, sorry</body></html>", NOTHING),
], ids=["empty", "words", "picture", "zeros", "pointer", "web page"])  # fmt: skip
def test_something_else_under_the_name_of_a_log(run: Run, log: Path, content: bytes, message: str) -> None:
    storage_of(log).write_bytes(content)
    refuse(run, log, message)


def test_no_such_topic(run: Run, log: Path) -> None:
    if log.suffix in (".csv", ".parquet", ".npz"):
        refuse(run, log, r"a table has no topics.*leave --topic out", "--topic", "/joint_statse")
    else:
        message = r"no topic /joint_statse; did you mean /joint_states\?.*400 messages"
        refuse(run, log, message, "--topic", "/joint_statse")


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_missing_columns_are_named_at_once_with_near_misses(run: Run, form: str, tmp_path: Path) -> None:
    path = write(tmp_path, form)
    frame = pd.read_csv(path) if form == "csv" else pd.read_parquet(path)
    frame.columns = [str(name).replace("time", "tyme").replace("dq_", "velocty_") for name in frame]
    frame = frame.drop(columns=["tau_J_1", "tau_J_2"])
    frame.to_csv(path, index=False) if form == "csv" else frame.to_parquet(path)
    refuse(run, path, r"no column for t and a torque .*tyme \(t\)")


@pytest.mark.parametrize("form", FORMS)
def test_all_wrong_mappings_at_once(run: Run, form: str, sound: dict[str, Path]) -> None:
    words, message = "q=pp_{i} t=tiime", r"no column for --map q=pp_\{i\}.* and no column for --map t=tiime.*time"
    if form in BAGS:
        words, message = "q=positon dq=velocty", r"no field positon, velocty .*position.*velocity"
    answer = run("info", sound[form], *(word for one in words.split() for word in ("--map", one)))
    assert answer.code == UNREADABLE
    assert re.search(message, answer.err), answer.err


# Walked in step: each fault is in a table, in a bag and in an MCAP file, and each form has a fault.
IN_STEP = [one for forms in (TABLES, BAGS.keys() - MCAPS, MCAPS) for one in zip(cycle(sorted(forms)), SPOILED)]


@pytest.mark.parametrize(("form", "fault"), with_thorough(IN_STEP, FORMS, SPOILED))
def test_spoiled_content(run: Run, form: str, fault: str, tmp_path: Path) -> None:
    spoiled, code, message = SPOILED[fault]
    judge(run, write(tmp_path, form, spoiled(swinging_log())), code, message)


def test_no_permission(run: Run, log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    storage = storage_of(log)
    opened = Path.open

    def forbidden(path: Path, *args: object, **named: object) -> object:
        if path == storage:
            raise PermissionError(13, "Permission denied", str(path))
        return opened(path, *args, **named)  # type: ignore[call-overload]

    monkeypatch.setattr(Path, "open", forbidden)
    refuse(run, log, r"permission")


@pytest.mark.parametrize("whole", [True, False])
def test_file_that_grows(run: Run, log: Path, whole: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """As soon as its reader is done."""
    module = choose_reader(log).loaded
    read_whole = module.read

    def read_and_grow(path: Path, options: ReadOptions) -> Any:
        try:
            return read_whole(path, options)
        finally:
            with storage_of(path).open("ab") as stream:
                stream.write(b"\n")

    monkeypatch.setattr(module, "read", read_and_grow)
    if not whole:
        cut(log, 0.001)
    answer = run("convert", log, log.parent / "new.parquet")
    assert answer.code == (DAMAGED if whole else UNREADABLE)
    assert re.search(r"changed while it was read( \(\d+ bytes before, \d+ after\)|: )", answer.err)


def test_directory(run: Run, sound: dict[str, Path], tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    refuse(run, folder, r"a directory without the storage files of a bag.*choose a file inside")
    for name in ("monday.db3", "tuesday_0.db3"):
        (folder / name).write_bytes(sound["rosbag2-db3"].read_bytes())
    refuse(run, folder, r"a directory of logs \(monday.db3, tuesday_0.db3\).*give one")
    (folder / "monday.db3").rename(folder / "monday.csv")
    refuse(run, folder, r"a directory of logs \(monday.csv, tuesday_0.db3\).*batch-report")


def test_storage_under_the_other_name(run: Run, sound: dict[str, Path], tmp_path: Path) -> None:
    bag = copy_of(sound["rosbag2-mcap"], tmp_path)
    (bag / "metadata.yaml").unlink()
    (storage := storage_of(bag)).rename(storage.with_suffix(".db3"))
    assert run("convert", bag, tmp_path / "new.parquet").code == 0


@pytest.mark.skipif(os.name != "posix", reason="there are no such files")
def test_what_is_no_file(run: Run, tmp_path: Path) -> None:
    pipe, loop = tmp_path / "pipe.csv", tmp_path / "loop.csv"
    os.mkfifo(pipe)
    loop.symlink_to(loop)
    refuse(run, pipe, r"a pipe or a device; expected a file")
    refuse(run, loop, r"cannot be read: ")
    refuse(run, tmp_path / "absent.csv", r"no such file or directory; check the path")


NAMES, WIDE = b"time,q_1,dq_1,tau_J_1\n", b"time,q_1,q_2,dq_1,tau_J_1\n"
TEXTS = {
    "utf-16": ((NAMES + b"0,0,0,0\n").decode().encode("utf-16"), r"text in UTF-16; expected a table in UTF-8"),
    "utf-32": ((NAMES + b"0,0,0,0\n").decode().encode("utf-32"), r"text in UTF-32; expected a table in UTF-8"),
    "old line ends": (b"time,q_1,dq_1,tau_J_1\r0,0,0,0\r", r"carriage return alone"),
    "no header": (b"0,0,0,0\n1,0,0,0\n", r"no header: line 1 holds 4 numbers.*--map t=#1 --map q=#2-#2 "),
    "only a header": (NAMES, r"0 samples: a header of 4 columns and no rows.*record the arm"),
    "word": (NAMES + b"0,0,x,0\n1,0,0,0\n", r"line 2, column dq_1: 'x' is not a number"),
    "no date": (NAMES + b"noon,0,0,0\nnoon,0,0,0\n", r"time holds neither a number nor a date.*: 'noon'"),
    "narrow line": (NAMES + b"0,0,0,0\n1,0\n2,0,0,0\n", r"line 3 has 2 fields; expected 4"),
    "wide line": (NAMES + b"0,0,0,0\n1,0,0,0,0\n2,0,0,0\n", r"line 3 has 5 fields; expected 4"),
    "carriage return": (NAMES + b"0,0,0,0\n1,0\r1,0,0\n2,0,0,0\n", r"line 3 has a carriage return with"),
    "centuries": (NAMES + b"0,0,0,0\n1e-3,0,0,0\n9e99,0,0,0\n", r"row 3 is 9e\+\d+ s from the first one"),
    "no time": (NAMES + b"nan,0,0,0\nnan,0,0,0\n", r"time holds no number in 2 rows"),
    "joint missing": (WIDE + b"0,0,0,0,0\n1,0,0,0,0\n", r"expected 2 joints: 1, 2 .*dq \(1 joint: 1\)"),
}


@pytest.mark.parametrize(("content", "message"), TEXTS.values(), ids=TEXTS)
def test_texts(run: Run, content: bytes, message: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(content)
    refuse(run, path, message)


def test_transposed_arrays(run: Run, tmp_path: Path) -> None:
    log = swinging_log()
    path = tmp_path / "log.npz"
    np.savez(path, time=log.t, **{name: array.T for name, array in log.channels().items()})  # type: ignore[arg-type]
    refuse(run, path, r"transposed")


def test_path_with_blanks_and_letters(run: Run, sound: dict[str, Path], tmp_path: Path) -> None:
    for form, path in sound.items():
        folder = tmp_path / f"ein Lög #1 %20 {form}"
        folder.mkdir()
        answer = run("convert", copy_of(path, folder), folder / "neü.mcap")
        assert (answer.code, answer.err) == (0, "")
