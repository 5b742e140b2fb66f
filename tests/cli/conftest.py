"""Small logs with known friction, and the command line as a function."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from friction_audit.io.writers.write_log import write_log
from tests.in_this_process import in_this_process
from tests.reporting.conftest import build_estimate


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
