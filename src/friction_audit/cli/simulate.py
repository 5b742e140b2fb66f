"""``friction-audit simulate``."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from friction_audit.cli import chain, choices
from friction_audit.cli import options as opt
from friction_audit.cli.choices import option
from friction_audit.cli.console import Voice, say
from friction_audit.cli.grouped_help import GENERAL, OUTPUT, SIMULATION
from friction_audit.cli.outputs import show_written
from friction_audit.errors import UsageError

if TYPE_CHECKING:
    from friction_audit.io.writers.tables import Writer
    from friction_audit.joint_log import JointLog
    from friction_audit.reporting.documents import SimulatedLog
    from friction_audit.simulation.assign import Setting
    from friction_audit.simulation.effects import HiddenEffect
    from friction_audit.simulation.scenarios import Scenario

EXAMPLES = """Examples:
  friction-audit simulate --list
  friction-audit simulate joint -o run.parquet --seed 7 --truth run.truth.json
  friction-audit simulate joint -o run.csv --effect stribeck:excess_nm=0.2 --effect time_delay
  friction-audit simulate joint -o again.parquet --joint-model results/model.toml
  friction-audit simulate panda -o run.mcap --set joints.coulomb_nm=0.4@2,5 --effect backlash@3"""


def _finite(value: float | None) -> float | None:
    """Refuse what is no number; everything else is the settings' to judge."""
    if value is not None and not math.isfinite(value):
        raise typer.BadParameter(f"{value:g}: expected a number")
    return value


