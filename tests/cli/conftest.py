"""Small logs with known friction, and the command line as a function."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from friction_audit.cli import main
from friction_audit.io.writers.write_log import write_log
from friction_audit.reporting.documents import load_schema
from tests.in_this_process import in_this_process
from tests.reporting.conftest import build_estimate


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


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Run:
    """Return the command line: words in, answer out, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def call(*argv: object) -> Answer:
        capsys.readouterr()
        try:
            main([str(word) for word in argv])
            code: object = 0
        except SystemExit as stop:
            code = 0 if stop.code is None else stop.code
        assert isinstance(code, int)
        return Answer(code, *capsys.readouterr())

    return call


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Start no processes for logs of a batch, and draw no figure of it: they take longest."""
    monkeypatch.setattr("friction_audit.cli.batch_files.drawings_of", lambda *_: [])
    with in_this_process():
        yield


@pytest.fixture(scope="session")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of logs: one joint and two, moved; and one at rest."""
    folder = tmp_path_factory.mktemp("logs")
    for joints in (1, 2):
        write_log(build_estimate(joints, count=24, rate=250.0).log, folder / f"moved{joints}.csv")
    still = build_estimate(1, count=8, rate=100.0).log
    columns = np.stack([still.t, still.q[:, 0] * 0, still.dq[:, 0] * 0, still.q[:, 0] * 0 + 0.01], axis=1)
    np.savetxt(folder / "still.csv", columns, delimiter=",", header="time,q_1,dq_1,tau_interaction_1", comments="")
    (folder / "empty.csv").touch()
    lines = (folder / "moved1.csv").read_text().splitlines(keepends=True)
    lines[500] = lines[500].split(",")[0] + ",nan,nan,nan\n"
    (folder / "damaged.csv").write_text("".join(lines))
    return folder
