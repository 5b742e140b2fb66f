"""Whatever happens to the bytes of a file, reading it gives a log or an error in words, never anything else."""

import io
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from friction_audit.errors import FrictionAuditError
from friction_audit.io.readers import list_topics, read_log
from tests.io.bag_writing import samples, write
from tests.io.synthetic_recordings import motion, tidy_frame

SAMPLES = 50


def npz() -> bytes:
    np.savez_compressed(stream := io.BytesIO(), **motion(SAMPLES))  # type: ignore[arg-type]
    return stream.getvalue()


def bag(name: str, **options: Any) -> bytes:
    with TemporaryDirectory() as folder:
        path = write(Path(folder) / name, samples(20), **options)
        return (next(path.glob("*.db3")) if path.is_dir() else path).read_bytes()


FILES: dict[str, Callable[[], bytes]] = {
    "run.csv": lambda: tidy_frame(SAMPLES).to_csv(index=False).encode(),
    "run.parquet": lambda: tidy_frame(SAMPLES).to_parquet(),
    "run.npz": npz,
    "run.bag": lambda: bag("run.bag"),
    "chunks.mcap": lambda: bag("run.mcap", enable_crcs=False, chunk_size=2048),
    "loose.mcap": lambda: bag("run.mcap", use_chunking=False),
    "run.db3": lambda: bag("bag"),
}
whole = cache(lambda name: FILES[name]())


@pytest.mark.parametrize("name", FILES)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damage_is_an_error_in_words(tmp_path: Path, name: str, data: st.DataObject) -> None:
    content = bytearray(whole(name))
    place = data.draw(st.integers(0, len(content) - 1))
    damage = data.draw(st.one_of(st.just(None), st.binary(min_size=1, max_size=50)))
    if damage is None:
        del content[place:]
    else:
        content[place : place + len(damage)] = damage
    (tmp_path / name).write_bytes(content)
    with suppress(FrictionAuditError):
        assert len(read_log(tmp_path / name).t) <= SAMPLES
    with suppress(FrictionAuditError):
        list_topics(tmp_path / name)
