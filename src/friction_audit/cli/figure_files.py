"""Results -> figure files in a folder."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from friction_audit.cli.console import Voice
from friction_audit.reporting.figures.registry import FIGURES

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class FigureFile(NamedTuple):
    """A figure written: its kind, its joint (None: all of them) and its path."""

    kind: str
    joint: int | None
    path: Path


class Task(NamedTuple):
    """A figure to be drawn: its kind, the name of its files, and its joint (None: all of them)."""

    kind: str
    name: str
    joint: int | None


def possible_files(folder: Path, kinds: Sequence[str], formats: Sequence[str]) -> list[Path]:
    """Return the files that figures of these kinds would replace, whichever joints there are; known before reading."""
    sheets = [folder / f"{kind}.{suffix}" for kind in kinds for suffix in formats]
    single = [path for kind in kinds for suffix in formats for path in folder.glob(f"{kind}-joint[0-9]*.{suffix}")]
    return sheets + sorted(single)


def write_figures(
    results: Mapping[str, object],
    kinds: Sequence[str],
    numbers: Sequence[int],
    folder: Path,
    formats: Sequence[str],
    *,
    overwrite: bool,
    voice: Voice,
    unit: str,
    each_joint: bool = False,
) -> list[FigureFile]:
    """Draw all joints on a sheet and, if asked for, each joint alone; several at a time where a process may be copied.

    The results are given by name, the formats as suffixes.
    """
    from friction_audit.io.files import whole_file
    from friction_audit.parallel import in_processes, workers_for
    from friction_audit.reporting.figures.style import load_matplotlib

    # A sheet of one joint is that joint's figure.
    sheet = numbers[0] if len(numbers) == 1 else None
    alone = numbers if each_joint and sheet is None else ()
    drawn = [kind.name for kind in FIGURES if kind.result in results and kind.name in kinds]
    tasks = [
        task
        for kind in drawn
        for task in (Task(kind, kind, sheet), *(Task(kind, f"{kind}-joint{number}", number) for number in alone))
    ]
    load_matplotlib(formats)  # once, and not by every copy
    contents = in_processes(partial(_content, results, tasks, formats, unit), len(tasks), workers_for(len(tasks)))
    files = []
    for task in tasks:
        with voice.step(f"draw {task.name}"):
            for suffix, content in zip(formats, next(contents), strict=True):
                path = folder / f"{task.name}.{suffix}"
                with whole_file(path, overwrite=overwrite) as draft:
                    draft.write_bytes(content)
                files.append(FigureFile(task.kind, task.joint, path))
    return files


def _content(
    results: Mapping[str, object], tasks: Sequence[Task], formats: Sequence[str], unit: str, number: int
) -> list[bytes]:
    from friction_audit.reporting.figures.panels import label_in_unit
    from friction_audit.reporting.figures.style import figure_bytes

    task = tasks[number]
    kind = next(kind for kind in FIGURES if kind.name == task.kind and kind.result in results)
    figure = label_in_unit(kind.draw(results[kind.result], task.joint), unit)
    return [figure_bytes(figure, suffix) for suffix in formats]


def save_figures(figure: "Figure", paths: Sequence[Path], *, overwrite: bool) -> None:
    """Write a figure to several files, in the formats that their suffixes name."""
    from friction_audit.io.files import whole_file
    from friction_audit.reporting.figures.style import save_figure

    for path in paths:
        with whole_file(path, overwrite=overwrite) as draft:
            save_figure(figure, draft)
