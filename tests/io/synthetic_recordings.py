"""Recordings of a known motion for the tests of ingest: sines, whose velocity is their derivative."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_audit.errors import InputError
from friction_audit.io.readers import ReadOptions, read_log
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Float, JointLog

RATE_HZ = 1000.0


def motion(samples: int = 3000, joints: int = 3, rate_hz: float = RATE_HZ) -> dict[str, Float]:
    """t, q, dq, tau_J of joints that swing with amplitude 0.5 rad at different rates."""
    t = np.arange(samples) / rate_hz
    rate = 3.0 + 0.5 * np.arange(joints)
    phase = rate * t[:, None] + 0.3 * np.arange(joints)
    q = 0.5 * np.sin(phase)
    dq = 0.5 * rate * np.cos(phase)
    return {"t": t, "q": q, "dq": dq, "tau_J": 0.2 * np.sign(dq) + 0.05 * dq}


def recording(samples: int = 3000, joints: int = 3, rate_hz: float = RATE_HZ) -> Recording:
    """Return the motion as a reader would hand it over."""
    arrays = motion(samples, joints, rate_hz)
    return Recording(
        t=arrays.pop("t"),
        channels={channel: np.asfortranarray(array) for channel, array in arrays.items()},
        joint_names=tuple(f"panda_joint{joint}" for joint in range(1, joints + 1)),
        path="run.log",
    )


def tidy_frame(samples: int = 3000, joints: int = 3) -> pd.DataFrame:
    """Return the motion as a table with columns time, q_1, ..., dq_1, ..., tau_J_1, ..."""
    arrays = motion(samples, joints)
    columns = {"time": arrays.pop("t")}
    for channel, array in arrays.items():
        columns |= {f"{channel}_{joint + 1}": array[:, joint] for joint in range(joints)}
    return pd.DataFrame(columns)


def read_text(folder: Path, content: str | bytes | pd.DataFrame, **options: Any) -> JointLog:
    """Write a text table and read it."""
    path = folder / "run.csv"
    text = content.to_csv(index=False) if isinstance(content, pd.DataFrame) else content
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_log(path, ReadOptions(**options))


def refused(words: str, read: Callable[..., object], *given: object, **options: object) -> None:
    """What is read is refused in these words."""
    with pytest.raises(InputError, match=words):
        read(*given, **options)


def write_tidy_csv(path: Path) -> Path:
    """Write 300 samples of the motion as a tidy text table."""
    tidy_frame(300).to_csv(path, index=False)
    return path
