"""Estimate -> figure files in a folder."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from friction_audit.cli import choices
from friction_audit.cli.console import Voice

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from friction_audit.pipeline import Estimate


class FigureFile(NamedTuple):
    """A figure written: its kind, its joint (None: all of them) and its path."""

    kind: str
    joint: int | None
    path: Path


def possible_files(folder: Path, kinds: Sequence[str], formats: Sequence[str]) -> list[Path]:
    """Return the files that figures of these kinds would replace, whatever joints there are; known before reading."""
    sheets = [folder / f"{kind}.{suffix}" for kind in kinds for suffix in formats]
    single = [path for kind in kinds for suffix in formats for path in folder.glob(f"{kind}-joint[0-9]*.{suffix}")]
    return sheets + sorted(single)


def write_figures(
    result: "Estimate",
    folder: Path,
    kinds: Sequence[str],
    formats: Sequence[str],
    *,
    each_joint: bool,
    overwrite: bool,
    voice: Voice,
) -> list[FigureFile]:
    """Draw the kinds, all joints on a sheet and, if asked for, each joint alone; return the files."""
    from friction_audit.reporting.figures import FIGURES, REPLAY_FIGURES

    chosen: dict[str, Callable[[int | None], Figure]] = {
        kind.name: partial(kind.draw, result) for kind in (*FIGURES, *REPLAY_FIGURES) if kind.name in kinds
    }
    chosen |= _of_a_diagnosis(result, kinds, voice)
    numbers = result.interaction.joint_numbers
    unit = result.log.source.torque_unit
    return draw_files(
        chosen, numbers, folder, formats, each_joint=each_joint, overwrite=overwrite, voice=voice, unit=unit
    )


def _of_a_diagnosis(
    result: "Estimate", kinds: Sequence[str], voice: Voice
) -> "dict[str, Callable[[int | None], Figure]]":
    """Return what draws the kinds on what the declared model misses; diagnosed once, with the default settings."""
    if not set(kinds) & set(choices.DIAGNOSIS_FIGURES):
        return {}
    from friction_audit.diagnosis.settings import DiagnosisSettings
    from friction_audit.pipeline import diagnose_estimate
    from friction_audit.reporting.figures.diagnose import DIAGNOSIS_FIGURES

    with voice.step("diagnose"):
        found = diagnose_estimate(result, DiagnosisSettings())
    return {kind.name: partial(kind.draw, found) for kind in DIAGNOSIS_FIGURES if kind.name in kinds}


def draw_files(
    kinds: "Mapping[str, Callable[[int | None], Figure]]",
    numbers: Sequence[int],
    folder: Path,
    formats: Sequence[str],
    *,
    each_joint: bool,
    overwrite: bool,
    voice: Voice,
    unit: str = "N m",
) -> list[FigureFile]:
    """Draw figures of a sheet or of single joints, several at a time where the process may be copied.

    Args:
        kinds: By name, what draws one joint, given by its number, or with None all of them.
        numbers: The joints.
        folder: Where the files go.
        formats: Suffixes.
        each_joint: If True, each joint also alone.
        overwrite: If True, files that exist are replaced.
        voice: Told what is drawn.
        unit: Of the torque.
    """
    from friction_audit.parallel import in_processes, workers_for
    from friction_audit.reporting.figures.style import load_matplotlib

    # A sheet of one joint is that joint's figure.
    sheet = numbers[0] if len(numbers) == 1 else None
    alone = numbers if each_joint and sheet is None else ()
    figures = [
        (kind, name, joint)
        for kind in kinds
        for name, joint in ((kind, sheet), *((f"{kind}-joint{number}", number) for number in alone))
    ]
    load_matplotlib(formats)  # once, and not by every copy
    contents = in_processes(partial(_content, kinds, figures, formats, unit), len(figures), workers_for(len(figures)))
    files = []
    for kind, name, joint in figures:
        paths = [folder / f"{name}.{suffix}" for suffix in formats]
        with voice.step(f"draw {name}"):
            _write(next(contents), paths, overwrite=overwrite)
        files += [FigureFile(kind, joint, path) for path in paths]
    return files


def _content(
    kinds: "Mapping[str, Callable[[int | None], Figure]]",
    figures: Sequence[tuple[str, str, int | None]],
    formats: Sequence[str],
    unit: str,
    number: int,
) -> list[bytes]:
    """Draw one of the figures: what its files hold."""
    from friction_audit.reporting.figures.style import figure_bytes
    from friction_audit.reporting.units import label_in_unit

    kind, _, joint = figures[number]
    figure = label_in_unit(kinds[kind](joint), unit)
    return [figure_bytes(figure, suffix) for suffix in formats]


def _write(contents: Sequence[bytes], paths: Sequence[Path], *, overwrite: bool) -> None:
    from friction_audit.io.files import whole_file

    for content, path in zip(contents, paths, strict=True):
        with whole_file(path, overwrite=overwrite) as draft:
            draft.write_bytes(content)


def save_everywhere(figure: "Figure", paths: Sequence[Path], *, overwrite: bool) -> None:
    """Write a figure to several files, in the formats that their suffixes name."""
    from friction_audit.io.files import whole_file
    from friction_audit.reporting.figures import save_figure

    for path in paths:
        with whole_file(path, overwrite=overwrite) as draft:
            save_figure(figure, draft)
