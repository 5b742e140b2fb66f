"""Motor currents become torques by the constants that the user gives, and results say so."""

from typing import Any

import numpy as np
import pytest

import friction_audit
from friction_audit.errors import UsageError


def table(**more: Any) -> dict[str, Any]:
    t = np.arange(0.0, 4.0, 0.002)
    rate = 2.0 * np.pi * np.array([0.5, 0.5])
    current = np.sign(np.cos(rate * t[:, None])) * [2.0, -3.0] + 0.01 * np.sin(300.0 * t[:, None])
    columns: dict[str, Any] = {"timestamp": t}
    for j in range(2):
        columns[f"actual_q_{j}"] = np.sin(rate[j] * t)
        columns[f"actual_qd_{j}"] = rate[j] * np.cos(rate[j] * t)
        columns[f"actual_current_{j}"] = current[:, j]
        columns[f"target_moment_{j}"] = 40.0 * np.ones(len(t))
    return columns | more


def test_a_table_of_rtde_is_in_ampere_until_a_constant_is_given() -> None:
    plain = friction_audit.log_from_frame(table())
    assert plain.source.torque_unit == "A"
    assert plain.tau_J_d is None
    given = friction_audit.log_from_frame(table(), torque_constant=(0.1, 0.2), gear_ratio=(101.0,), flip=(2,))
    assert given.source.torque_unit == "N m"
    assert plain.tau_J is not None
    assert given.tau_J is not None
    np.testing.assert_allclose(given.tau_J, plain.tau_J * [10.1, -20.2])
    (found,) = (one for one in given.source.findings if one.code == "torque_converted")
    for part in ("actual_current_{i}", "0.1, 0.2 N m/A", "gear ratio 101", "-1 in joint 2"):
        assert part in found.message


def test_a_torque_is_preferred_to_its_current() -> None:
    torque = {f"actual_current_as_torque_{j}": table()[f"actual_current_{j}"] * 9.0 for j in range(2)}
    log = friction_audit.log_from_frame(table(**torque), torque_scale=(2.0,))
    assert log.source.torque_unit == "N m"
    assert log.source.channels["tau_J"] == "actual_current_as_torque_{i}"
    assert log.tau_J is not None
    assert np.abs(log.tau_J[:, 0]).max() == pytest.approx(2.0 * 9.0 * 2.01, rel=1e-3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"gear_ratio": (100.0,)}, "--gear-ratio without --torque-constant"),
        (
            {"torque_constant": (0.1, 0.1, 0.1)},
            "--torque-constant: 3 numbers; expected one, or one for each of 2 joints",
        ),
        ({"torque_scale": (-1.0,)}, "--torque-scale: expected numbers above zero; a sign is turned with --flip"),
        ({"flip": (3,)}, "--flip: no joint 3; expected joints from 1 to 2"),
    ],
)
def test_impossible_constants_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        friction_audit.log_from_frame(table(), **options)
