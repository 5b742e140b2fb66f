import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.simulation.effects.torque_crosstalk import TorqueCrosstalk, mixed

TORQUE = np.array([[1.0, 10.0, 100.0], [-0.0, 2.0, 0.0]])


@pytest.mark.parametrize(
    ("form", "read"),
    [("next", [2.0, 20.0, 100.0]), ("previous", [1.0, 10.1, 101.0]), ("both", [2.0, 20.1, 101.0])],
)
def test_share_of_the_neighbours(form: str, read: list[float]) -> None:
    groups = [TorqueCrosstalk(share=0.1, form=TorqueCrosstalk.forms.index(form))] * 3
    before = TORQUE.copy()
    assert_allclose(mixed(groups, TORQUE)[0], read)
    assert_array_equal(TORQUE, before)


def test_each_sensor_has_its_own_crosstalk() -> None:
    groups = [TorqueCrosstalk(), TorqueCrosstalk(share=-0.5), TorqueCrosstalk()]
    assert_allclose(mixed(groups, TORQUE)[0], [1.0, -40.0, 100.0])


@pytest.mark.parametrize("form", range(len(TorqueCrosstalk.forms)))
def test_no_crosstalk_is_identity_to_the_bit(form: int) -> None:
    assert mixed([TorqueCrosstalk(form=form)] * 3, TORQUE).tobytes() == TORQUE.tobytes()
