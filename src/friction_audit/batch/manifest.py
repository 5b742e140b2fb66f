"""A manifest, a CSV table that says of every log what the log itself does not -> rows by the place of their log."""

import csv
import hashlib
import io
import json
import math
import os
from collections.abc import Mapping
from contextlib import suppress
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
        row, faults = _row(dict.fromkeys(COLUMNS, "") | dict(zip(header, cells, strict=False)), manifest.parent)
        if len(cells) > len(header):
            faults = [f"{len(cells)} cells under {len(header)} columns; put text with commas in quotes"]
        place = row.path if "://" in row.path else os.path.normpath((manifest.parent / row.path).absolute())
        if row.path and seen.setdefault(place, lines.line_num) != lines.line_num:
            faults.append(f"{row.path} comes twice, first in line {seen[place]}")
        wrong += [f"line {lines.line_num}: {fault}" for fault in faults]
        rows[place] = row
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


def _row(values: Mapping[str, str], folder: Path) -> tuple[ManifestRow, list[str]]:
    """Return what a row says, and what is wrong with it."""
    path, start, temperature = values["path"], values["start"], values["temperature"]
    start_s, temperature_c, faults = parse_time(start), math.nan, list[str]()
    with suppress(ValueError):
        temperature_c = float(temperature or "nan")
    if not path:
        faults.append("no path")
    elif "://" not in path and not (folder / path).exists():
        faults.append(f"{path}: no such file or directory in the folder of the manifest")
    if start and start_s is None:
        faults.append(f"start {start}: expected a date and time such as 2026-03-01T14:30:00 or seconds since 1970")
    if temperature and not math.isfinite(temperature_c):
        faults.append(f"temperature {temperature}: expected degrees Celsius, such as 23.5")
    own = {name: values[name] for name in ("path", "robot", "payload", "note")}
    return ManifestRow(**own, start_s=start_s, temperature_c=temperature_c if temperature else None), faults


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
