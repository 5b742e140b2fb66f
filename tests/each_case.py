"""Cases of a list that the fast run leaves out, by name, and formats of which it has one of each container."""

from collections.abc import Iterable, Sequence
from itertools import product
from typing import Any

import pytest

from friction_audit.io.writers.write_log import WRITERS

TABLES, BAGS = ("parquet", "csv", "csv-libfranka", "npz"), ("rosbag1-joint-state", "rosbag2-sqlite3", "rosbag2-db3")
ONE_OF_EACH = (*TABLES, *BAGS, "mcap")
"""A format of each container, for what is alike in all. That each format reads back as it was is always tested."""


def thorough(cases: Iterable[Any]) -> list[Any]:
    """Return cases that run with ``--thorough`` only."""
    return [pytest.param(*(one if type(one) is tuple else (one,)), marks=pytest.mark.thorough) for one in cases]


def with_thorough(fast: Sequence[tuple[Any, ...]], *lists: Iterable[Any]) -> list[Any]:
    """Return cases in which each value of each list occurs, and with ``--thorough`` all of their product."""
    return [*fast, *thorough(case for case in product(*lists) if case not in fast)]


EACH_WRITER = pytest.mark.parametrize(
    "writer",
    [pytest.param(one, id=one.name, marks=() if one.name in ONE_OF_EACH else pytest.mark.thorough) for one in WRITERS],
)
