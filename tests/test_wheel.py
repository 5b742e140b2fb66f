"""``pip wheel .`` builds a wheel that holds every file of the package, and the installed wheel works."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from friction_audit.io.readers import read_log

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "friction_audit"
NEEDED = ("pyproject.toml", "README.md", "LICENSE")


def run(*command: object, **env: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", *map(str, command)], capture_output=True, text=True, env=os.environ | env, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.thorough
def test_the_wheel_is_whole_and_works(tmp_path: Path) -> None:
    pytest.importorskip("hatchling", reason="no wheel is built: hatchling is not installed (pip install hatchling)")
    pytest.importorskip("pip", reason="no wheel is built: pip is not installed")
    copy = tmp_path / "copy"
    shutil.copytree(PACKAGE, copy / "src" / "friction_audit", ignore=shutil.ignore_patterns("__pycache__"))
    for name in NEEDED:
        shutil.copy(ROOT / name, copy / name)
    offline = ("--quiet", "--no-deps", "--no-index", "--disable-pip-version-check")
    run("pip", "wheel", *offline, "--no-build-isolation", "--wheel-dir", tmp_path, copy)
    (wheel,) = tmp_path.glob("friction_audit-*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    package = {path.relative_to(PACKAGE.parent).as_posix() for path in PACKAGE.rglob("*") if path.is_file()}
    assert {name for name in package if "__pycache__" not in name} == {n for n in names if ".dist-info/" not in n}
    assert any(name.endswith("licenses/LICENSE") for name in names)

    run("pip", "install", *offline, "--no-compile", "--target", tmp_path / "site", wheel)
    log = ROOT / "sample_logs" / "bench_rig.csv"
    # To estimate would compile the loops once more: they are not those of the source's cache.
    run("friction_audit", "convert", log, tmp_path / "out.parquet", PYTHONPATH=str(tmp_path / "site"))
    assert read_log(tmp_path / "out.parquet").samples == read_log(log).samples
    where = tmp_path / "site" / "bin" / "friction-audit"
    assert "friction_audit.__main__" in where.read_text()
