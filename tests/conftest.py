"""Settings that all tests share."""

from hypothesis import settings

# Same examples every time, and none that fails because the machine is busy.
settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")
