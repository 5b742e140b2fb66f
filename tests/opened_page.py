"""A page in a headless browser that notes every request and every complaint."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext, Page


@dataclass
class Opened:
    """A page in the browser."""

    page: "Page"
    requests: list[str] = field(default_factory=list)  # addresses that it asked for
    complaints: list[str] = field(default_factory=list)  # what went to the console, and errors

    def evaluate(self, expression: str, argument: object = None) -> Any:
        return self.page.evaluate(expression, argument)


Open = Callable[..., Opened]


@pytest.fixture
def open_address(profile: "Callable[[bool], BrowserContext]") -> Iterator[Open]:
    """Return what opens an address at a width, in a colour scheme, with scripts or without.

    What the page asks for and complains of is noted from the beginning.
    """
    with ExitStack() as stack:

        def opened(address: str, *, width: int = 1280, scheme: Any = "light", scripts: bool = True) -> Opened:
            found = Opened(page=stack.enter_context(profile(scripts).new_page()))
            found.page.set_viewport_size({"width": width, "height": 900})
            found.page.emulate_media(color_scheme=scheme)
            found.page.on("console", lambda message: found.complaints.append(message.text))
            found.page.on("pageerror", lambda error: found.complaints.append(str(error)))
            found.page.on("request", lambda request: found.requests.append(request.url))
            found.page.goto(address)
            return found

        yield opened
