"""Words -> exit code -> text, through ``main``."""

import re
from pathlib import Path

import pytest

from friction_audit import __version__
from friction_audit.cli import main
from friction_audit.cli.app import NAMES, command_of
from friction_audit.cli.grouped_help import HEADINGS
from tests.cli.conftest import Run

MOST_OPTIONS = 15

TABLE = [
    # asked for
    ("--version", 0, "out", __version__),
    ("--help", 0, "out", "estimate"),
    ("estimate --help", 0, "out", "friction-audit estimate run.mcap"),
    ("convert --list-dialects", 0, "out", "parquet"),
    # usage
    ("", 2, "both", "Usage"),
    ("estimate", 2, "err", "Missing argument 'LOG'"),
    ("estimate {logs}/moved1.csv --model combind", 2, "err", "did you mean combined?"),
    ("estimate {logs}/moved1.csv --figure-format png,gif", 2, "err", "gif: expected one of png, svg, pdf"),
    ("estimate {logs}/moved1.csv --joints 1,x", 2, "err", "error: --joints 1,x: 'x' is no joint"),
    ("estimate {logs}/moved1.csv --joints 9", 2, "err", "error: --joints 9"),
    ("estimate {logs}/moved1.csv --payload 1,2", 2, "err", "expected 4: mass,x,y,z"),
    ("estimate {logs}/moved1.csv --payload=-1,0,0,0", 2, "err", "a mass above zero"),
    ("info {logs}/moved1.csv --payload nan,0,0,0", 2, "err", "--payload nan,0,0,0: expected mass,x,y,z"),
    ("estimate {logs}/moved1.csv --urdf absent.urdf", 2, "err", "'absent.urdf' does not exist"),
    ("estimate {logs}/moved1.csv --urdf {logs}/moved1.csv", 2, "err", "moved1.csv: not XML"),
    ("estimate {logs}/moved1.csv --t-start 50 --t-end 40", 2, "err", "--t-start 50 --t-end 40: expected an end after"),
    ("info {logs}/absent.csv --t-start 5 --t-end 5", 2, "err", "expected an end after the start"),
    ("convert {logs}/absent.csv out.csv --t-start 5 --t-end nan", 2, "err", "expected an end after the start"),
    ("plot {logs}/moved1.csv --t-start 5000", 2, "err", "choose another --t-start/--t-end"),
    ("estimate {logs}/moved1.csv --gravity-vector a,b,c", 2, "err", "expected numbers x,y,z"),
    ("estimate {logs}/moved1.csv --thresholds 0.1,0.2", 2, "err", "initiation above termination"),
    ("estimate {logs}/moved1.csv --map dq", 2, "err", "expected CHANNEL=NAME"),
    ("estimate {logs}/moved1.csv --config absent.toml", 2, "err", "absent.toml: cannot be read"),
    ("reproduce --figures 15", 2, "err", "15: expected one of 3, 6, 7"),
    ("estimate {logs}/moved1.csv --window 1", 2, "err", "needs at least 4 cycles"),
    ("convert {logs}/moved1.csv out.xyz", 2, "err", "ending .xyz"),
    ("convert {logs}/moved1.csv {logs}/moved1.csv --overwrite", 2, "err", "is the log itself"),
    ("convert {logs}/moved1.csv out.parquet --joints 3", 2, "err", "error: --joints 3: not in"),
    ("estimate {logs}/absent.csv -o {logs}/empty.csv/deep", 2, "err", "cannot be written to"),
    ("replay {logs}/moved1.csv --coefficients coulomb=0.2 --compensator-window 3", 2, "err", "nothing is estimated"),
    ("replay {logs}/moved1.csv --coefficients coulomb=0.2 --factor 2", 2, "err", "remove --factor"),
    ("replay {logs}/moved1.csv --coefficients stiction=0.2", 2, "err", "expected coulomb=NUMBER,viscous=NUMBER"),
    ("replay {logs}/moved1.csv --coefficients coulomb=x", 2, "err", "expected coulomb=NUMBER"),
    ("replay {logs}/moved1.csv --coefficients coulomb=0.2,viscous=-0.1", 2, "err", "would brake the joint"),
    ("replay {logs}/moved1.csv --no-passivity --max-damping 3", 2, "err", "only the controller damps"),
    (
        "replay {logs}/moved1.csv --compensator sigmoid --coefficients coulomb=1",
        2,
        "err",
        "does not use --coefficients",
    ),
    ("replay {logs}/moved1.csv --compensator lugre --observer-gain 5", 2, "err", "does not use --observer-gain"),
    ("replay {logs}/moved1.csv --compensator disturbance_observer", 2, "err", "feeds the motion back"),
    ("replay {logs}/moved1.csv --operator 0.3,9,60", 2, "err", "ask for --assume same-operator"),
    ("replay {logs}/moved1.csv --assume same-operator --operator 0.3,9", 2, "err", "expected 3"),
    ("replay {logs}/moved1.csv --assume same-operator --operator 0,0,0", 2, "err", "at least one of them"),
    ("replay {logs}/moved1.csv --compensator-model viscous --compensator-window 0", 2, "err", "window 0"),
    ("replay {logs}/moved1.csv --max-torque -1", 2, "err", "above zero"),
    ("replay {logs}/moved1.csv --cycles-from hand", 2, "err", ""),
    ("compare --set operator.inertia=1", 2, "err", "operator.inertia_kg_m2"),
    ("compare --persons 1", 2, "err", "2"),
    ("compare --set driven=true", 2, "err", "driven"),
    # the input
    ("estimate {logs}/absent.csv", 3, "err", "error: "),
    ("estimate {logs}/empty.csv", 3, "err", "error: "),
    ("info {logs}/empty.csv", 3, "err", "error: "),
    # no answer
    ("estimate {logs}/still.csv", 4, "err", "no joint has an estimate:\n  joint 1: "),
    # damaged input
    ("estimate {logs}/damaged.csv", 6, "out", "Coulomb"),
    ("plot {logs}/damaged.csv", 6, "out", "velocity-torque.png"),
    ("convert {logs}/damaged.csv out.parquet", 6, "out", "out.parquet"),
    ("info {logs}/damaged.csv", 6, "out", "1 joint\n"),
    ("info {logs}/moved1.csv {logs}/empty.csv", 6, "out", "moved1.csv"),
]


