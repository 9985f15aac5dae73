"""Other planners and crowd models, driven on the same scenes as this one.

One file a rival, each with the `PACKAGE` it needs from PyPI and a `drive` that says who went where. They
are imported only where they are run, and nothing else in the package depends on them.
"""
