"""What a worker does with a run, in whatever process or machine it is. It writes nothing."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable

from stplan.batch.outcome import Outcome, RunState
from stplan.batch.runs import Run
from stplan.callbacks import Progress, Stop, never
from stplan.errors import (
    OutOfMemoryError,
    SceneError,
    SeedingError,
    StoppedError,
    StplanError,
    as_stplan_error,
)
from stplan.status import Status

# A library that counts the cores would have every worker start as many threads.
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)


def execute(
    run: Run,
    timeout: float | None,
    say: Progress,
    stop: Stop = never,
) -> Outcome:
    """Plan `run`; every way to fail is an outcome.

    Args:
        timeout: seconds after which the optimisation ends with the best trajectories so far.
        say: called with a line of progress now and then.
        stop: asked now and then; when it returns True, the run gives its best so far.
    """
    started = time.monotonic()

    def elapsed() -> float:
        return time.monotonic() - started

    try:
        return _plan(run, timeout, say, stop, elapsed)
    except (Exception, KeyboardInterrupt) as error:
        known = as_stplan_error(error)
        if isinstance(known, StoppedError):
            return _interrupted(timeout, elapsed())
        if known is None:
            what = " ".join(f"{type(error).__name__}: {error}".split())
            details = "".join(traceback.format_exception(error))
            return Outcome(RunState.ERROR, (f"internal error: {what}",), {}, elapsed(), details)
        return Outcome(_state(known), tuple(str(known).splitlines()), {}, elapsed())


def _interrupted(timeout: float | None, seconds: float) -> Outcome:
    """What there is of a run that ended before it had curves."""
    if timeout is not None and seconds > timeout:
        message = f"stopped after {timeout:g} s (--timeout), before there was a result"
        return Outcome(RunState.TIMEOUT, (message,), {}, seconds)
    return Outcome(RunState.INTERRUPTED, ("interrupted before there was a result",), {}, seconds)


def _plan(
    run: Run,
    timeout: float | None,
    say: Progress,
    stop: Stop,
    elapsed: Callable[[], float],
) -> Outcome:
    from stplan.planned import plan_files
    from stplan.replanning.execution import plan
    from stplan.scene import parse_scene

    scene = parse_scene(
        run.text, source=run.source, directory=run.directory, overrides=run.overrides
    )
    if run.content_hash not in ("", scene.content_hash):
        raise SceneError(
            f"{run.source}: its files have changed since the batch began; run it again"
        )

    def late() -> bool:
        return timeout is not None and elapsed() > timeout

    planned = plan(scene, progress=say, stop=lambda: stop() or late())
    files = plan_files(planned)
    messages = (planned.advice,) if planned.advice else ()
    if planned.status is not Status.INTERRUPTED:
        state = RunState.FAILED if planned.exit_status else RunState.CERTIFIED
        return Outcome(state, messages, files, elapsed())
    if late():
        messages = (
            f"stopped after {timeout:g} s (--timeout): these are the best feasible trajectories so far",
        )
    state = RunState.TIMEOUT if late() else RunState.INTERRUPTED
    return Outcome(state, messages, files, elapsed())


def _state(error: StplanError) -> RunState:
    if isinstance(error, SeedingError):
        return RunState.NO_SEED
    if isinstance(error, OutOfMemoryError):
        return RunState.OUT_OF_MEMORY
    if isinstance(error, SceneError) or error.exit_status == 2:
        return RunState.REFUSED
    return RunState.FAILED
