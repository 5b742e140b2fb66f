"""Hostile tables: bombs, claims and absurd cells in CSV, npz and Parquet files."""

import io
import struct
import zipfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from benchmarks.damaged_files.case import REFUSED, Case, estimate, good, late, written
from benchmarks.damaged_files.watched import GIGABYTE

ZEROS = 6 * GIGABYTE


def _csv_rows(head: str, row: str, rows: int = 400) -> str:
    return head + "\n" + "\n".join(row.replace("T", f"{i / 100:.2f}") for i in range(rows)) + "\n"


def _wide_csv(columns: int) -> str:
    head = "t," + ",".join(f"c{i}" for i in range(columns))
    return _csv_rows(head, "T" + ",1" * columns, 20)


def _many_joints(joints: int) -> str:
    names = [f"{channel}_{j}" for channel in ("q", "dq", "tau_J") for j in range(1, joints + 1)]
    return _csv_rows(",".join(["t", *names]), "T" + ",1" * len(names), 20)


def _long_csv(joints: int) -> str:
    lines = (f"{t},{j},0.1,0.2,0.3" for t in range(3) for j in range(joints))
    return "time,joint,position,velocity,effort\n" + "\n".join(lines) + "\n"


def _commented(line: str, count: int) -> Callable[[Path], Sequence[str]]:
    def make(folder: Path) -> Sequence[str]:
        sound_log = good(folder)
        path = folder / "long_head.csv"
        path.write_bytes(line.encode() * count + sound_log.read_bytes())
        return estimate(path)

    return make


def _npz(entries: dict[str, bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in entries.items():
            archive.writestr(name, data)
    return out.getvalue()


def _npy_header(shape: str, kind: str = "<f8") -> bytes:
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}"
    text += " " * (-(len(text) + 11) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode()


def _npz_claim(shape: str, kind: str = "<f8") -> Callable[[Path], Sequence[str]]:
    entries = {f"{name}.npy": _npy_header(shape, kind) + bytes(64) for name in ("time", "q", "dq", "tau_J")}
    return written("claim.npz", _npz(entries))


def _npz_bomb(folder: Path) -> Sequence[str]:
    path = folder / "bomb.npz"
    block = bytes(1 << 24)
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("time.npy", "w", force_zip64=True) as s,
    ):
        s.write(_npy_header(f"({ZEROS // 8},)"))
        for _ in range(ZEROS // len(block)):
            s.write(block)
    return estimate(path)


def _parquet(folder: Path, make: Callable[[], object]) -> Sequence[str]:
    path = folder / "claim.parquet"
    pq.write_table(make(), path)
    return estimate(path)


def _equal_rows(rows: int) -> Callable[[Path], Sequence[str]]:
    def make(folder: Path) -> Sequence[str]:
        path = folder / "equal.parquet"
        chunk = pa.array(np.zeros(1_000_000))
        table = pa.table(dict.fromkeys(("time", "q_1", "dq_1", "tau_J_1"), chunk))
        with pq.ParquetWriter(path, table.schema) as writer:
            for _ in range(rows // 1_000_000):
                writer.write_table(table)
        return estimate(path)

    return make


def _wide_parquet(folder: Path) -> Sequence[str]:
    return _parquet(folder, lambda: pa.table({f"c{i}": [0.0, 1.0] for i in range(20_000)}))


def _deep_names(folder: Path) -> Sequence[str]:
    sound_log = good(folder, "parquet", ".parquet")
    table = pq.read_table(sound_log)
    path = folder / "names.parquet"
    pq.write_table(table.replace_schema_metadata({"joint_names": "[" * 100_000}), path)
    return estimate(path)


def _empty_lists(folder: Path) -> Sequence[str]:
    lists = [[], *[[0.1]] * 400]
    return _parquet(folder, lambda: pa.table({"time": np.arange(401.0), "q": lists, "dq": lists, "tau_J": lists}))


def cases() -> Iterator[Case]:
    """Yield the hostile tables."""
    sound = "t,q_1,dq_1,tau_J_1"
    yield Case("CSV of 1e5 columns", late("wide.csv", lambda: _wide_csv(100_000)), REFUSED)
    yield Case("CSV of 33 333 joints", late("joints.csv", lambda: _many_joints(33_333)))
    yield Case("long CSV of 1e5 joints", late("long.csv", lambda: _long_csv(100_000)), REFUSED)
    yield Case("CSV with 1e6 comments first", _commented("# comment\n", 1_000_000))
    yield Case("CSV with 1e6 blank lines first", _commented("\n", 1_000_000))
    yield Case("CSV with dates of the year 9999", written("dates.csv", _csv_rows(sound, "9999-12-31 00:00:00,1,1,1")))
    for value in ("1e400", "nan", "inf", "0x1p3", "9" * 5000, "\0", "\u202e1", "--1", "1e", "True"):
        rows = _csv_rows(sound, f"T,0.1,0.2,{value}")
        yield Case(f"CSV of cells {value[:12]!r}", written("cells.csv", rows))
    yield Case("CSV of one line of 50 MB", late("line.csv", lambda: b"1," * 25_000_000), REFUSED)
    yield Case("CSV of quotes", written("quotes.csv", '"' * 1_000_001), REFUSED)
    yield Case("UTF-32", written("utf32.csv", _csv_rows(sound, "T,1,1,1").encode("utf-32")), REFUSED)
    for shape in ("(2147483648,)", "(9999999999999,)", "(-5,)", "(3, 9999999999)", "()", "(0,)", "x", "[[[["):
        yield Case(f"npz that claims {shape}", _npz_claim(shape))
    for kind in ("<U999999999", "|O", "<f16", "|V8", "<M8[ns]"):
        yield Case(f"npz of type {kind}", _npz_claim("(8,)", kind))
    yield Case(
        "npz of bytes that are no array", written("bytes.npz", _npz({f"{n}.npy": b"hello" * 9 for n in "tq"})), REFUSED
    )
    yield Case("npz bomb", _npz_bomb, REFUSED)
    yield Case("Parquet of 1e9 equal rows", _equal_rows(1_000_000_000), REFUSED)
    yield Case("Parquet of 20 000 columns", _wide_parquet, REFUSED)
    yield Case("Parquet with deep joint names", _deep_names)
    yield Case("Parquet whose first list is empty", _empty_lists)
