"""A recorded session, shown again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vrcomfort.api.rendering import make_renderer, shader_hashes
from vrcomfort.cli.terminal import conclude, console, progress_bar, warn
from vrcomfort.errors import InputError
from vrcomfort.plurals import counted
from vrcomfort.protocol import Condition, Protocol, load_protocol
from vrcomfort.protocol.quality_levels import Quality

if TYPE_CHECKING:
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.replay import Comparison, RecordedSession, ReplaySelection
    from vrcomfort.replay.film import ContactSheet, Eye

SHOWN = ("gaze", "ratings")


@dataclass(frozen=True)
class ReplayOptions:
    """Options of the command line; see `vrcomfort play --help`."""

    protocol: str | None
    condition: str | None
    beside: str | None
    quality: Quality | None
    trial: int | None
    from_s: float | None
    to_s: float | None
    show: str
    eye: str | None
    size_px: tuple[int, int] | None

    @property
    def shown(self) -> set[str]:
        """Return the marks that are drawn into the images.

        Raises
        ------
        InputError
            If it is nothing that can be.
        """
        names = {word.strip() for word in self.show.split(",") if word.strip()}
        if unknown := sorted(names - {*SHOWN}):
            message = f"--show {unknown[0]!r} is nothing that can be drawn in"
            raise InputError(f"{message}; there are: {', '.join(SHOWN)}")
        return names

    @property
    def eyes(self) -> tuple[Eye, ...]:
        """Return which eyes are shown: one beside another condition, both without."""
        eye = self.eye or ("left" if self.beside else "both")
        if eye == "both":
            return "left", "right"
        if eye not in {"left", "right"}:
            raise InputError(f"--eye {eye!r} is not an eye; write left, right or both")
        return ("left",) if eye == "left" else ("right",)


def play_session(
    folder: Path,
    options: ReplayOptions,
    *,
    out: Path | None,
    video: Path | None,
    quiet: bool,
    as_json: bool,
) -> None:
    """Show a recorded session again, and say whether its images are the recorded ones."""
    from vrcomfort.replay import Comparison, read_session
    from vrcomfort.replay.film import write_film, write_summary

    session = read_session(folder)
    for note in session.notes:
        warn(note)
    protocol = _protocol(options, session)
    selection = _selection(session, options, protocol)
    size_px = options.size_px or session.size_px
    drawer = make_renderer(size_px, photodiode=session.photodiode, hidden=session.hidden)
    comparison = Comparison()
    frames = _drawn(session, selection, drawer, size_px, comparison, protocol)
    sheet = _sheet(session, options, selection)
    total = _count(session, selection)
    if not total:
        message = "no recorded frame is among what --trial, --from-s and --to-s ask for"
        raise InputError(f"{message}; {_times(session)}", file=folder)
    count, length_s = 0, 0.0
    with progress_bar("drawn", total, quiet=quiet or as_json, unit="frames") as advance:
        film = write_film(frames, sheet, out=out, video=video, refresh_hz=session.refresh_hz)
        for written in film:
            advance()
            count, length_s = written.frames, written.video_s
    if size_px == session.size_px:
        _tell(session, selection, comparison, drawer, quiet=quiet or as_json)
    if out is not None:
        write_summary(out, _summary(session, selection, options, comparison, size_px))
    places = [str(each) for each in (out, video) if each is not None]
    facts = {
        "frames": count,
        "length_s": length_s,
        "images_compared": comparison.compared,
        "images_equal": comparison.equal,
        "written": places,
    }
    sentence = f"{counted(count, 'frames')}, {length_s:.2f} s: {', '.join(places)}"
    conclude(sentence, facts, quiet=quiet, as_json=as_json)


def _protocol(options: ReplayOptions, session: RecordedSession) -> Protocol | None:
    """Return the protocol that was named; say where it is not as it was."""
    if options.protocol is None:
        return None
    protocol = load_protocol(options.protocol)
    then = session.manifest["protocol"]
    if protocol.name != then["name"]:
        message = f"is protocol {protocol.name}, and this session is of {then['name']}"
        raise InputError(f"{message}; give that one", file=protocol.file)
    if protocol.sha256 != then["sha256"]:
        warn(
            f"{protocol.file}: has changed since this session; what was seen is drawn with the "
            "session's own settings, and conditions that are named here with the present ones"
        )
    return protocol


def _selection(
    session: RecordedSession, options: ReplayOptions, protocol: Protocol | None
) -> ReplaySelection:
    from vrcomfort.replay import ReplaySelection

    def named(name: str) -> Condition:
        if protocol is None:
            return session.condition(name)
        known = {each.name: each for each in protocol.conditions}
        if name not in known:
            has = ", ".join(known)
            raise InputError(f"no condition {name!r}; protocol {protocol.name} has: {has}")
        return known[name]

    def levelled(condition: Condition) -> Condition:
        return condition if options.quality is None else condition.at_level(options.quality)

    instead: dict[str, Condition] = {}
    if options.condition is not None or options.quality is not None:
        for name, own in session.conditions.items():
            instead[name] = levelled(named(options.condition) if options.condition else own)
    beside = None if options.beside is None else levelled(named(options.beside))
    from_s = float("-inf") if options.from_s is None else options.from_s
    to_s = float("inf") if options.to_s is None else options.to_s
    return ReplaySelection(options.trial, from_s, to_s, instead, beside)


def _drawn(
    session: RecordedSession,
    selection: ReplaySelection,
    drawer: StereoRenderer,
    size_px: tuple[int, int],
    comparison: Comparison,
    protocol: Protocol | None,
) -> Iterable[Any]:
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.replay import replay
    from vrcomfort.scene.load import load_scene

    @cache
    def loaded(name: str) -> Any:
        source = session.scene(name)
        if source.endswith((".glb", ".gltf")):
            if protocol is None or protocol.file is None:
                message = f"scene {source} is a file beside the protocol, at an unknown place"
                raise InputError(f"{message}; give --protocol FILE")
            source = str(protocol.file.parent / source)
        return load_scene(source)

    second = (
        None
        if selection.beside is None
        else StereoRenderer(
            drawer.ctx, size_px, photodiode=session.photodiode, hidden=session.hidden
        )
    )
    return replay(
        session,
        selection,
        drawer=drawer,
        second=second,
        load_scene=loaded,
        size_px=size_px,
        comparison=comparison,
    )


def _sheet(
    session: RecordedSession, options: ReplayOptions, selection: ReplaySelection
) -> ContactSheet:
    from vrcomfort.replay.film import ContactSheet

    shown = options.shown
    if "gaze" in shown and session.trace.gaze is None:
        warn(f"{session.folder}: has no gaze.csv; no gaze is drawn in")
    if "ratings" in shown and not any(each.ratings for each in session.exposures):
        warn(f"{session.folder}: has no ratings; none are drawn in")
    level = f", {options.quality}" if options.quality else ""
    beside = None if selection.beside is None else f"{selection.beside.name}{level}"
    return ContactSheet(
        options.eyes,
        {name: _title(name, selection, level) for name in session.conditions},
        beside,
        gaze="gaze" in shown,
        ratings="ratings" in shown,
    )


def _title(name: str, selection: ReplaySelection, level: str) -> str:
    drawn = selection.instead.get(name)
    if drawn is None or drawn.name == name:
        return f"{name}{level}"
    return f"{drawn.name}{level} (seen: {name})"


def _count(session: RecordedSession, selection: ReplaySelection) -> int:
    """Return how many frames are to be shown."""
    return sum(
        bool(session.drawn[row])
        and selection.wants(
            each.trial if row >= each.shown else 0,
            float(session.session_s[row]),
        )
        for each in session.exposures
        for row in range(each.first, each.end)
    )


def _times(session: RecordedSession) -> str:
    """Return the trials and times that can be asked for."""
    return "there are: " + ", ".join(_times_of(session))


def _times_of(session: RecordedSession) -> Iterator[str]:
    for each in session.exposures:
        start_s, end_s = session.session_s[each.shown], session.session_s[each.end - 1]
        yield f"trial {each.trial} ({start_s:.2f} s to {end_s:.2f} s)"


def _tell(
    session: RecordedSession,
    selection: ReplaySelection,
    comparison: Comparison,
    drawer: StereoRenderer,
    *,
    quiet: bool,
) -> None:
    """Report how many images are as recorded, and possible reasons where some are not."""
    from vrcomfort.gpu.gl import describe
    from vrcomfort.records import Machine
    from vrcomfort.replay.drawn import differences

    if not session.hashes:
        return
    console(quiet).print(f"{comparison.sentence}.")
    if comparison.equal == comparison.compared:
        return
    reasons = []
    if selection.instead:
        reasons.append("another condition or quality is drawn in place of what was seen")
    facts = describe(drawer.ctx)
    machine = Machine(facts["renderer"], facts["version"], shaders=shader_hashes())
    reasons += differences(session.manifest, machine)
    why = "; ".join(reasons) or "nothing that is recorded says why: `vrcomfort verify` the study"
    other = comparison.compared - comparison.equal
    warn(f"{counted(other, 'images')} {'is' if other == 1 else 'are'} not as recorded: {why}")


def _summary(
    session: RecordedSession,
    selection: ReplaySelection,
    options: ReplayOptions,
    comparison: Comparison,
    size_px: tuple[int, int],
) -> dict[str, Any]:
    drawn = {**session.conditions, **selection.instead}
    return {
        "participant": session.manifest["participant"],
        "session": session.manifest["session"],
        "size_px": list(size_px),
        "quality": options.quality,
        "conditions": {name: each.model_dump(mode="json") for name, each in drawn.items()},
        "beside": None if selection.beside is None else selection.beside.model_dump(mode="json"),
        "images_compared": comparison.compared,
        "images_equal": comparison.equal,
    }
