"""Tables of rows that are made one by one in several processes: a file that is there is gone on with."""

import csv
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

Row = dict[str, str]


def read(path: Path) -> list[Row]:
    """All rows of a table; none where there is no file."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def resume(
    path: Path,
    fields: Sequence[str],
    tasks: Sequence[Mapping[str, object]],
    work: Callable[..., Sequence[Mapping[str, object]]],
    workers: int | None = None,
    keys: Sequence[str] = ("truth", "seed"),
) -> list[Row]:
    """Append the rows of all tasks that the file does not hold, in the order in which they are done; read all.

    Args:
        path: The table.
        fields: Its columns.
        tasks: What each of them is about.
        work: What makes the rows of a task.
        workers: Processes, as many as cores if None.
        keys: Columns that name the task that a row belongs to.
    """
    done = {tuple(row[key] for key in keys) for row in read(path)}
    started = path.exists()
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", newline="") as file, ProcessPoolExecutor(workers) as pool:
        writer = csv.DictWriter(file, fields)
        if not started:
            writer.writeheader()
        for future in as_completed(
            [pool.submit(work, task) for task in tasks if tuple(str(task[key]) for key in keys) not in done]
        ):
            writer.writerows(future.result())
            file.flush()
    return read(path)
