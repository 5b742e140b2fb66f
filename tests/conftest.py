"""What holds for all tests: their order, one thread each, patience on a busy machine, one headless browser."""

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

from tests.chromium import NoChromiumError, find_chromium

if TYPE_CHECKING:
    from playwright.sync_api import Browser

FLAGS = ("--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run")

LONG = ("test_architecture.py", "test_docs.py")
"""Files of the tests that take longest."""

settings.register_profile("patient", deadline=None)
settings.load_profile("patient")
# As the program itself does: with a worker per core, threads inside a product would only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with what takes long, so that no worker is left alone with it at the end."""
    items.sort(key=lambda item: item.path.name not in LONG)


@pytest.fixture(scope="session")
def browser() -> "Iterator[Browser]":
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
        yield browser
        browser.close()
