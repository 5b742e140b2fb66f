"""What the paper says, and what we got."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True, slots=True)
class Claim:
    """A claim of the paper as a number.

    Attributes:
        figure: Figure of the paper.
        claim: The claim in a sentence.
        paper: What the paper says or shows, in its units.
        ours: What we got, in words and with its unit.
        value: The number that decides.
        holds: Whether it holds.
        note: What a reader should know about it, or nothing.
    """

    figure: str
    claim: str
    paper: str
    ours: str
    value: float
    holds: bool
    note: str = ""
