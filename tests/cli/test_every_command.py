"""What holds for every command: its help and page, near misses, ``--config``, files that are there."""

import json
import re
import shlex
from pathlib import Path

import pytest

from friction_audit.cli import NAMES, command_of, parameters
from friction_audit.cli.parameters import HEADINGS
from tests.in_this_process import Run

MOST_OPTIONS = 15
EACH = pytest.mark.parametrize("name", NAMES)


def examples(name: str) -> list[list[str]]:
    """Return the words of each example of a command, without what it is piped into."""
    lines = command_of(name).epilog.splitlines()[2:]
    return [shlex.split(line.partition(" | ")[0]) for line in lines]


def options(name: str) -> list[str]:
    return [max(p.opts, key=len) for p in command_of(name).params if p.param_type_name == "option"]


@EACH
def test_help_has_groups_and_examples_that_are_the_command_s(name: str, run: Run) -> None:
    short, whole = (run(name, word).out for word in ("--help", "--help-all"))
    for text in (short, whole):
        headings = [line.removesuffix(":") for line in text.splitlines() if line.endswith(":") and line[0] != " "]
        assert headings == [heading for heading in HEADINGS if heading in headings]
        assert {"Common options"} <= set(headings) <= set(HEADINGS)
        assert max(map(len, text.splitlines())) <= 100
    few, every = (len(re.findall(r"^  (?:-\w, )?--", text, re.MULTILINE)) for text in (short, whole))
    assert (few <= MOST_OPTIONS, every) == (True, len(options(name)) + len(["--help"]))
    assert len(examples(name)) > 1
    for line in command_of(name).epilog.splitlines()[1:]:
        assert line in short
    for words in examples(name):
        assert words[:2] == ["friction-audit", name]
        named = {word.partition("=")[0] for word in words if re.match(r"--[a-z]", word)}
        assert named <= set(options(name))


PAGES = Path(__file__).parents[2] / "docs" / "commands"
SHORT = {"-q": "--quiet", "-v": "--verbose", "-o": "--output"}
CONSOLE = re.compile(r"^```console\n.*?^```$", re.MULTILINE | re.DOTALL)
OPTION = re.compile(r"(?<![\w-])(--[a-z][a-z-]+|-[a-z])(?![\w-])")


@EACH
def test_its_page_names_the_options_that_it_does_not_share_with_estimate(name: str) -> None:
    every = {*options(name), "--help", "--help-all"}
    prose = CONSOLE.sub("", (PAGES / f"{name}.md").read_text())
    named = {SHORT.get(word, word) for word in OPTION.findall(prose)}
    shared = {"--help", "--help-all", *(options("estimate") if name != "estimate" else ())}
    second = {word for p in command_of(name).params for word in p.secondary_opts}
    assert every - shared <= named <= every | second


def of(*figures: str) -> list[str]:
    return [f"{name}.png" for name in figures]


FILES = {
    "estimate": ["estimate.json", "coefficient_history.csv", *of(*parameters.FIGURES)],
    "replay": ["replay.json", "replay_cycles.csv", *of(*parameters.REPLAY_FIGURES)],
    "diagnose": ["diagnose.json", "model.toml", *of(*parameters.DIAGNOSIS_FIGURES)],
    "report": ["absent.report.html"],
    "plot": of("velocity-torque", "velocity-torque-joint5"),
    "compare": of("energy"),
    "reproduce": of("fig6"),
}
"""Files that a command writes in its folder by default."""
DOCUMENTED = ["estimate", "replay", "diagnose"]


@pytest.mark.parametrize(("command", "name"), [(command, name) for command in FILES for name in FILES[command]])
def test_an_older_result_is_refused_at_once(command: str, name: str, run: Run, logs: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / name).write_text("old")
    log = [] if command in ("compare", "reproduce") else [logs / "absent.csv"]
    answer = run(command, *log, "-o", "out")
    assert (answer.code, f"{name}: exists already" in answer.err) == (2, True), answer
    assert [path.read_text() for path in (tmp_path / "out").iterdir()] == ["old"]


@pytest.mark.parametrize("words", ["convert {log} out.json", "simulate joint -o out.csv --truth out.json"])
def test_an_older_file_is_replaced_if_asked(words: str, run: Run, logs: Path, tmp_path: Path) -> None:
    words = words.format(log=logs / "moved1.csv").replace("out.json", "out.csv" if "convert" in words else "out.json")
    old = tmp_path / words.split()[-1]
    old.write_text("old")
    assert run(*words.split(), "-q").code == 2
    assert [path.read_text() for path in tmp_path.iterdir()] == ["old"]
    assert run(*words.split(), "-q", "--overwrite").code == 0
    assert old.read_text() != "old"


