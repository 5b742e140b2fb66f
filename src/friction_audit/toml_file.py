"""TOML that people write, read in bounded time: ``tomllib`` is quadratic in the parts of a dotted key."""

import re
import tomllib
from pathlib import Path
from typing import Any

MOST_BYTES = 1_000_000
"""Files of options and of joint models have a few kB."""
MOST_DOTS = 100
"""Dots in a line, outside strings; keys have two, and a list of numbers one for each."""
STRING = re.compile(rb'"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'')


def read_toml(path: Path) -> dict[str, Any]:
    """Return the content of a file.

    Raises:
        OSError: If it cannot be read.
        ValueError: If it is no TOML, or far beyond what such a file holds; the message says which.
    """
    with path.open("rb") as stream:
        content = stream.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise ValueError(f"more than {MOST_BYTES} bytes")
    lines = STRING.sub(b"", content).split(b"\n")
    number = next((i for i, line in enumerate(lines, 1) if line.count(b".") > MOST_DOTS), None)
    if number is not None:
        raise ValueError(f"more than {MOST_DOTS} dots in line {number}")
    try:
        return tomllib.loads(content.decode("utf-8"))
    except RecursionError as error:
        raise ValueError("arrays or tables are nested too deeply") from error
