"""What is installed, as `stplan doctor` tells it."""

from __future__ import annotations

from importlib import metadata

from stplan.installation import parts


def test_an_extra_is_installed_as_far_as_its_packages_are(monkeypatch):
    asked = [
        "numpy>=1.26", 'matplotlib>=3.8; extra == "view"', "no-such-package>=1; extra == 'view'",
        'distributed>=2024; extra == "dask"', 'pytest; extra == "dev"',
    ]  # fmt: skip
    monkeypatch.setattr(metadata, "requires", lambda name: asked)
    view, dask = parts.installed_extras()
    assert (view.name, view.missing) == ("view", ("no-such-package",))
    assert (dask.name, dask.packages) == ("dask", ("distributed",))


def test_a_browser_is_found_by_its_name(monkeypatch):
    monkeypatch.setattr(
        parts.shutil, "which", lambda name: f"/opt/{name}" if "fire" in name else None
    )
    assert parts.find_browser() == "/opt/firefox"
    monkeypatch.setattr(parts.shutil, "which", lambda name: None)
    assert parts.find_browser() is None
