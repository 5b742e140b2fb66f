"""The documentation as a site, built once."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tests.documented_commands import ROOT
from tests.opened_page import Opened, open_in

if TYPE_CHECKING:
    from playwright.sync_api import Browser


@dataclass(frozen=True)
class Site:
    """The built site."""

    folder: Path
    code: int  # what the build ended with
    said: str  # what it said

    def page(self, name: str) -> Path:
        """Return the file of a page, ``effects/stribeck`` say."""
        return self.folder / f"{name}.html"


Visit = Callable[..., Opened]


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)],
        cwd=ROOT,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    return Site(folder, done.returncode, done.stdout + done.stderr)


@pytest.fixture
def visit(browser: "Browser", site: Site) -> Iterator[Visit]:
    """Return what opens a page of the site from its file, at a width, in a colour scheme."""
    contexts = []

    def visited(name: str, *, width: int = 1280, scheme: Any = "light") -> Opened:
        context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
        contexts.append(context)
        return open_in(context, site.page(name).as_uri())

    yield visited
    for context in contexts:
        context.close()
