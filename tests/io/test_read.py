import hashlib
import subprocess
import sys
from pathlib import Path

import pytest

from friction_audit.errors import InputError
from friction_audit.io.files import sha256_of
from friction_audit.io.readers import ReadOptions, read_log
from friction_audit.io.readers import csv as reader
from friction_audit.io.readers.csv_lines import Dialect, sniff_csv
from friction_audit.io.recording import Recording
from tests.io.synthetic_recordings import write_tidy_csv


def test_an_unknown_format(tmp_path: Path) -> None:
    path = tmp_path / "photo.jpg"
    path.write_bytes(b"\xff\xd8\xff\xe0" + bytes(100))
    with pytest.raises(InputError, match=r"photo.jpg: of no known format; what is read: .*csv \(.csv .tsv"):
        read_log(path)


def test_the_hash_is_that_of_the_content_and_of_a_directory_that_of_its_files(tmp_path: Path) -> None:
    path = write_tidy_csv(tmp_path / "run.csv")
    log = read_log(str(path))
    assert log.source.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert log.source.path == str(path)
    path.rename(tmp_path / "b").write_bytes(b"two")
    (tmp_path / "a").write_bytes(b"one")
    assert sha256_of(tmp_path) == hashlib.sha256(b"onetwo").hexdigest()


def test_what_is_appended_later_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_tidy_csv(tmp_path / "run.csv")
    sniff = sniff_csv

    def sniff_and_grow(file: Path) -> Dialect:
        dialect = sniff(file)
        with file.open("a") as stream:
            stream.write("9,0,0,0,0,0,0,0,0,0\n" * 10)
        return dialect

    monkeypatch.setattr("friction_audit.io.readers.csv.sniff_csv", sniff_and_grow)
    log = read_log(path)
    assert len(log.t) == 300
    assert [f.code for f in log.source.findings] == ["file_grew"]


def test_an_error_of_the_disk_is_an_input_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_tidy_csv(tmp_path / "run.csv")

    def fail(_: Path, __: ReadOptions) -> Recording:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(reader, "read", fail)
    with pytest.raises(InputError, match=r"run.csv: cannot be read: Input/output error"):
        read_log(path)


def test_readers_and_writers_are_listed_without_their_libraries() -> None:
    heavy = ("pandas", "pyarrow", "rosbags", "mcap", "google.protobuf", "scipy")
    code = "import sys, friction_audit.io.readers, friction_audit.io.writers.write_log; "
    code += f"print([name for name in {heavy} if name in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
