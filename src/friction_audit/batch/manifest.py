"""A manifest, a CSV table that says of every log what the log itself does not -> rows by the place of their log."""

import csv
import hashlib
import io
import json
import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from friction_audit.batch.find_logs import ManifestRow
from friction_audit.batch.identity import parse_time
from friction_audit.errors import InputError
from friction_audit.io.files import sha256_of
from friction_audit.io.readers import ReadOptions
from friction_audit.pipeline import AuditSettings

if TYPE_CHECKING:
    from friction_audit.diagnosis.settings import DiagnosisSettings


# Columns that are read; "path" has to be there. Others may be there, and are left alone.
COLUMNS = ("path", "start", "robot", "temperature", "payload", "note")
RESULTS_VERSION = 12  # raised with every change after which the same log gives other numbers: ledgers compute anew


def read_manifest(manifest: Path) -> dict[str, ManifestRow]:
    """Return the rows of a manifest by the place of their log: an absolute path, or a URL."""
    lines = csv.reader(io.StringIO(_text(manifest)), skipinitialspace=True)
    header = [name.strip().lower() for name in next(lines, [])]
    _check_header(manifest, header)
    wrong: list[str] = []
    rows: dict[str, ManifestRow] = {}
    seen: dict[str, int] = {}
    for cells in ([cell.strip() for cell in row] for row in lines):
        if not any(cells):
            continue
        if len(cells) > len(header):
            found = f"{len(cells)} cells under {len(header)} columns"
            wrong.append(f"line {lines.line_num}: {found}; put text with commas in quotes")
            continue
        values = dict(zip(header, cells, strict=False))
        wrong += _wrong_with(values, lines.line_num, manifest.parent)
        place = _place(values.get("path", ""), manifest.parent)
        if values.get("path") and seen.setdefault(place, lines.line_num) != lines.line_num:
            wrong.append(f"line {lines.line_num}: {values['path']} comes twice, first in line {seen[place]}")
        if not wrong:
            rows[place] = _row(values)
    if wrong:
        raise InputError(f"{manifest}: " + "; ".join(wrong))
    if not rows:
        raise InputError(f"{manifest}: no rows below the header; expected one row per log")
    return rows


def _text(manifest: Path) -> str:
    try:
        return manifest.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{manifest}: cannot be read: {error.strerror}; check the path") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{manifest}: is not text in UTF-8 ({error.reason}); save it as CSV in UTF-8") from error


def _check_header(manifest: Path, header: list[str]) -> None:
    wrong = [f"no column {'path' if header else 'at all'}"] if "path" not in header else []
    for name in header:
        near = get_close_matches(name, COLUMNS, n=1, cutoff=0.75)
        if name not in COLUMNS and near and near[0] not in header:
            wrong.append(f"column {name}: did you mean {near[0]}?")
    wrong += [f"column {name} comes twice" for name in COLUMNS if header.count(name) > 1]
    if wrong:
        found = ", ".join(header) or "an empty file"
        raise InputError(f"{manifest}: {'; '.join(wrong)}; found {found}; expected {', '.join(COLUMNS)}")


def _wrong_with(values: Mapping[str, str], line: int, folder: Path) -> Iterator[str]:
    path = values.get("path", "")
    if not path:
        yield f"line {line}: no path"
    elif "://" not in path and not (folder / path).exists():
        yield f"line {line}: {path}: no such file or directory in the folder of the manifest"
    start, temperature = values.get("start", ""), values.get("temperature", "")
    if start and parse_time(start) is None:
        yield f"line {line}: start {start}: expected a date and time such as 2026-03-01T14:30:00 or seconds since 1970"
    if temperature and not _is_number(temperature):
        yield f"line {line}: temperature {temperature}: expected degrees Celsius, such as 23.5"


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _place(path: str, folder: Path) -> str:
    return path if "://" in path else os.path.normpath((folder / path).absolute())


def _row(values: Mapping[str, str]) -> ManifestRow:
    temperature = values.get("temperature", "")
    return ManifestRow(
        path=values["path"],
        start_s=parse_time(values.get("start", "")),
        robot=values.get("robot", ""),
        temperature_c=float(temperature) if temperature else None,
        payload=values.get("payload", ""),
        note=values.get("note", ""),
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class BatchSettings:
    """What is done with each log of a batch."""

    audit: AuditSettings = field(default_factory=AuditSettings)  # the chain
    reading: ReadOptions = field(default_factory=ReadOptions)  # how logs are read
    diagnosis: "DiagnosisSettings | None" = None  # what is asked of a diagnosis, or None for none

    def text(self) -> str:
        """Return all that the numbers depend on, apart from the log, as JSON in a fixed order."""

        def as_text(value: object) -> str:  # an arm's URDF may be written anew under its name: its content counts
            return f"sha256 {sha256_of(value)}" if isinstance(value, Path) else str(value)

        return json.dumps({"results": RESULTS_VERSION, **asdict(self)}, sort_keys=True, default=as_text)

    def key(self) -> str:
        """Return the fingerprint of the settings."""
        return hashlib.sha256(self.text().encode()).hexdigest()[:16]
