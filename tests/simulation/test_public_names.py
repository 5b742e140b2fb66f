import pytest

from friction_audit import simulation as simulate


@pytest.mark.parametrize("name", simulate.__all__)
def test_public_name_is_there(name: str) -> None:
    assert getattr(simulate, name) is not None
