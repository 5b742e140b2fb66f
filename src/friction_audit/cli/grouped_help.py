"""Help text with the options under headings, without loading rich."""

from typing import Any

from typer.core import TyperCommand

GENERAL = "General"


class GroupedCommand(TyperCommand):
    """A command whose help lists its options by task, those without a task (``--help``) last."""

    def format_options(self, ctx: Any, formatter: Any) -> None:  # noqa: ANN401 - types of Typer's private copy of click
        """Write arguments, then the options of each group in the order of declaration."""
        groups: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None:
                groups.setdefault(_heading(parameter), []).append(record)
        for heading, records in groups.items():
            with formatter.section(heading):
                formatter.write_dl(records)


def _heading(parameter: Any) -> str:  # noqa: ANN401 - as above
    if parameter.param_type_name == "argument":
        return "Arguments"
    return str(getattr(parameter, "rich_help_panel", None) or GENERAL)
