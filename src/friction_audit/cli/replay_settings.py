"""Options of ``replay`` -> its settings."""

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from friction_audit.cli import choices
from friction_audit.cli.choices import option, parse_numbers
from friction_audit.cli.grouped_help import REPLAY, TUNING
from friction_audit.cli.options import CycleOptions, joint_model_option
from friction_audit.errors import UsageError
from friction_audit.friction.settings import MODELS

if TYPE_CHECKING:
    from friction_audit.compensation.compensators import Coefficients, EnergyCompensator
    from friction_audit.compensation.settings import ReplaySettings


@dataclass(frozen=True, kw_only=True, slots=True)
class ReplayOptions:
    """Compensator that is replayed, and what is assumed of the person."""

    assume: Annotated[
        str, option(REPLAY, "Assumption about the person: what stays as recorded.", one_of=choices.ASSUMPTIONS)
    ] = "same-motion"
    compensator: Annotated[
        str,
        option(
            REPLAY,
            "energy: energy-based, as published; fixed: the coefficients of this log; model: the friction of "
            "--joint-model; others: baseline compensators.",
            one_of=choices.COMPENSATORS,
        ),
    ] = "energy"
    joint_model: Annotated[
        Path | None,
        joint_model_option(
            REPLAY,
            "Joint model, e.g. model.toml of a diagnosis; it replaces the joint fitted to the log in same-torque and "
            "same-operator, and is what --compensator model compensates.",
        ),
    ] = None
    factor: Annotated[float, option(REPLAY, "Scale factor on the estimated friction.", metavar="FACTOR")] = 1.0
    model: Annotated[
        str | None,
        option(
            TUNING, "Friction model of the energy compensator. Default: combined.", "--compensator-model", one_of=MODELS
        ),
    ] = None
    window: Annotated[
        int | None,
        option(
            TUNING,
            "Cycles per estimate of the energy compensator. Default: 4 (2 with one coefficient); paper: 2.",
            "--compensator-window",
            metavar="K",
        ),
    ] = None
    coefficients: Annotated[
        str | None,
        option(
            TUNING,
            "Constant coefficients of the energy compensator in place of its estimate [N m, N m s/rad].",
            metavar="coulomb=NM,viscous=NMS",
        ),
    ] = None
    no_passivity: Annotated[bool, option(TUNING, "No passivity controller.", "--no-passivity")] = False
    max_damping: Annotated[
        float | None,
        option(TUNING, "Maximum damping of the passivity controller [N m s/rad]. Default: 5.", metavar="NMS"),
    ] = None
    max_torque: Annotated[
        float | None,
        option(TUNING, "Maximum compensator torque [N m]. Default: Panda joint torque limits, or none.", metavar="NM"),
    ] = None
    max_rate: Annotated[
        float | None, option(TUNING, "Maximum torque rate [N m/s]. Default: 1000 for a Panda, or none.", metavar="NM/S")
    ] = None
    observer_gain: Annotated[
        float | None, option(TUNING, "Gain of disturbance_observer [1/s]. Default: 20.", metavar="1/S")
    ] = None
    motor_inertia: Annotated[
        float | None,
        option(
            TUNING,
            "Motor inertia of disturbance_observer and torque_regulation [kg m^2]. Default: fitted to the log.",
            metavar="KG_M2",
        ),
    ] = None
    desired_inertia: Annotated[
        float | None,
        option(
            TUNING, "Desired inertia of torque_regulation [kg m^2]. Default: half the motor inertia.", metavar="KG_M2"
        ),
    ] = None
    operator: Annotated[
        str | None,
        option(
            TUNING,
            "Person's impedance at the joint with --assume same-operator [kg m^2, N m s/rad, N m/rad]. Default: "
            "fitted to the log.",
            metavar="MASS,DAMPING,STIFFNESS",
        ),
    ] = None

    def __post_init__(self) -> None:
        """Refuse options that contradict each other, before any log is read."""
        idle = {"--compensator-model": self.model, "--compensator-window": self.window}
        unused = [name for name, given in idle.items() if given is not None]
        unused += ["--factor"] if self.factor != 1.0 else []
        if self.coefficients is not None and unused:
            raise UsageError(f"--coefficients {self.coefficients}: nothing is estimated; remove {', '.join(unused)}")
        energy = {
            "--coefficients": self.coefficients, "--max-damping": self.max_damping, "--no-passivity": self.no_passivity,
        }  # fmt: skip
        unused += [name for name, given in energy.items() if given]
        inertial = ("disturbance_observer", "torque_regulation")
        tuning = (
            ("--observer-gain", self.observer_gain, inertial[:1]),
            ("--motor-inertia", self.motor_inertia, inertial),
            ("--desired-inertia", self.desired_inertia, inertial[1:]),
        )
        idle_tuning = [name for name, given, users in tuning if given is not None and self.compensator not in users]
        if wrong := (unused if self.compensator != "energy" else []) or idle_tuning:
            raise UsageError(f"--compensator {self.compensator}: does not use {', '.join(wrong)}; remove it")
        if self.no_passivity and self.max_damping is not None:
            raise UsageError("--no-passivity --max-damping: only the controller damps; remove one of them")


