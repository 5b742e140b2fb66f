"""HTML text in a headless browser."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tests.opened_page import Opened, open_in

if TYPE_CHECKING:
    from playwright.sync_api import Browser


Open = Callable[..., Opened]


@pytest.fixture
def open_page(browser: "Browser", tmp_path: Path) -> Iterator[Open]:
    """Return what opens HTML text at a width, in a colour scheme, with scripts or without."""
    contexts = []

    def opened(html: str, *, width: int = 1280, scheme: Any = "light", scripts: bool = True) -> Opened:
        path = tmp_path / "page.html"
        path.write_text(html, encoding="utf-8")
        context = browser.new_context(
            viewport={"width": width, "height": 900}, color_scheme=scheme, java_script_enabled=scripts
        )
        contexts.append(context)
        return open_in(context, path.as_uri())

    yield opened
    for context in contexts:
        context.close()
