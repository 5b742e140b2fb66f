from pathlib import Path

import pytest

from tests.cli.conftest import Run


def write(folder: Path, text: str) -> Path:
    path = folder / "settings.toml"
    path.write_text(text)
    return path


def test_values_come_from_the_file_and_the_command_line_wins(run: Run, logs: Path, tmp_path: Path) -> None:
    path = write(
        tmp_path,
        'model = "coulomb"\nwindow = 7\njoints = [1, 2]\nmin_path = 0.2\njson = true\n'
        '[map]\ndq = "dq_{i}"\nq = "q_{i}"\n',
    )
    settings = run("estimate", logs / "moved2.csv", "--config", path, "--window", 9).document()["settings"]
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
    answer = run("estimate", logs / "moved1.csv", "--config", write(tmp_path, text))
    assert (answer.code, message in answer.err) == (2, True), answer