@pytest.mark.parametrize(("words", "code", "stream", "text"), TABLE, ids=[row[0] or "nothing" for row in TABLE])
def test_table(words: str, code: int, stream: str, text: str, run: Run, logs: Path) -> None:
    answer = run(*(word.format(logs=logs) for word in words.split()))
    assert answer.code == code, answer
    assert text in {"out": answer.out, "err": answer.err, "both": answer.out + answer.err}[stream]
    assert "Traceback" not in answer.err
    if code in (2, 3, 4) and stream == "err":
        assert answer.out == ""


@pytest.mark.parametrize("name", NAMES)
def test_every_command_has_help_with_groups(name: str, run: Run) -> None:
    counts = []
    for text in (run(name, "--help").out, run(name, "--help-all").out):
        headings = [line.removesuffix(":") for line in text.splitlines() if line.endswith(":") and line[0] != " "]
        assert headings == [heading for heading in HEADINGS if heading in headings]
        assert {"Common options"} <= set(headings) <= set(HEADINGS)
        assert max(map(len, text.splitlines())) <= 100
        counts.append(len(re.findall(r"^  (?:-\w, )?--", text, re.MULTILINE)))
    options = sum(param.param_type_name == "option" for param in command_of(name).params)
    assert (counts[0] <= MOST_OPTIONS, counts[1]) == (True, options + len(["--help"]))


def test_an_option_without_effect_is_said(run: Run, logs: Path) -> None:
    answer = run("estimate", logs / "moved1.csv", "--payload", "0.7,0,0,0")
    assert (answer.code, "warning: --payload: not used: F_m = tau_interaction" in answer.err) == (0, True), answer


@pytest.mark.parametrize(
    ("error", "code", "text"),
    [
        (MemoryError("Unable to allocate 769 MiB"), 3, r"not enough memory \(Unable to allocate 769 MiB\); .*--t-end"),
        (RecursionError(), 3, "nested too deeply"),
        (OverflowError("int too large"), 3, r"too large \(int too large\)"),
        (OSError(28, "No space left on device", "/tmp/x"), 2, "/tmp/x: .*No space left on device; make room"),
    ],
)
def test_what_the_machine_cannot_do_is_one_line(
    error: Exception, code: int, text: str, run: Run, logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("friction_audit.cli.chain.read", fail)
    answer = run("estimate", logs / "moved1.csv", "-q")
    assert (answer.code, answer.out) == (code, "")
    assert re.fullmatch(f"error: .*{text}.*\n", answer.err)


def test_a_bug_keeps_its_traceback(logs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.cli.chain.read", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        main(["estimate", str(logs / "moved1.csv")])
