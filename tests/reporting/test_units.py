from matplotlib.figure import Figure

from friction_audit.reporting.units import column_in_unit, in_unit, label_in_unit


def test_ampere_takes_the_place_of_newton_metres_in_columns_texts_and_labels() -> None:
    names = ("coulomb_nm", "viscous_low_nms_per_rad", "net_energy_j", "start_s", "joint", "q_rad")
    expected = ("coulomb_a", "viscous_low_as_per_rad", "net_energy_a_rad", "start_s", "joint", "q_rad")
    assert tuple(column_in_unit(name, "A") for name in names) == expected
    assert tuple(column_in_unit(name, "N m") for name in names) == names
    assert in_unit({"reason": ["0.3 N m at 0.2 N m s/rad"]}, "A") == {"reason": ["0.3 A at 0.2 A s/rad"]}
    figure = Figure()
    figure.add_subplot().set_ylabel("Coulomb [N m]")
    assert label_in_unit(figure, "A").axes[0].get_ylabel() == "Coulomb [A]"
