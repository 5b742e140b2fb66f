"""A page in a headless browser that notes every request and every complaint."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

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


def open_in(context: "BrowserContext", address: str) -> Opened:
    """Open an address; what it asks for and complains of is noted from the beginning."""
    found = Opened(page=context.new_page())
    found.page.on("console", lambda message: found.complaints.append(message.text))
    found.page.on("pageerror", lambda error: found.complaints.append(str(error)))
    found.page.on("request", lambda request: found.requests.append(request.url))
    found.page.goto(address)
    return found
