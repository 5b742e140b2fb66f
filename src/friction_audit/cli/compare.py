"""``friction-audit compare``."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from friction_audit.cli import options as opt
from friction_audit.cli.outputs import ResultFolder, show
from friction_audit.cli.parameters import COMPARISON, GENERAL, group, option
from friction_audit.cli.simulate import changed

EXAMPLES = """Examples:
  friction-audit compare
  friction-audit compare --arm panda -o panda --figure-format pdf
  friction-audit compare --methods sigmoid,energy --effect stribeck:excess_nm=0.15
  friction-audit compare --persons 50 --set operator.stiffness_nm_per_rad=120 --json"""

ARMS = ("joint", "panda")
FIGURES = ("energy", "velocity-torque", "sweep", "summary")
# Written down again, so that the help text loads no numerics.
METHOD_NAMES = ("none", "sigmoid", "lugre", "disturbance_observer", "torque_regulation", "energy", "oracle")


@group(COMPARISON)
class ComparisonOptions:
    """What is compared."""

    arm: str = option("Simulated: a joint moved by a person, or a Panda guided by one.", default="joint", one_of=ARMS)
    methods: list[str] = option(
        "Methods compared with no compensation; oracle: compensates the true friction. Default: all.", "--methods",
        default=METHOD_NAMES, some_of=METHOD_NAMES,
    )  # fmt: skip
    persons: int = option("Simulated persons.", default=20, metavar="INT", min=2, max=1000)
    margin_persons: int | None = option(
        "Simulated persons for the stability margin, about eight trials each. Default: 20 for the joint, 6 for the "
        "arm; 0: no margin.", metavar="INT", min=0, max=1000, panel=GENERAL,
    )  # fmt: skip
    duration: float | None = option("Of a trial. Default: joint 40 s, arm 30 s.", metavar="SECONDS", min=1.0)


def command(
    comparison: ComparisonOptions,
    change: opt.ChangeOptions,
    general: opt.GeneralOptions,
    drawing: opt.FigureOptions,
    figures: list[str] = opt.figures_option(FIGURES),
    folder: Path = opt.folder_option("Folder of the figures.", Path("compared")),
    overwrite: opt.Overwrite = False,
) -> None:
    """Compare compensation methods in simulation (two logs: diff)."""
    from friction_audit.compensation.comparison.experiment import compare
    from friction_audit.compensation.comparison.methods import METHODS, NONE, SETUPS
    from friction_audit.reporting.compare import COMPARE, compare_lines
    from friction_audit.reporting.figures.comparison import draw_comparison
    from friction_audit.simulation.assign import as_nested
    from friction_audit.simulation.hide import hidden_effects

    voice = general.voice
    out = ResultFolder(folder=folder, figures=figures, formats=drawing.formats, overwrite=overwrite)
    out.check()
    (setup,) = (one for one in SETUPS if one.name == comparison.arm)
    settings: Any = changed(setup.settings, change, duration_s=comparison.duration)
    margin = setup.margin_seeds if comparison.margin_persons is None else comparison.margin_persons
    setup = replace(setup, settings=settings, margin_seeds=margin)
    chosen = [method for method in METHODS if method.name in (NONE, *comparison.methods)]
    with voice.step("compare") as progress:
        result = compare(setup, comparison.persons, chosen, progress)
    with voice.step("draw"):
        drawn = draw_comparison(result, figures).items()
        files = [(name, str(path)) for name, figure in drawn for path in out.save_figure(name, figure)]
    settings, effects = as_nested(settings), hidden_effects(settings)
    about = {"compared": result, "settings": settings, "effects": effects, "figures": files}
    lines = compare_lines(result.rows, len(result.seeds), len(result.tuning_seeds))
    show(lambda: COMPARE.json(about), lambda: [*lines, *(path for _, path in files)], voice)
