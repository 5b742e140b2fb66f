"""The documentation as a site, built once."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tests.documented_commands import ROOT

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page


@dataclass(frozen=True)
class Site:
    """The built site.

    Attributes:
        folder: Where it is.
        code: What the build ended with.
        said: What it said.
    """

    folder: Path
    code: int
    said: str

    def page(self, name: str) -> Path:
        """Return the file of a page, ``effects/stribeck`` say."""
        return self.folder / f"{name}.html"


@dataclass
class Visited:
    """A page of the site in the browser.

    Attributes:
        page: The page.
        requests: Addresses that it asked for.
        complaints: What went to the console, and errors.
    """

    page: "Page"
    requests: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    def evaluate(self, expression: str) -> Any:
        return self.page.evaluate(expression)


Visit = Callable[..., Visited]


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

    def visited(name: str, *, width: int = 1280, scheme: Any = "light") -> Visited:
        context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
        contexts.append(context)
        found = Visited(page=context.new_page())
        found.page.on("console", lambda message: found.complaints.append(message.text))
        found.page.on("pageerror", lambda error: found.complaints.append(str(error)))
        found.page.on("request", lambda request: found.requests.append(request.url))
        found.page.goto(site.page(name).as_uri())
        return found

    yield visited
    for context in contexts:
        context.close()