@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize("command", DOCUMENTED)
def test_a_folder_gets_the_printed_document_and_all_files(command: str, run: Run, logs: Path, tmp_path: Path) -> None:
    few = ["--candidates", "stribeck"] if command == "diagnose" else []
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / FILES[command][0]).write_text("old")
    answer = run(command, logs / "moved1.csv", *few, "-o", "out", "--json", "--overwrite")
    assert (answer.code, answer.err) == (0, "")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(FILES[command])
    assert json.loads((tmp_path / "out" / FILES[command][0]).read_text()) == answer.document()


@pytest.mark.parametrize("command", DOCUMENTED)
def test_a_joint_at_rest_is_no_answer_and_leaves_no_file(command: str, run: Run, logs: Path, tmp_path: Path) -> None:
    answer = run(command, logs / "still.csv", "-o", "out")
    assert (answer.code, answer.out) == (4, ""), answer
    assert re.search(r"\n  joint 1: .*did not move", answer.err)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", DOCUMENTED)
def test_damage_is_a_warning_unless_quiet_and_an_exit_code(command: str, run: Run, logs: Path) -> None:
    few = ["--candidates", "stribeck"] if command == "diagnose" else []
    loud, quiet = (run(command, logs / "damaged.csv", *few, *flag) for flag in ((), ("-q",)))
    assert (loud.code, quiet.code, quiet.err) == (6, 6, "")
    assert any(line.startswith("warning: ") for line in loud.err.splitlines())
    assert quiet.out == loud.out


def test_values_come_from_the_file_and_the_command_line_wins(run: Run, logs: Path, tmp_path: Path) -> None:
    (tmp_path / "settings.toml").write_text(
        'model = "coulomb"\nwindow = 7\njoints = [1, 2]\nmin_path = 0.2\njson = true\n'
        '[map]\ndq = "dq_{i}"\nq = "q_{i}"\n'
    )
    words = ("--config", "settings.toml", "--window", 9)
    settings = run("estimate", logs / "moved2.csv", *words).document()["settings"]
    assert settings["friction"]["model"] == "coulomb"
    assert settings["friction"]["window"] == 9
    assert settings["joints"] == [1, 2]
    assert settings["cycles"]["minimum_path_rad"] == 0.2
    assert settings["reading"]["mapping"] == {"dq": "dq_{i}", "q": "q_{i}"}


@pytest.mark.parametrize(("text", "message"), [
    ("modle = 1", "no option modle; did you mean model?"),
    ("window = [", "not TOML"),
    ('model = "combind"', "did you mean combined?"),
    ('window = "many"', "'--window'"),
    ("log = 1", "no option log"),
    pytest.param("window = " + "1" * 5000, "digits", id="a number of 5000 digits"),
    pytest.param("map = " + "[" * 20000 + "]" * 20000, "nested too deeply", id="deep arrays"),
    pytest.param(".".join("k" * 20000) + " = 1", "dots in line 1", id="a key of many parts"),
    pytest.param("".join(f"k{i} = 1\n" for i in range(300_000)), "bytes", id="a large file"),
    pytest.param("".join(f"k{i} = 1\n" for i in range(50_000)), "and 49995 more", id="many keys"),
    pytest.param("k" * 900_000 + " = 1", "no option kkkkk", id="a long key"),
    pytest.param('"\\u001b[2J\\u202e" = 1', "no option \ufffd[2J\ufffd (", id="a key that a terminal obeys"),
    pytest.param('model = "\\u001b[2J"', "\ufffd[2J: expected", id="a value that a terminal obeys"),
    pytest.param('joints = "1-99999999999"', "'1-99999999999' is no joint", id="many joints"),
    pytest.param("joints = " + "9" * 4000, "is no joint", id="a large joint"),
])  # fmt: skip
def test_mistakes_in_the_file_are_usage_errors(text: str, message: str, run: Run, logs: Path, tmp_path: Path) -> None:
    (tmp_path / "settings.toml").write_text(text)
    answer = run("estimate", logs / "moved1.csv", "--config", "settings.toml")
    assert (answer.code, message in answer.err) == (2, True), answer
