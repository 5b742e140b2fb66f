"""A part of a log: what is read is what would be taken from the whole."""

from pathlib import Path

import numpy as np
import pytest

import friction_audit
from friction_audit.errors import UsageError
from friction_audit.io.readers import ReadOptions, read_log

LOGS = sorted((Path(__file__).parents[2] / "sample_logs" / "formats").iterdir())
WINDOWS = [(0.5, 1.5), (None, 1.0), (1.0, None), (-3.0, 1.0)]


@pytest.mark.parametrize("is_large", [False, True], ids=["small", "large"])
@pytest.mark.parametrize("path", LOGS, ids=[path.name for path in LOGS])
def test_a_part_is_the_part_of_the_whole(path: Path, is_large: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if is_large:  # so that readers leave out what lies outside the part
        monkeypatch.setattr("friction_audit.io.readers.reader.WHOLE_BYTES", 0)
        monkeypatch.setattr("friction_audit.io.readers.csv_lines._BLOCK_BYTES", 20_000)
    whole = read_log(path)
    for start_s, stop_s in WINDOWS:
        part, expected = (
            read_log(path, ReadOptions(t_start_s=start_s, t_end_s=stop_s)),
            whole.take_window(start_s, stop_s),
        )
        np.testing.assert_array_equal(part.t, expected.t)
        for channel, array in expected.channels().items():
            np.testing.assert_array_equal(part.channels()[channel], array)
        assert part.source.start_s == expected.source.start_s
        assert part.source.skipped_s == expected.source.skipped_s
        assert part.take_window(start_s, stop_s) is part


def test_a_part_is_on_the_scaled_clock() -> None:
    options = ReadOptions(t_start_s=1.0, t_end_s=2.0, time_scale=2.0)
    expected = read_log(LOGS[0], ReadOptions(time_scale=2.0)).take_window(1.0, 2.0)
    np.testing.assert_array_equal(read_log(LOGS[0], options).t, expected.t)


def test_a_part_of_a_part_lies_within_it() -> None:
    part = friction_audit.read_log(LOGS[0], t_start_s=0.5, t_end_s=2.0)
    assert part.take_window(0.5, 1.0).source.skipped_s == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("path", LOGS, ids=[path.name for path in LOGS])
def test_a_part_beyond_the_end_is_refused_with_the_duration(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.io.readers.reader.WHOLE_BYTES", 0)
    with pytest.raises(UsageError, match=r"0 samples between 5000 s .*the log lasts from 0 to"):
        read_log(path, ReadOptions(t_start_s=5000.0))
