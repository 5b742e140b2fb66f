"""``--export``: every table of a result as topics, CSV and Parquet."""

import shutil
from pathlib import Path

import pandas as pd
import pytest
from mcap.reader import make_reader

from friction_audit.reporting import diagnosis, estimate, replay
from tests.cli.conftest import Run

TABLES = {
    command: [table.name for result in results for table in result.TABLES]
    for command, results in {
        "estimate": (estimate,),
        "replay": (replay,),
        "diagnose": (diagnosis,),
        "report": (estimate, replay, diagnosis),
    }.items()
}


@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize("command", TABLES)
def test_every_table_is_written(command: str, run: Run, logs: Path) -> None:
    beside = ("--format", "markdown") if command == "report" else ("--figure-format", "svg")
    answer = run(command, logs / "moved1.csv", "-o", "out", *beside, "--export", "csv,parquet,mcap", "-q")
    assert answer.code == 0, answer.err
    before = "moved1.report." if command == "report" else ""
    for name in TABLES[command]:
        csv = pd.read_csv(f"out/{before}{name}.csv")
        assert list(csv.columns) == list(pd.read_parquet(f"out/{before}{name}.parquet").columns)
    with Path(f"out/{before or f'{command}.'}mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    topics = {channel.topic.rpartition("/")[2] for channel in summary.channels.values()}
    filled = {name for name in TABLES[command] if len(pd.read_csv(f"out/{before}{name}.csv"))}
    assert topics == filled


def test_a_folder_is_needed(run: Run, logs: Path) -> None:
    answer = run("estimate", logs / "moved1.csv", "--export", "mcap")
    assert answer.code == 2
    assert "--export mcap: no folder to write to; name one with --output DIR" in answer.err


def test_a_table_that_exists_is_kept(run: Run, logs: Path) -> None:
    Path("out").mkdir()
    Path("out/cycles.csv").write_text("mine")
    answer = run("estimate", logs / "moved1.csv", "-o", "out", "--export", "csv")
    assert (answer.code, "cycles.csv: exists already" in answer.err) == (2, True), answer
    assert [(path.name, path.read_text()) for path in Path("out").iterdir()] == [("cycles.csv", "mine")]


def test_the_log_itself_is_never_replaced(run: Run, logs: Path) -> None:
    log = Path("out/interaction.csv")
    log.parent.mkdir()
    shutil.copy(logs / "moved1.csv", log)
    answer = run("estimate", log, "-o", "out", "--export", "csv", "--overwrite")
    assert (answer.code, "interaction.csv: is the log itself; nothing was written" in answer.err) == (2, True), answer
    assert log.read_bytes() == (logs / "moved1.csv").read_bytes()
