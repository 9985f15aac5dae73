"""``--sweep KEY=a,b,c``: every combination of values of several settings, each with a name."""

from __future__ import annotations

import hashlib
import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass

from stplan.errors import UsageError

# Of a name's part; longer ones end in a digest instead.
LONGEST_LABEL = 80
_UNSAFE = re.compile(r"[^A-Za-z0-9._=+-]+")
_OPENING, _CLOSING = "[{(", "]})"


@dataclass(frozen=True)
class Combination:
    """One value of every swept setting: ``KEY=VALUE`` overrides, and a label fit for a folder's name."""

    overrides: tuple[str, ...] = ()
    label: str = ""


def combinations(sweeps: Sequence[str]) -> list[Combination]:
    """All combinations of ``KEY=a,b,c`` sweeps, the last one varying fastest.

    Raises:
        UsageError: a sweep is no list of values, or a key or a value stands twice.
    """
    axes = [_axis(sweep) for sweep in sweeps]
    keys = [axis[0].partition("=")[0] for axis in axes]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise UsageError(f"--sweep {twice}: the key stands twice; list all its values in one sweep")
    return [Combination(chosen, _label(chosen)) for chosen in itertools.product(*axes)]


def _axis(sweep: str) -> list[str]:
    key, separator, text = sweep.partition("=")
    values = [value.strip() for value in _split(text)]
    if not key.strip() or not separator or not all(values):
        raise UsageError(f"--sweep {sweep}: KEY=VALUE,VALUE,... is expected, as in solver.mu=0.1,1")
    twice = next((value for value in values if values.count(value) > 1), None)
    if twice is not None:
        raise UsageError(f"--sweep {sweep}: the value {twice} stands twice")
    return [f"{key.strip()}={value}" for value in values]


def _split(text: str) -> list[str]:
    """`text` at its commas, but for those inside brackets or quotes, which belong to a value."""
    values = [""]
    depth, quote = 0, ""
    for letter in text:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        else:
            depth += (letter in _OPENING) - (letter in _CLOSING)
        if letter == "," and depth == 0 and not quote:
            values.append("")
        else:
            values[-1] += letter
    return values


def _label(overrides: tuple[str, ...]) -> str:
    """The overrides as they can stand in a folder's name; one that loses by that gets a digest."""
    whole = ",".join(overrides)
    label = "--".join(_UNSAFE.sub("-", override) for override in overrides)
    if _UNSAFE.search(whole.replace(",", "")) or len(overrides) != whole.count(",") + bool(whole):
        label += f"-{_digest(whole)}"
    if len(label) > LONGEST_LABEL:
        label = f"{label[: LONGEST_LABEL - 9]}-{_digest(whole)}"
    return label


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:8]
