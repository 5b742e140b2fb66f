"""Where the browser of the tests comes from, and what is said where there is none."""

import tarfile
import time
from pathlib import Path

import pytest

from tests import chromium
from tests.chromium import CHOSEN, NAMES, NoChromiumError, find_chromium


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Return a folder that is all that is on the path, and holds the cache."""
    monkeypatch.delenv(CHOSEN, raising=False)
    for name in ("PATH", "XDG_CACHE_HOME"):
        monkeypatch.setenv(name, str(tmp_path))
    return tmp_path


def test_the_browser_that_is_named_or_installed_is_taken(monkeypatch: pytest.MonkeyPatch, bare: Path) -> None:
    (bare / NAMES[1]).touch(mode=0o755)
    assert find_chromium().path == bare / NAMES[1]
    monkeypatch.setenv(CHOSEN, "/opt/browser")
    assert find_chromium().path == Path("/opt/browser")
    monkeypatch.setenv(CHOSEN, "none")
    with pytest.raises(NoChromiumError, match="=none"):
        find_chromium()


@pytest.mark.parametrize(
    ("npm", "reason"),
    [
        ("", r"no chromium, .* on the path, and no npm"),
        ("echo 'npm error network' >&2; exit 1", "npm: npm error network"),
        ("/bin/sleep 60", "npm: no answer"),
    ],
    ids=["no npm", "no network", "no answer"],
)
def test_without_a_browser_it_is_said_within_seconds_what_is_missing(
    npm: str, reason: str, monkeypatch: pytest.MonkeyPatch, bare: Path
) -> None:
    if npm:
        (bare / "npm").write_text(f"#!/bin/sh\n{npm}\n")
        (bare / "npm").chmod(0o755)
    monkeypatch.setattr(chromium, "PROBE_S", 0.3 if "sleep" in npm else chromium.PROBE_S)
    begin = time.monotonic()
    with pytest.raises(NoChromiumError, match=reason):
        find_chromium()
    assert time.monotonic() - begin < 30.0
    assert list((bare / "friction-audit-tests").iterdir()) == []


@pytest.mark.parametrize("filtered", [True, False], ids=["python 3.11.4", "python 3.11.2"])
def test_the_vetted_package_alone_is_unpacked_with_every_python(
    filtered: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    unpacked, brought = tmp_path / "unpacked", tmp_path / "node_modules" / chromium.PACKAGE / "bin"

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
    monkeypatch.setattr("shutil.which", lambda _: "/bin/true")
    monkeypatch.setattr(chromium, "_run", unpack)
    chromium._unpack(tmp_path, unpacked)
    assert (unpacked / "fonts" / "font.ttf").read_text() == "a font"
    brought.mkdir(parents=True)
    for name in chromium.ARCHIVES:
        (brought / name).write_bytes(b"something else")
    monkeypatch.setattr(chromium, "_run", lambda *_: None)
    with pytest.raises(NoChromiumError, match="not the file that was vetted"):
        chromium._fetch(tmp_path)
