"""What holds for all tests: how thorough they are, their order, one thread each, patience, one headless browser."""

import gc
import os
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import threadpoolctl
import typer
from hypothesis import settings
from rosbags.serde import cdr, ros1
from rosbags.serde.utils import compile_lines

from tests.chromium import NoChromiumError, find_chromium
from tests.opened_page import open_address  # noqa: F401 - a fixture

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext

    from tests.in_this_process import Run

FLAGS = ("--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run")

WITHOUT_LOOPS = ("test_architecture.py", "test_site.py", "test_pages_in_browser.py", "test_pages.py")
"""Files of long tests that compile one loop of the program; the last two read the same pages."""
WITH_LOOPS = ("test_docs.py", "test_reproductions.py", "test_diagnose.py")
"""Files of long tests that compile most of them."""

settings.register_profile("fast", deadline=None, max_examples=20)
settings.register_profile("thorough", deadline=None, max_examples=300)
# As the program itself does: with a worker per core, threads inside a product would only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# What is imported and made to collect the tests lives to the end: to look for garbage in it took a fifth of that time.
gc.set_threshold(100_000, 20, 20)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--thorough", action="store_true", help="run the tests marked thorough too, with more examples")


def pytest_configure(config: pytest.Config) -> None:
    settings.load_profile("thorough" if config.getoption("thorough") else "fast")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what is thorough, unless it is asked for; begin with what takes long.

    Of two workers, one begins with the first half of the tests and one with the second, and each takes from the end of
    the other's when it has done its own. In a clean copy, one compiles the loops while the other does what needs none.
    """
    if not config.getoption("thorough"):
        config.hook.pytest_deselected(items=[item for item in items if item.get_closest_marker("thorough")])
        items[:] = [item for item in items if not item.get_closest_marker("thorough")]
    first = [item for item in items if item.path.name in WITHOUT_LOOPS]
    middle = [item for item in items if item.path.name in WITH_LOOPS]
    others = [item for item in items if item.path.name not in (*WITHOUT_LOOPS, *WITH_LOOPS)]
    half = max(len(items) // 2 - len(first), 0)
    items[:] = [*first, *others[:half], *middle, *others[half:]]


def pytest_collection_finish() -> None:
    """Look for garbage no more in what was made to collect the tests."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def made_once() -> Iterator[None]:
    """Make once the commands, the look for libraries of matrices, and what rosbags compiles anew to read every file."""
    compiled = cache(lambda text: compile_lines([text]))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.main, "get_command", cache(typer.main.get_command))
        patch.setattr(threadpoolctl, "ThreadpoolController", cache(threadpoolctl.ThreadpoolController))
        for module in (cdr, ros1):
            patch.setattr(module, "compile_lines", lambda lines: compiled("\n".join(lines)))
        yield


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> "Run":
    """Return the command line: words in, answer out, in an empty folder."""
    from tests.in_this_process import run as command  # noqa: PLC0415 - NumPy looks for its threads when it is loaded

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    return command


@pytest.fixture
def sketched(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make figures and do not paint them, unless asked to be thorough."""
    from tests.in_this_process import sketch  # noqa: PLC0415 - as above

    if not request.config.getoption("thorough"):
        monkeypatch.setattr("matplotlib.figure.Figure.savefig", sketch)


@pytest.fixture(scope="session")
def profile() -> "Iterator[Callable[[bool], BrowserContext]]":
    """Return what gives a profile with scripts or without: to make one takes twice as long as to open a page."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: pip install '.[test]'")
    try:
        chromium = find_chromium()
    except NoChromiumError as error:
        pytest.skip(f"no browser: {error}")
    with playwright.sync_playwright() as tool:
        try:
            browser = tool.chromium.launch(
                executable_path=chromium.path, env=os.environ | chromium.env, chromium_sandbox=False, args=list(FLAGS)
            )
        except playwright.Error as error:
            if not chromium.env:  # the machine's own browser is meant to start
                raise
            pytest.skip(f"no browser: the fetched one does not start on this system: {error}")
        yield cache(lambda scripts: browser.new_context(java_script_enabled=scripts))
        browser.close()
