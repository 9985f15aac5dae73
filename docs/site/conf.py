"""How Sphinx makes the site of these pages: `make docs`, offline, warnings are errors."""

from __future__ import annotations

import sys
from importlib.metadata import version as installed
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

project = "stplan"
author = "The stplan authors"
copyright = "The stplan authors; MIT licence"
version = release = installed("stplan")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "generated",
]
root_doc = "index"
exclude_patterns = ["site/static/**", "samples/**", "paper/**"]

myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
# Notebooks are run by the tests and shown as they stand.
nb_execution_mode = "off"
nb_ipywidgets_js = {}

autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = "stplan"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
copybutton_exclude = ".linenos, .gp, .go"
