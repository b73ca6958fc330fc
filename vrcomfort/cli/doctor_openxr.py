"""The part of `doctor` that looks for a headset: bindings, runtime, headset, session, timing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vrcomfort.cli.doctor_finding import Finding
from vrcomfort.cli.openxr_bindings import require_bindings
from vrcomfort.cli.terminal import warn
from vrcomfort.errors import InputError
from vrcomfort.headset.watchdog import Watchdog

if TYPE_CHECKING:
    import moderngl

    from vrcomfort.headset.openxr.capabilities import HeadsetFacts, RuntimeFacts, SessionFacts
    from vrcomfort.headset.timing import TimingTest

TIMING_TEST_S = 5.0
WITHOUT_GAZE = 'gaze.csv stays out; focus.method = "gaze" needs one, or without_gaze = "nine_ray"'
EACH_EYE = "XR_FB_eye_tracking_social"
WITHOUT_EACH_EYE = (
    f"columns of each eye in gaze.csv stay blank; a runtime with {EACH_EYE} fills them (no runtime "
    "tells pupils)"
)
PLAYBACK = "playback, rendering and reports work without"


def examine(ctx: moderngl.Context | None, *, timing: bool) -> Iterator[Finding]:
    """Yield what is there, up to the first thing that is missing.

    Parameters
    ----------
    ctx
        To begin a session with.
    timing
        Also show images, and count frames.
    """
    with Watchdog(warn):
        yield from _stages(ctx, timing=timing)


def _stages(ctx: moderngl.Context | None, *, timing: bool) -> Iterator[Finding]:
    part = "OpenXR bindings"
    try:
        yield _there(part, f"pyopenxr {require_bindings()}, with its loader")
        from vrcomfort.headset.openxr import capabilities as survey

        part = "OpenXR runtime"
        runtime = survey.find_runtime()
        yield from _runtime(runtime)
        part = "headset"
        yield from _headset(survey.find_headset())
        if ctx is None:
            return
        part = "OpenXR session"
        yield from _session(survey.try_session(ctx))
        if timing:
            part = "timing test"
            yield _timed(survey.try_timing(ctx, TIMING_TEST_S))
    except InputError as error:
        yield Finding(part, False, f"none; {PLAYBACK}", str(error), needed=False)


def _runtime(facts: RuntimeFacts) -> Iterator[Finding]:
    yield _there("OpenXR runtime", facts.name)
    missed = [name for name in facts.wanted if name not in facts.extensions]
    words = f"{len(facts.extensions)} offered; of those that help, missing: {' '.join(missed)}"
    yield Finding("extensions", True, words, needed=False, details=facts.extensions)


def _headset(facts: HeadsetFacts) -> Iterator[Finding]:
    width, height = facts.recommended_size_px
    yield _there("headset", f"{facts.name}, {width}×{height} pixels per eye recommended")
    yield Finding(
        "eye tracker",
        facts.gaze,
        "there" if facts.gaze else "none",
        "" if facts.gaze else WITHOUT_GAZE,
        needed=False,
    )
    if facts.gaze:
        yield Finding(
            "each eye",
            facts.each_eye,
            f"{EACH_EYE}; no pupils" if facts.each_eye else "not told apart",
            "" if facts.each_eye else WITHOUT_EACH_EYE,
            needed=False,
        )


def _session(facts: SessionFacts) -> Iterator[Finding]:
    details = facts.details
    words = (
        f"{details['binding'].upper()} binding, images {details['image_format']}, "
        f"space {details['space']}, depth layer {details['depth_layer']}"
    )
    yield _there("OpenXR session", words)
    rates = ", ".join(f"{rate:g}" for rate in facts.refresh_rates_hz) or "not told"
    yield _there("refresh rate", f"{facts.refresh_hz:g} Hz; can switch to: {rates}")
    left, right = facts.hidden_percent
    yield _there("visibility mask", f"hides {left:.1f} % (left) and {right:.1f} % (right)")
    yield _there("timing_trust", f"{facts.timing.trust}: {facts.timing.reason}")


def _timed(test: TimingTest | None) -> Finding:
    if test is None:
        remedy = "put the headset on (or cover its sensor), then run doctor --timing again"
        return Finding("timing test", False, "the headset sleeps", remedy, needed=False)
    words = (
        f"{test.frames} frames in {test.seconds:.1f} s, {test.dropped} dropped; period "
        f"{test.period_ms:.2f} ms, intervals {test.interval_median_ms:.2f} ms (median) and "
        f"{test.interval_p99_ms:.2f} ms (p99); frames came every {test.wait_median_ms:.2f} ms "
        f"(median) and {test.wait_p99_ms:.2f} ms (p99) by this machine's clock"
    )
    remedy = "close other programs; ask for a lower refresh rate" if test.dropped else ""
    return Finding("timing test", not test.dropped, words, remedy, needed=False)


def _there(part: str, found: str) -> Finding:
    return Finding(part, True, found, needed=False)
