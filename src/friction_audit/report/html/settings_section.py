"""Settings -> a section that names every one of them, and the command that makes the page again."""

from collections.abc import Iterator, Mapping

from friction_audit.report.html.parts import Cell, Command, Section, Table, Text

UNSET = "not set"


def settings_section(settings: Mapping[str, object], command: str) -> Section:
    """Return every setting, defaults included, and the command."""
    rows = [(Cell(text=name, code=True), Cell(text=value, code=True)) for name, value in flattened(settings)]
    table = Table(caption="Every setting, defaults included", titles=("setting", "value"), rows=rows, folded=True)
    again = (Text(lines=("This command makes the page again:",)), Command(line=command)) if command else ()
    return Section(anchor="settings", title="Settings", parts=(*again, table))


def flattened(settings: Mapping[str, object], before: str = "") -> Iterator[tuple[str, str]]:
    """Yield each setting with its full name, ``outer.inner``, and its value as text."""
    for name, value in settings.items():
        full = f"{before}{name}"
        if isinstance(value, Mapping) and value:
            yield from flattened(value, f"{full}.")
        else:
            yield full, setting_text(value)


def setting_text(value: object) -> str:
    """Return a value as people read it."""
    match value:
        case None | {}:
            return UNSET
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value:g}"
        case list() | tuple():
            return ", ".join(setting_text(item) for item in value) or UNSET
    return str(value)
