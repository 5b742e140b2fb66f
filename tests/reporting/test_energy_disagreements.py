"""Friction coefficients of the torque fit against those of the energy method."""

import pytest

from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.reporting.diagnosis_words import energy_disagreements


def about(value: float, half: float = 0.01) -> Coefficient:
    return Coefficient(value=value, low=value - half, high=value + half)


def both(coulomb: Coefficient, viscous: Coefficient) -> dict[str, Coefficient]:
    return {"coulomb_nm": coulomb, "viscous_nms_per_rad": viscous}


def disagreements(nominal: dict[str, Coefficient], energy: dict[str, Coefficient]) -> tuple[str, ...]:
    return energy_disagreements(
        JointDiagnosis(joint=1, name="", verdict="adequate", message="", nominal=nominal, from_energy=energy)
    )


TORQUE = both(about(0.3), about(0.07)) | {"inertia_kg_m2": about(0.1)}


def test_intervals_that_meet_are_no_difference() -> None:
    assert disagreements(TORQUE, both(about(0.319), about(0.051))) == ()


@pytest.mark.parametrize(("energy", "meaning"), [(0.1, "a delay"), (0.03, "larger at low speed")])
def test_viscous_friction_that_differs(energy: float, meaning: str) -> None:
    (said,) = disagreements(TORQUE, both(about(0.3), about(energy)))
    assert said.startswith(f"viscous friction {energy:.3g} N m s/rad from energy, 0.07 from torque: ")
    assert meaning in said


@pytest.mark.parametrize("energy", [0.1, 0.5])
def test_coulomb_friction_that_differs(energy: float) -> None:
    (said,) = disagreements(TORQUE, both(about(energy), about(0.07)))
    assert said.startswith(f"Coulomb friction {energy:.3g} N m from energy, 0.3 from torque: ")
    assert "an offset of the torque" in said


def test_both_are_said_the_viscous_one_first() -> None:
    said = disagreements(TORQUE, both(about(0.5), about(0.2)))
    assert [sentence.split()[0] for sentence in said] == ["viscous", "Coulomb"]


@pytest.mark.parametrize("energy", [{}, both(UNDETERMINED, UNDETERMINED)])
def test_what_is_not_known_does_not_differ(energy: dict[str, Coefficient]) -> None:
    assert disagreements(TORQUE, energy) == ()
    assert disagreements(energy, TORQUE) == ()