def replay_settings(options: ReplayOptions, cycles: CycleOptions) -> "ReplaySettings":
    """Return the settings.

    Raises:
        UsageError: If a value cannot be used.
        InputError: If the file of a model is none.
    """
    from friction_audit.compensation.settings import Competitor, ModelFile, OperatorImpedance, ReplaySettings
    from friction_audit.effects.joint_model import load_model

    competitor = operator = None
    if options.compensator != "energy":
        tuning = {
            "observer_gain_per_s": options.observer_gain,
            "motor_inertia_kg_m2": options.motor_inertia,
            "desired_inertia_kg_m2": options.desired_inertia,
        }
        given: dict[str, Any] = {name: value for name, value in tuning.items() if value is not None}
        competitor = Competitor(name=options.compensator, **given)
    if options.operator is not None:
        mass, damping, stiffness = parse_numbers("--operator", options.operator, ("MASS", "DAMPING", "STIFFNESS"))
        operator = OperatorImpedance(inertia_kg_m2=mass, damping_nms_per_rad=damping, stiffness_nm_per_rad=stiffness)
    path = options.joint_model
    return ReplaySettings(
        assume=options.assume,
        compensator=_compensator(options, cycles),
        competitor=competitor,
        joint_model=None if path is None else ModelFile(path=str(path), model=load_model(path)),
        operator=operator,
        max_torque_nm=options.max_torque,
        max_torque_rate_nm_s=options.max_rate,
    )


def _compensator(options: ReplayOptions, cycles: CycleOptions) -> "EnergyCompensator":
    from friction_audit.compensation.compensators import EnergyCompensator
    from friction_audit.compensation.settings import DEFAULT_MODEL, energy_compensator

    default = EnergyCompensator()
    forced = None if options.coefficients is None else parse_coefficients(options.coefficients)
    return energy_compensator(
        model=options.model or DEFAULT_MODEL,
        window=options.window,
        factor=options.factor,
        forced=forced,
        forced_from_cycle=1,
        forced_until_acted=False,
        passivity=not options.no_passivity,
        minimum_path_rad=cycles.min_path if cycles.cycles_from == "hand" else default.minimum_path_rad,
        max_damping_nms_per_rad=(
            default.max_damping_nms_per_rad if options.max_damping is None else options.max_damping
        ),
    )


def parse_coefficients(text: str) -> "Coefficients":
    """Return the coefficients of ``"coulomb=0.2,viscous=0.1"``; one left out is zero.

    Raises:
        UsageError: If the text is anything else.
    """
    from friction_audit.compensation.compensators import Coefficients

    values: dict[str, float] = {}
    for part in text.split(","):
        name, equals, number = part.strip().partition("=")
        try:
            value = float(number)
        except ValueError:
            value = float("nan")
        if not equals or name not in ("coulomb", "viscous") or name in values or not isfinite(value):
            raise UsageError(f"--coefficients {text}: {part.strip()!r}: expected coulomb=NUMBER,viscous=NUMBER")
        if value < 0:
            raise UsageError(f"--coefficients {text}: {part.strip()!r} would brake the joint; expected zero or more")
        values[name] = value
    return Coefficients(coulomb_nm=values.get("coulomb", 0.0), viscous_nms_per_rad=values.get("viscous", 0.0))
