"""What the optional packages are for, said where one is missing."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from stplan.errors import UsageError


def require(module: str, purpose: str, extra: str = "view") -> ModuleType:
    """Import a module of an optional package, which `extra` brings.

    Raises:
        UsageError: it is not installed; the sentence says how to get it.
    """
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0].replace("_", "-")
        raise UsageError(
            f"{purpose} needs the package {package}: pip install 'stplan[{extra}]'"
        ) from error
