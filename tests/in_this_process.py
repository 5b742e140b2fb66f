"""Commands and batches run by the process of the tests, without what takes longest and is tested elsewhere."""

import io
import json
import pickle
from collections.abc import Callable, Generator, Iterable
from contextlib import AbstractContextManager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from hashlib import sha256
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import jsonschema

from friction_audit.batch.executor import Asked, Done, LocalExecutor
from friction_audit.cli import main
from friction_audit.diagnosis import diagnose
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.reporting.documents import load_schema

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Answer:
    """What a command did."""

    code: int
    out: str
    err: str

    def document(self) -> dict[str, Any]:
        """Return the one document on standard output, its schema held against it."""
        document: dict[str, Any] = json.loads(self.out)
        jsonschema.Draft202012Validator(load_schema(document["schema"].split("/")[1])).validate(document)
        return document


Run = Callable[..., Answer]


def run(*words: object, apart: bool = True) -> Answer:
    """Run a command; standard error goes where standard output goes, unless they are wanted apart."""
    out = io.StringIO()
    err = io.StringIO() if apart else out
    code: object = None
    with redirect_stdout(out), redirect_stderr(err):
        try:
            main([str(word) for word in words])
        except SystemExit as stop:
            code = stop.code
    assert code is None or isinstance(code, int)
    return Answer(code or 0, out.getvalue(), err.getvalue() if apart else "")


def _one_by_one(
    executor: LocalExecutor, work: Callable[[Asked], Done], tasks: Iterable[Asked]
) -> Generator[tuple[Asked, Done]]:
    assert executor.workers > 0
    for task in tasks:
        yield task, work(task)


def in_this_process() -> AbstractContextManager[object]:
    """Let batches start no processes; what they are for is tested in ``tests/batch`` and once for the command."""
    return patch.object(LocalExecutor, "run", _one_by_one)


FOUND: dict[str, tuple[JointDiagnosis, ...]] = {}
"""What was diagnosed, by all that it was diagnosed from; the name of the file is no part of that."""
_diagnose = diagnose.diagnose_subjects


def _remembering(subjects: Any, settings: Any, _report: Any = None) -> tuple[JointDiagnosis, ...]:
    key = sha256(pickle.dumps((subjects, settings))).hexdigest()
    if key not in FOUND:
        FOUND[key] = _diagnose(subjects, settings)
    return FOUND[key]


def diagnosed_once() -> AbstractContextManager[object]:
    """Diagnose a log once that pages show in several commands."""
    return patch.object(diagnose, "diagnose_subjects", _remembering)


POINTS_PER_INCH = 72.0
BEGIN_OF_FILE = {"pdf": b"%PDF-1.4\n", "png": b"\x89PNG\r\n\x1a\n"}


def sketch(figure: "Figure", target: io.StringIO | io.BytesIO, *, format: str, **_: Any) -> None:  # noqa: A002
    """Write an empty sheet of the figure's size in place of ``Figure.savefig``; painting is tested with the figures."""
    width, height = (POINTS_PER_INCH * float(inches) for inches in figure.get_size_inches())
    svg = f'<?xml version="1.0"?><svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}"/>'
    if isinstance(target, io.StringIO):
        target.write(svg)
    else:
        target.write(BEGIN_OF_FILE.get(format, svg.encode()))
