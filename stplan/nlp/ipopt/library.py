"""cyipopt's compiled module, loaded without the rest of cyipopt.

`import cyipopt` goes on to load scipy.optimize, for an interface in the style of `scipy.optimize.minimize`
that is not used here. That takes several times as long as planning a small scene.
"""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.util import find_spec, module_from_spec
from types import ModuleType
from typing import Any

_PACKAGE = "cyipopt"
_COMPILED = "ipopt_wrapper"


class _NotYetRun(ModuleType):
    """A package whose own code runs when something is asked of it that it does not have yet."""

    def __getattr__(self, name: str) -> Any:
        self.__class__ = ModuleType  # type: ignore[assignment]
        spec = self.__spec__
        if spec is not None and spec.loader is not None:
            spec.loader.exec_module(self)
        return getattr(self, name)


def load_ipopt() -> ModuleType:
    """The module with cyipopt's `Problem`. Whoever imports cyipopt gets the whole of it all the same.

    Raises:
        ImportError: cyipopt is not installed.
    """
    if _PACKAGE not in sys.modules:
        spec = find_spec(_PACKAGE)
        if spec is None:
            raise ModuleNotFoundError(f"No module named {_PACKAGE!r}", name=_PACKAGE)
        package = module_from_spec(spec)
        package.__class__ = _NotYetRun
        sys.modules[_PACKAGE] = package
    # It imports modules of the package, which need the package to be there, and no more of it.
    return import_module(_COMPILED)


def package_version() -> str:
    """The version of cyipopt."""
    return str(import_module(f"{_PACKAGE}.version").__version__)
