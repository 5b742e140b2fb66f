"""The documentation as a site, built once."""

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.documented_commands import ROOT
from tests.opened_page import Open


class Site(NamedTuple):
    folder: Path
    code: int  # what the build ended with
    said: str  # what it said

    def page(self, name: str) -> Path:
        """Return the file of a page, ``effects/stribeck`` say."""
        return self.folder / f"{name}.html"


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    env = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, check=False)
    return Site(folder, done.returncode, done.stdout + done.stderr)


@pytest.fixture
def visit(open_address: Open, site: Site) -> Open:
    return lambda name, **look: open_address(site.page(name).as_uri(), **look)
