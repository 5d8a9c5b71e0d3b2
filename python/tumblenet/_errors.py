"""What goes wrong: inputs with all their faults, and runs that fail."""

from __future__ import annotations

from typing import NamedTuple, Sequence


class Fault(NamedTuple):
    """One fault of an input."""

    place: str
    """Place in the input, as a path of keys; empty for the whole of it."""
    found: str
    """What stands there."""
    allowed: str
    """What may stand there."""


class InputError(ValueError):
    """An input with every fault that was found in it."""

    input: str
    """File or name of the input."""
    faults: list[Fault]
    """The faults, in the order they were found."""

    def __init__(self, input: str, faults: Sequence[tuple[str, str, str]]) -> None:
        super().__init__(input, faults)
        self.input = input
        self.faults = [Fault(*fault) for fault in faults]

    def __str__(self) -> str:
        n = len(self.faults)
        lines = [f"{self.input}: {n} fault{'' if n == 1 else 's'}"]
        for place, found, allowed in self.faults:
            lines.append(f"{place or '(top level)'}: found {found}; allowed: {allowed}")
        return "\n  ".join(lines)


class SceneError(InputError):
    """A scene, a study, or what is asked of one, with every fault."""


class ControlError(InputError):
    """Controls of a simulation with every fault."""


class RunError(RuntimeError):
    """A run whose method failed."""
