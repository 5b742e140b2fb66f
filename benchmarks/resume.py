"""Tables of rows that are made one by one in several processes: a file that is there is gone on with."""

import csv
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import NamedTuple

Row = Mapping[str, str]


def read(path: Path) -> list[Row]:
    """All rows of a table; none where there is no file."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


class Job(NamedTuple):
    """A table: its columns, what is to be done, what makes the rows of a task, columns that name the task of a row."""

    fields: Sequence[str]
    tasks: Sequence[Row]
    work: Callable[[Row], Sequence[Mapping[str, object]]]
    keys: Sequence[str] = ("truth", "seed")

    def run(self, path: Path, workers: int | None = None) -> list[Row]:
        """Append the rows of all tasks that a file does not hold, in the order in which they are done; read all."""
        started = path.exists()
        done = {tuple(row[key] for key in self.keys) for row in read(path)}
        missing = [task for task in self.tasks if tuple(task[key] for key in self.keys) not in done]
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a", newline="") as file, ProcessPoolExecutor(workers) as pool:
            writer = csv.DictWriter(file, self.fields)
            if not started:
                writer.writeheader()
            for future in as_completed([pool.submit(self.work, task) for task in missing]):
                writer.writerows(future.result())
                file.flush()
        return read(path)
