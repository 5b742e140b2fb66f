"""Where the browser of the tests comes from, and what is said where there is none."""

import tarfile
import time
from pathlib import Path

import pytest

from tests import chromium
from tests.chromium import CHOSEN, NAMES, NoChromiumError, find_chromium


def test_the_browser_that_is_named_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CHOSEN, "/opt/browser")
    assert find_chromium().path == Path("/opt/browser")
    monkeypatch.setenv(CHOSEN, "none")
    with pytest.raises(NoChromiumError, match="=none"):
        find_chromium()


def test_an_installed_browser_is_taken(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv(CHOSEN, raising=False)
    program = tmp_path / NAMES[1]
    program.touch(mode=0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert find_chromium().path == program


def test_without_browser_and_npm_it_is_said_what_is_missing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv(CHOSEN, raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with pytest.raises(NoChromiumError, match=r"no chromium, .* on the path, and no npm"):
        find_chromium()
    assert list((tmp_path / "friction-audit-tests").iterdir()) == []


def test_a_package_that_cannot_be_had_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv(CHOSEN, raising=False)
    npm = tmp_path / "npm"
    npm.write_text("#!/bin/sh\necho 'npm error network' >&2\nexit 1\n")
    npm.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with pytest.raises(NoChromiumError, match="npm: npm error network"):
        find_chromium()


def test_a_package_that_is_not_the_vetted_one_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    brought = tmp_path / "node_modules" / chromium.PACKAGE / "bin"
    brought.mkdir(parents=True)
    for name in chromium.ARCHIVES:
        (brought / name).write_bytes(b"something else")
    monkeypatch.setattr(chromium, "_run", lambda *_: None)
    monkeypatch.setattr("shutil.which", lambda _: "/bin/true")
    with pytest.raises(NoChromiumError, match="not the file that was vetted"):
        chromium._fetch(tmp_path)


def test_a_registry_that_does_not_answer_delays_the_tests_by_seconds(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv(CHOSEN, raising=False)
    npm = tmp_path / "npm"
    npm.write_text("#!/bin/sh\n/bin/sleep 60\n")
    npm.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert chromium.PROBE_S <= 30.0
    monkeypatch.setattr(chromium, "PROBE_S", 0.3)
    begin = time.monotonic()
    with pytest.raises(NoChromiumError, match="npm: no answer"):
        find_chromium()
    assert time.monotonic() - begin < 30.0


@pytest.mark.parametrize("filtered", [True, False], ids=["python 3.11.4", "python 3.11.2"])
def test_the_package_is_unpacked_with_every_python(
    filtered: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    unpacked = tmp_path / "unpacked"

    def unpack(*_: object) -> None:
        (tmp_path / "font.ttf").write_text("a font")
        for name in ("al2023.tar", "fonts.tar"):
            with tarfile.open(unpacked / name, "w") as archive:
                archive.add(tmp_path / "font.ttf", "font.ttf")
        (unpacked / "chromium").touch()

    if not filtered:
        monkeypatch.delattr(tarfile, "data_filter", raising=False)
        # What Python 3.11.2 has: no such argument.
        monkeypatch.setattr(tarfile.TarFile, "extractall", lambda self, path: self.extract("font.ttf", path))
    monkeypatch.setattr(chromium, "_run", unpack)
    monkeypatch.setattr("shutil.which", lambda _: "/bin/true")
    chromium._unpack(tmp_path, unpacked)
    assert (unpacked / "fonts" / "font.ttf").read_text() == "a font"