@dataclass(frozen=True, kw_only=True, slots=True)
class SimulationOptions:
    """What is simulated."""

    seed: int = option(
        SIMULATION, "Seed; the same seed gives the same log, bit for bit.", default=0, metavar="INT", min=0
    )
    duration: float | None = option(
        SIMULATION, "Duration of the log. Default: the scenario's.", metavar="SECONDS", callback=_finite
    )
    rate: float | None = option(SIMULATION, "Sampling rate. Default: the scenario's.", metavar="HZ", callback=_finite)
    joint_model: Path | None = option(
        SIMULATION,
        "Joint model that replaces the scenario's joints, e.g. model.toml of a diagnosis; --set and --effect apply "
        "to it.",
        metavar="FILE.toml",
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class ListOptions:
    """What is listed instead."""

    scenarios: bool = option(
        SIMULATION, "List the scenarios, or the settings of SCENARIO, and stop.", "--list", default=False
    )
    effects_there_are: bool = option(
        SIMULATION, "List the effects with their parameters and stop.", "--list-effects", default=False
    )


def command(
    scenario: Annotated[
        str | None,
        typer.Argument(
            metavar="SCENARIO", autocompletion=choices.completed_by(choices.scenarios), help="One of --list."
        ),
    ] = None,
    *,
    simulation: SimulationOptions,
    change: opt.ChangeOptions,
    lists: ListOptions,
    general: opt.GeneralOptions,
    out: Path | None = option(OUTPUT, "The log; its suffix chooses the format.", "--output", "-o", metavar="FILE"),
    dialect: str | None = opt.dialect_option(
        GENERAL, "One of convert --list-dialects. Default: the first one with FILE's suffix."
    ),
    truth: Path | None = option(OUTPUT, "Also write the true settings and effects.", metavar="FILE.json"),
    overwrite: opt.Overwrite = False,
) -> None:
    """Simulate a log whose friction and effects are known."""
    if lists.scenarios or lists.effects_there_are:
        _list(scenario, lists, json=general.json)
        return
    from friction_audit.reporting.documents import simulate_document
    from friction_audit.simulation.scenarios import simulate

    chosen, voice = _find_scenario(scenario), general.voice
    path, writer = _choose_output(out, dialect, truth, overwrite=overwrite)
    asked = {"duration_s": simulation.duration, "rate_hz": simulation.rate}
    settings = changed(chosen.settings, change, simulation.joint_model, **asked)
    with voice.step(f"simulate {chosen.name}") as progress:
        log = simulate(settings, simulation.seed, path=str(path), progress=progress).log
    about = (chosen.name, simulation.seed, settings)
    simulated = _write(about, log, path, writer, truth, voice, overwrite=overwrite)
    document = simulate_document(simulated, log, str(path), writer.name, left_out=writer.left_out(log))
    show_written(document, [path] if truth is None else [path, truth], voice, json=general.json)


def _write(
    about: tuple[str, int, Any],
    log: "JointLog",
    path: Path,
    writer: "Writer",
    truth: Path | None,
    voice: Voice,
    *,
    overwrite: bool,
) -> "SimulatedLog":
    """Write the log and its truth, both or neither: the log is put in place when the truth is there."""
    from friction_audit.io.files import sha256_of, whole_file
    from friction_audit.io.writers.write_log import check_fit
    from friction_audit.reporting.documents import SimulatedLog, truth_document, write_document
    from friction_audit.simulation.hide import hidden_effects, settings_in_sight

    with voice.step(f"write {path}"), whole_file(path, overwrite=overwrite) as draft:
        check_fit(log, writer)
        writer.write(log, draft)
        effects = [asdict(effect) for effect in hidden_effects(about[2])]
        simulated = SimulatedLog(*about[:2], settings_in_sight(about[2]), effects, sha256_of(draft))
        if truth is not None:
            with whole_file(truth, overwrite=overwrite) as other:
                other.write_text(write_document(truth_document(simulated)), encoding="utf-8")
    return simulated


def _find_scenario(name: str | None) -> "Scenario":
    from friction_audit.simulation.scenarios import SCENARIOS

    names = [scenario.name for scenario in SCENARIOS]
    if name is None:
        raise UsageError(f"SCENARIO: missing; expected one of {', '.join(names)}")
    found = next((scenario for scenario in SCENARIOS if scenario.name == name), None)
    if found is None:
        raise UsageError(
            f"{name}: no such scenario; expected one of {', '.join(names)}{choices.near_misses(name, names)}"
        )
    return found


def _choose_output(
    out: Path | None, dialect: str | None, truth: Path | None, *, overwrite: bool
) -> "tuple[Path, Writer]":
    from friction_audit.io.writers.write_log import choose_writer

    if out is None:
        raise UsageError("--output: missing; expected the file of the log, e.g. --output run.parquet")
    writer = choose_writer(out, dialect)
    chain.check_outputs([out], overwrite=overwrite, folder=not writer.suffix)
    if truth is not None:
        if truth.suffix.lower() != ".json":
            raise UsageError(f"--truth {truth}: ending {truth.suffix or 'missing'}: expected .json; rename it")
        true, log = truth.resolve(), out.resolve()
        if true.is_relative_to(log) or log.is_relative_to(true):
            raise UsageError(f"--truth {truth}: is the log {out} or lies in it; choose another name")
        chain.check_outputs([truth], overwrite=overwrite)
    return out, writer


def changed(settings: Any, change: opt.ChangeOptions, model: Path | None = None, **asked: float | None) -> Any:  # noqa: ANN401 - of any scenario
    """Return settings of a simulation, changed as asked for."""
    from friction_audit.effects.joint_model import load_model
    from friction_audit.simulation.assign import assign_texts
    from friction_audit.simulation.hide import hide, with_model
    from friction_audit.simulation.settings import IDEAL_SENSORS

    given = {name: value for name, value in asked.items() if value is not None}
    settings = replace(settings, **given)
    if change.ideal:
        settings = replace(settings, sensors=(IDEAL_SENSORS,) * len(settings.sensors))
    if model is not None:
        joints = load_model(model)
        try:
            settings = with_model(settings, joints)
        except UsageError as error:
            raise UsageError(f"--joint-model {model}: {error}") from error
    settings = assign_texts(settings, change.assignments or ())
    for name, value in given.items():
        if getattr(settings, name) != value:
            raise UsageError(f"--{name.partition('_')[0]} {value:g}: --set {name} contradicts it; remove one of them")
    return hide(settings, change.effects or ())


def _list(name: str | None, lists: ListOptions, *, json: bool) -> None:
    if json:
        raise UsageError("--json: the lists are for people; leave it out")
    lines: Sequence[str] = ()
    if lists.scenarios:
        lines = scenario_lines() if name is None else setting_lines(_find_scenario(name))
    if lists.effects_there_are:
        lines = [*lines, *effect_lines()]
    for line in lines:
        say(line)


def scenario_lines() -> list[str]:
    """Return a line per scenario: name, joints, what it is."""
    from friction_audit.simulation.scenarios import SCENARIOS

    width = max(len(scenario.name) for scenario in SCENARIOS)
    return [f"{scenario.name:<{width}}  {_about(scenario)}" for scenario in SCENARIOS]


def setting_lines(scenario: "Scenario") -> list[str]:
    """Return what a scenario is, and a line per setting with its value, as ``--set`` takes them."""
    from friction_audit.simulation.assign import paths

    values = {path: _value(value) for path, value in paths(scenario.settings).items()}
    width = max(map(len, values))
    return [f"{scenario.name}: {_about(scenario)}", *(f"  {path:<{width}}  {value}" for path, value in values.items())]


def effect_lines() -> list[str]:
    """Return the effects by family: each with its parameters, their usual values and their meaning."""
    from friction_audit.simulation.effects import EFFECTS

    families = dict.fromkeys(effect.family() for effect in EFFECTS)
    return [
        line
        for family in families
        for line in (family, *_indented(line for e in EFFECTS if e.family() == family for line in _effect(e)))
    ]


def _value(value: "Setting") -> str:
    from friction_audit.simulation.assign import Kind, write_value

    others = f"  (or {', '.join(value.others)})" if isinstance(value, Kind) and value.others else ""
    return write_value(value) + others


def _about(scenario: "Scenario") -> str:
    figure = f" ({scenario.figure})" if scenario.figure else ""
    return f"{scenario.summary}{figure}"


def _effect(effect: "type[HiddenEffect]") -> list[str]:
    from friction_audit.simulation.effects.effect import described

    rows = [(parameter.name, f"{parameter.default:g}", described(parameter)) for parameter in effect.parameters()]
    if effect.forms:
        rows.append(("form", effect.forms[0], f"one of {', '.join(effect.forms)}"))
    widths = [max(len(row[column]) for row in rows) for column in (0, 1)]
    table = [f"{name:<{widths[0]}}  {usual:<{widths[1]}}  {meaning}" for name, usual, meaning in rows]
    needs = "; takes several joints" if effect.needs_neighbours else ""
    return [f"{effect.name}: {effect.summary}{needs}", *_indented(table)]


def _indented(lines: Iterable[str]) -> Iterable[str]:
    return (f"  {line}" for line in lines)
