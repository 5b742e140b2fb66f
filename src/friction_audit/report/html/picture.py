"""A drawing, whatever it is drawn for."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True, slots=True)
class Picture:
    """A drawing for a page.

    Attributes:
        width: Width at which its text is as large as it was drawn. [pt]
        description: What it shows, for those who do not see it.
    """

    width: float
    description: str

    @property
    def size(self) -> int:
        """Room that it takes in a file. [bytes]"""
        raise NotImplementedError
