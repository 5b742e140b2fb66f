"""JointLog -> CSV as libfranka's ``logToCSV`` writes it, in both generations of its header."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from friction_audit.io.writers.writer import Writer
from friction_audit.joint_log import Float, JointLog

JOINTS = 7
STATE = ("q", "q_d", "dq", "dq_d", "tau_J", "tau_ext_hat_filtered")
COMMAND = {"q_d": 7, "dq_d": 7, "O_T_EE_d": 16, "O_dP_EE_d": 6, "tau_J_d": 7}
"""Fields of a command and how many numbers each has."""

HOLDS = ("q", "dq", "tau_J", "tau_J_d", "tau_ext_hat_filtered")


def write_old(log: JointLog, path: Path) -> None:
    """Write the header of libfranka up to 0.9.0: blanks, repeated names, a column that holds nothing."""
    state = ",".join(_spaced(field, JOINTS) for field in STATE)
    command = ",".join(_spaced(field, size) for field, size in COMMAND.items())
    _write(path, f"duration, success rate, {state},sent commands,{command}", log, between=",,")


def write_new(log: JointLog, path: Path) -> None:
    """Write the header of libfranka from 0.9.1 on: every name once."""
    state = [f"state.{field}[{i}]" for field in STATE for i in range(JOINTS)]
    command = [f"cmd.{field}[{i}]" for field, size in COMMAND.items() for i in range(size)]
    _write(path, ",".join(["time", "success_rate", *state, *command]), log, between=",")


def _spaced(field: str, size: int) -> str:
    return ", ".join(f"{field}[{i}]" for i in range(size))


def _write(path: Path, header: str, log: JointLog, *, between: str) -> None:
    with path.open("w", encoding="ascii", newline="\n") as stream:
        stream.write(header + "\n")
        stream.writelines(_lines(log, between))


def _lines(log: JointLog, between: str) -> Iterator[str]:
    """Yield the rows: milliseconds, success rate, state, command."""
    times = np.rint(log.t * 1000.0).astype(np.int64)
    for time, state, command in zip(times, _state(log), _command(log), strict=True):
        yield f"{time},1,{_numbers(state)}{between}{_numbers(command)}\n"


def _numbers(row: Float) -> str:
    """Format as a C++ stream does by default: six significant digits."""
    return ",".join(f"{number:g}" for number in row)


def _state(log: JointLog) -> Float:
    """Return the columns of the state; the robot held by hand is asked to stay where it is."""
    recorded = log.channels()
    filled = {"q_d": log.q, "dq_d": np.zeros_like(log.q), "tau_ext_hat_filtered": np.full_like(log.q, np.nan)}
    return np.hstack([recorded.get(field, filled.get(field, log.q)) for field in STATE])


def _command(log: JointLog) -> Float:
    """Return the columns of the command: a torque if one was recorded, and no motion."""
    empty = {field: np.zeros((len(log.t), size)) for field, size in COMMAND.items()}
    torque = np.full_like(log.q, np.nan) if log.tau_J_d is None else log.tau_J_d
    return np.hstack(list((empty | {"tau_J_d": torque}).values()))


LIBFRANKA_OLD = Writer(
    name="csv-libfranka-0.9",
    suffix=".csv",
    write=write_old,
    summary="libfranka logToCSV up to 0.9.0: milliseconds, six digits, repeated names",
    lossless=False,
    holds=HOLDS,
    needs=("tau_J",),
    joints=JOINTS,
)
LIBFRANKA = Writer(
    name="csv-libfranka",
    suffix=".csv",
    write=write_new,
    summary="libfranka logToCSV from 0.9.1 on: milliseconds, six digits",
    lossless=False,
    holds=HOLDS,
    needs=("tau_J",),
    joints=JOINTS,
)
