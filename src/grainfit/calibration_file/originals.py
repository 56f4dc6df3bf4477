"""Pictures and videos that targets name: found, named when they change, kept with a calibration."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from fnmatch import fnmatch
from functools import partial
from glob import escape
from itertools import chain
from pathlib import Path
from shutil import copy2, copytree
from typing import NamedTuple, TypeVar

from grainfit.calibration_file import messages
from grainfit.calibration_file.photographed import Original, PhotographedTarget
from grainfit.errors import InputError
from grainfit.files import is_file, is_folder
from grainfit.options.places import Place, dotted, show
from grainfit.photographs import messages as of_photographs

Kept = TypeVar("Kept")
#: Pictures near the calibration file that are searched for one that was moved.
_MOST_SEARCHED = 300


class NamedFile(NamedTuple):
    """A picture or a video that the file names: its name there, path, hash and place."""

    file: str
    path: Path
    sha256: str
    place: Place


def groups_of(
    given: Sequence[str], place: Place, *, videos: bool = False
) -> list[list[NamedFile]] | None:
    """Return the pictures of each heap, or videos; None after noting what is not there."""
    from grainfit.photographs.kept_list import hash_of
    from grainfit.photographs.pictures import is_picture
    from grainfit.photographs.videos import is_video

    is_wanted, is_other = (is_video, is_picture) if videos else (is_picture, is_video)
    folder = place.findings.folder
    groups: list[list[NamedFile]] = []
    seen: dict[str, str] = {}
    faults = len(place.findings.faults)
    for number, text in enumerate(given):
        at = place.at(number)
        found: list[list[NamedFile]] = []
        paths = _matching(folder / text)
        for path in paths:
            inside = sorted(path.iterdir()) if is_folder(path) else [path]
            names = [
                NamedFile(_shown(one, folder), one, hash_of(one), at)
                for one in inside
                if is_wanted(one) and is_file(one)
            ]
            found += [names] if names else []
        if not found:
            others = any(is_other(path) and is_file(path) for path in paths)
            if others:
                fault = messages.STILLS_NOT_VIDEO if videos else messages.VIDEO_NOT_STILLS
                at.refuse(fault.fault("", given=show(text)))
            else:
                fault = messages.NO_SUCH_VIDEO if videos else messages.NO_SUCH_PICTURE
                at.refuse(fault.fault("", given=show(text), where=_where_now(text, at, videos)))
        groups += found
        for one in chain(*found):
            if one.sha256 in seen:
                same = of_photographs.SAME_PICTURE.fault("", file=one.file, other=seen[one.sha256])
                at.refuse(same)
            seen[one.sha256] = one.file
    return None if len(place.findings.faults) > faults else groups


def _matching(path: Path) -> list[Path]:
    """Return the files and folders whose name a path with * and ? in its last part stands for."""
    if path.exists() or not is_folder(path.parent):
        return [path]
    return sorted(one for one in path.parent.iterdir() if fnmatch(one.name, path.name))


def _shown(path: Path, folder: Path) -> str:
    with suppress(ValueError):
        return str(path.relative_to(folder))
    return str(path)


def _where_now(file: str, place: Place, videos: bool) -> str:
    """Return where a picture of the calibration is now, as a sentence, or what to do."""
    # The target is two above the place of the file in its list.
    digest = begun_with(Place(place.findings, place.path[:-2])).get(file)
    moved = digest and _find(digest, place.findings.folder)
    if moved:
        return messages.MOVED_TO(path=moved)
    name = messages.NAME_VIDEOS if videos else messages.NAME_PICTURES
    return name(folder=place.findings.folder)


def begun_with(place: Place) -> Mapping[str, str]:
    """Return the hashes by file of the originals with which the calibration of a target began."""
    from grainfit.photographs.kept import FOLDER

    folder = place.findings.work_folder() / FOLDER
    return pictures_begun_with(folder).get(dotted(place.path), {})


def measured_once(
    measure: Callable[..., Kept], files: Sequence[NamedFile], place: Place, otherwise: Place
) -> Kept | None:
    """Measure files, or take what is kept of them; None after noting why they cannot be.

    Parameters
    ----------
    measure : callable
        Called with the hashes of the files by their paths, the folder in which what was found is
        kept, and ``keep_version``.
    files : sequence of NamedFile
        The files.
    place : Place
        Of the target or parameter.
    otherwise : Place
        Of the fault where nothing can be kept.
    """
    from grainfit.photographs.kept import FOLDER

    folder, begun = place.findings.work_folder() / FOLDER, begun_with(place)
    as_begun = begun == {one.file: one.sha256 for one in files}
    try:
        return measure({one.path: one.sha256 for one in files}, folder, keep_version=as_begun)
    except InputError as error:
        # The words of the fault name the file.
        at = next((one.place for one in files if str(one.path) in str(error)), files[0].place)
        at.refuse(error.faults[0])
    except OSError as error:
        otherwise.fault(messages.NOT_KEPT, folder=folder, reason=error.strerror)
    return None


def _find(digest: str, folder: Path) -> str:
    """Return the original with a hash beside the calibration file, or in a folder there."""
    from grainfit.photographs.kept_list import hash_of
    from grainfit.photographs.pictures import is_picture
    from grainfit.photographs.videos import is_video

    near = [*folder.glob("*"), *folder.glob("*/*")][:_MOST_SEARCHED]
    found = (one for one in near if (is_picture(one) or is_video(one)) and hash_of(one) == digest)
    return next((_shown(one, folder) for one in found), "")


def _changes(originals: Sequence[Original], folder: Path, place: Place) -> Iterator[str]:
    """Yield how originals differ from those with which the calibration was begun."""
    from grainfit.photographs.kept import version_of_code

    begun = begun_with(place)
    now = {one.file: one.sha256 for one in originals}
    for file, digest in begun.items():
        if file not in now and digest not in now.values():
            where = _find(digest, place.findings.folder)
            yield (
                messages.PICTURE_MOVED(file=file, path=where)
                if where
                else messages.PICTURE_GONE(file=file)
            )
        elif file not in now:
            path = next(name for name, one in now.items() if one == digest)
            yield messages.PICTURE_MOVED(file=file, path=path)
        elif now[file] != digest:
            yield messages.PICTURE_CHANGED(file=file)
    if begun:
        new = [file for file, one in now.items() if file not in begun and one not in begun.values()]
        yield from (messages.PICTURE_NEW(file=file) for file in new)
    with suppress(InputError):
        if any(one.version != version_of_code() for one in originals):
            yield messages.EARLIER_CODE(folder=folder)


def pictures_begun_with(folder: Path) -> dict[str, dict[str, str]]:
    """Return the hashes of the pictures with which a calibration was begun, by key and file."""
    from grainfit.photographs.kept_list import read_list

    try:
        return {
            str(one["key"]): {str(p["file"]): str(p["sha256"]) for p in one["pictures"]}
            for one in read_list(folder)["targets"]
        }
    except (KeyError, TypeError):
        return {}


def keep_pictures(
    targets: Sequence[tuple[str, PhotographedTarget]], folder: Path, originals: Path
) -> None:
    """Write the list of the pictures with which a calibration begins into its work folder.

    Parameters
    ----------
    targets : sequence of (str, PhotographedTarget)
        With the names of the responses in the problem.
    folder : Path
        The work folder.
    originals : Path
        Folder of the calibration file.
    """
    from grainfit.photographs.kept import FOLDER
    from grainfit.photographs.kept_list import write_list

    place = folder / FOLDER
    place.mkdir(parents=True, exist_ok=True)
    listed = []
    for response, target in targets:
        for name in {one.name for one in target.originals}:
            if target.folder.resolve() != place.resolve():
                for path in target.folder.glob(f"{escape(name)}*"):
                    with suppress(OSError):
                        (partial(copytree, dirs_exist_ok=True) if path.is_dir() else copy2)(
                            path, place / path.name
                        )
        pictures = [
            {**one.about, "file": one.file, "sha256": one.sha256} for one in target.originals
        ]
        about = {"key": target.key, "response": response, "result": target.result}
        listed.append({**about, "pictures": pictures})
    write_list(folder, originals, listed)


def hashes_of(targets: Sequence[tuple[str, PhotographedTarget]]) -> dict[str, dict[str, str]]:
    """Return the hashes of all originals by response and file."""
    return {name: {one.file: one.sha256 for one in found.originals} for name, found in targets}


def note_target(
    originals: Sequence[Original],
    result: str,
    said: Sequence[str],
    place: Place,
    *,
    speed: tuple[float, float] | None = None,
) -> None:
    """Keep with the findings what was measured on the originals of a target.

    Parameters
    ----------
    originals : sequence of Original
        All of them.
    result : str
        Value and uncertainty in words.
    said : sequence of str
        What was found on each.
    place : Place
        Of the target.
    speed : tuple of float, optional
        Rotational speed that videos show, and its standard error, rad/s.
    """
    from grainfit.photographs.kept import FOLDER

    folder = place.findings.work_folder() / FOLDER
    test = next((part for part in place.path if isinstance(part, int)), 0)
    changes = tuple(_changes(originals, folder, place))
    found = PhotographedTarget(
        dotted(place.path),
        test,
        place.key,
        tuple(originals),
        result,
        tuple(said),
        folder,
        changes,
        speed,
    )
    place.findings.photographs.append(found)
