"""``friction-audit simulate``."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from friction_audit.cli import chain, options as opt
from friction_audit.cli.console import say, say_table
from friction_audit.cli.outputs import show
from friction_audit.cli.parameters import OUTPUT, SIMULATION, completed_by, flag, group, option
from friction_audit.errors import UsageError
from friction_audit.io.files import sha256_of, whole_file

if TYPE_CHECKING:
    from friction_audit.io.writers.tables import Writer

EXAMPLES = """Examples:
  friction-audit simulate --list
  friction-audit simulate joint -o run.parquet --seed 7 --truth run.truth.json
  friction-audit simulate joint -o run.csv --effect stribeck:excess_nm=0.2 --effect time_delay
  friction-audit simulate joint -o again.parquet --joint-model results/model.toml
  friction-audit simulate panda -o run.mcap --set joints.coulomb_nm=0.4@2,5 --effect backlash@3"""
SCENARIOS = "simulation.scenarios:SCENARIOS"


@group(SIMULATION)
class SimulationOptions:
    """What is simulated."""

    seed: int = option("Seed; the same seed gives the same log, bit for bit.", default=0, metavar="INT", min=0)
    duration: float | None = option("Duration of the log. Default: the scenario's.", metavar="SECONDS")
    rate: float | None = option("Sampling rate. Default: the scenario's.", metavar="HZ")
    joint_model: Path | None = option(
        "Joint model that replaces the scenario's joints, e.g. model.toml of a diagnosis; --set and --effect apply "
        "to it.", metavar="FILE.toml",
    )  # fmt: skip


@group(SIMULATION)
class ListOptions:
    """What is listed instead."""

    scenarios: bool = flag("List the scenarios, or the settings of SCENARIO, and stop.", "--list")
    effects_there_are: bool = flag("List the effects with their parameters and stop.", "--list-effects")


def command(
    scenario: Annotated[
        str | None, typer.Argument(metavar="SCENARIO", autocompletion=completed_by(SCENARIOS), help="One of --list.")
    ] = None,
    *,
    simulation: SimulationOptions,
    change: opt.ChangeOptions,
    lists: ListOptions,
    general: opt.GeneralOptions,
    out: Path | None = option("The log; its suffix is the format.", "--output", "-o", metavar="FILE", panel=OUTPUT),
    dialect: opt.Dialect = None,
    truth: Path | None = option("Also write the true settings and effects.", metavar="FILE.json", panel=OUTPUT),
    overwrite: opt.Overwrite = False,
) -> None:
    """Simulate a log whose friction and effects are known."""
    if lists.scenarios or lists.effects_there_are:
        _list(scenario, lists, json=general.json)
        return
    from friction_audit.io.writers.write_log import check_fit
    from friction_audit.reporting import documents
    from friction_audit.simulation.assign import as_nested
    from friction_audit.simulation.hide import hidden_effects
    from friction_audit.simulation.scenarios import find_scenario, simulate

    chosen, voice, seed = find_scenario(scenario), general.voice, simulation.seed
    path, writer = _choose_output(out, dialect, truth, overwrite)
    asked = {"duration_s": simulation.duration, "rate_hz": simulation.rate}
    settings = changed(chosen.settings, change, simulation.joint_model, **asked)
    with voice.step(f"simulate {chosen.name}") as progress:
        log = simulate(settings, seed, path=str(path), progress=progress).log
    # Both the log and its truth are written, or neither: the log is put in place when the truth is there.
    with voice.step(f"write {path}"), whole_file(path, overwrite=overwrite) as draft:
        check_fit(log, writer)
        writer.write(log, draft)
        effects, seen = hidden_effects(settings), as_nested(settings)
        simulated = {"scenario": chosen.name, "seed": seed, "settings": seen, "effects": effects}
        simulated["output"] = {"path": str(path), "sha256": sha256_of(draft), "writer": writer, "log": log}
        if truth is not None:
            with whole_file(truth, overwrite=overwrite) as other:
                text = documents.write_document(documents.TRUTH.json(simulated))
                other.write_text(text, encoding="utf-8")
    document = documents.SIMULATE.json(simulated)
    voice.warn((warning["message"] for warning in document["warnings"]), held=True)
    show(lambda: document, lambda: map(str, filter(None, (path, truth))), voice)


def _choose_output(out: Path | None, dialect: str | None, truth: Path | None, overwrite: bool) -> "tuple[Path, Writer]":
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
    """Print the scenarios, or the settings of one as ``--set`` takes them, and the effects."""
    from friction_audit.effects.registry import FAMILIES
    from friction_audit.simulation.assign import Kind, paths, write_value
    from friction_audit.simulation.effects import EFFECTS
    from friction_audit.simulation.effects.effect import described
    from friction_audit.simulation.scenarios import PAPER_SCENARIOS, SCENARIOS, find_scenario

    if json:
        raise UsageError("--json: the lists are for people; leave it out")
    about = {one.name: one.summary for one in SCENARIOS}
    for one in PAPER_SCENARIOS:  # they have the number of their figure in their name
        about[one.name] += f" (Fig. {one.name.removeprefix('fig').partition('-')[0]})"
    if lists.scenarios and name is None:
        say_table(list(about.items()))
    elif lists.scenarios:
        scenario = find_scenario(name)
        say(f"{scenario.name}: {about[scenario.name]}")
        rows = []
        for path, value in paths(scenario.settings).items():
            others = f"  (or {', '.join(value.others)})" if isinstance(value, Kind) and value.others else ""
            rows.append((path, write_value(value) + others))
        say_table(rows, margin="  ")
    for family, members in FAMILIES.items() if lists.effects_there_are else ():
        say(family)
        for effect in (one for one in EFFECTS if one.name in members):
            say(f"  {effect.name}: {effect.summary}{'; takes several joints' if effect.needs_neighbours else ''}")
            known = [(one.name, f"{one.default:g}", described(one)) for one in effect.parameters()]
            forms = [("form", effect.forms[0], f"one of {', '.join(effect.forms)}")] if effect.forms else []
            say_table(known + forms, margin="    ")
