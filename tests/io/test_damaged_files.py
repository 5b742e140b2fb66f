"""Whatever happens to the bytes of a file, reading it gives a log or an InputError, never anything else."""

import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from friction_audit.errors import InputError
from friction_audit.io.readers import list_topics, read_log
from tests.io.synthetic_recordings import motion, tidy_frame


def table(kind: str) -> bytes:
    """Return the bytes of a small log."""
    stream = io.BytesIO()
    if kind == ".csv":
        return tidy_frame(50).to_csv(index=False).encode()
    if kind == ".parquet":
        tidy_frame(50).to_parquet(stream)
    else:
        np.savez_compressed(stream, **motion(50))  # type: ignore[arg-type]
    return stream.getvalue()


@pytest.mark.parametrize("kind", [".csv", ".parquet", ".npz"])
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damage_is_an_input_error(tmp_path: Path, kind: str, data: st.DataObject) -> None:
    content = bytearray(table(kind))
    place = data.draw(st.integers(0, len(content) - 1))
    damage = data.draw(st.one_of(st.just(None), st.binary(min_size=1, max_size=50)))
    if damage is None:
        del content[place:]
    else:
        content[place : place + len(damage)] = damage
    path = tmp_path / f"run{kind}"
    path.write_bytes(content)
    for read in (read_log, list_topics):
        try:
            read(path)
        except InputError as error:
            assert str(error).startswith(str(path))  # noqa: PT017 (either outcome is right)
