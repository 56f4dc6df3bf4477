"""Read the folder of a custom model, and copy it for runs."""

from __future__ import annotations

import hashlib
import os
import shutil
import stat
from collections.abc import Callable, Iterator
from pathlib import Path, PurePosixPath

from grainfit.errors import Fault, InputError
from grainfit.files import LARGEST_MODEL, MOST_MODEL_FILES, is_file, is_folder, read_within
from grainfit.solvers.own_model import messages

_SKIPPED_FOLDERS = frozenset({"__pycache__"})


class ModelFolder:
    """Folder of a custom model, of which every run gets a copy.

    All regular files are part of the model, also in subfolders. Not part of it are: names that
    start with a dot, ``__pycache__``, work folders of calibrations, and the files that grainfit or
    the run overwrites (`ignored`). A link to another file of the folder counts as a file with the
    contents of its target. Links that lead out of the folder are faults, because a folder from
    somebody else could otherwise copy any of your files. Links to folders, broken links and special
    files are faults, too.

    Parameters
    ----------
    path : Path
        The folder.
    ignored : callable
        Predicate: True for names, relative to the folder, that every run overwrites.
    """

    def __init__(self, path: Path, ignored: Callable[[str], bool]) -> None:
        self.path = path
        self._ignored = ignored

    def check(self) -> None:
        """Raise `InputError` unless the folder exists, is not too large, and can be copied."""
        if not is_folder(self.path):
            raise InputError(messages.NO_FOLDER.fault("folder"), str(self.path))
        if os.path.realpath(self.path) == os.path.realpath(self.path.anchor):
            raise InputError(messages.ALL_FILES.fault("folder"), str(self.path))
        faults = [
            messages.NOT_COPIED.fault(name, problem=problem) for name, problem in self._unusable()
        ]
        try:
            self.files()
        except InputError as error:
            faults += error.faults
        if faults:
            raise InputError(faults, str(self.path))

    def files(self) -> list[str]:
        """Return the names of the model's files, relative to the folder, sorted.

        Raises
        ------
        InputError
            The folder is too large to be a model, or a subfolder cannot be read.
        """
        sizes = {
            name: size
            for name, path in self._walk()
            if not self._ignored(name) and (size := _size(path)) is not None
        }
        total = sum(sizes.values())
        if total > LARGEST_MODEL:
            largest = max(sizes, key=lambda name: sizes[name])
            message = (
                f"holds {total / 1e6:.0f} MB (most of all {largest}, "
                f"{sizes[largest] / 1e6:.0f} MB) and is copied for every run."
            )
            remedy = f"Leave only what a run reads, at most {LARGEST_MODEL / 1e6:.0f} MB."
            raise InputError(Fault("folder", message, remedy), str(self.path))
        return sorted(sizes)

    def hashes(self) -> dict[str, str]:
        """Return the SHA-256 of the contents of each file, by name.

        Raises
        ------
        InputError
            A file cannot be read.
        """
        return {name: hashlib.sha256(self.read(name)).hexdigest() for name in self.files()}

    def read(self, name: str, largest: int = LARGEST_MODEL) -> bytes:
        """Return the contents of a file of the model.

        Parameters
        ----------
        name : str
            Name of the file in the folder.
        largest : int
            Largest size, bytes.

        Raises
        ------
        InputError
            The file cannot be read, is larger, or is outside the folder.
        """
        path = self.path / name
        if not self._is_inside(path):
            raise InputError(messages.FILE_OUTSIDE.fault(name), str(self.path))
        try:
            return read_within(path, largest)
        except OSError as error:
            fault = messages.NOT_READ.fault(name, error=error.strerror)
            raise InputError(fault, str(self.path)) from error

    def copy(self, target: Path) -> None:
        """Copy the model's files, with their permissions, into an existing folder.

        Raises
        ------
        OSError
            A file cannot be written, or the target folder does not exist any more.
        """
        names = self.files()
        folders = {folder for name in names for folder in PurePosixPath(name).parents}
        for folder in sorted(folders - {PurePosixPath()}):
            (target / folder).mkdir(exist_ok=True)
        for name in names:
            shutil.copy(self.path / name, target / name)

    def _unusable(self) -> Iterator[tuple[str, str]]:
        for name, path in self._walk():
            if self._ignored(name):
                continue
            try:
                mode = path.stat().st_mode
            except PermissionError as error:
                yield name, f"cannot be read: {error.strerror}."
                continue
            except OSError:
                yield name, "is a broken link."
                continue
            if stat.S_ISDIR(mode):
                yield name, "is a link to a folder."
            elif not stat.S_ISREG(mode):
                yield name, "is not a regular file."
            elif not self._is_inside(path):
                yield name, f"is a link to {path.resolve()}, which is outside the folder."

    def _is_inside(self, path: Path) -> bool:
        return is_inside(path, self.path)

    def _walk(self) -> Iterator[tuple[str, Path]]:
        """Yield everything except folders; links to folders are not followed.

        Raises
        ------
        InputError
            A subfolder cannot be read, or there are too many files and folders.
        """
        met = 0
        for parent, folders, files in os.walk(self.path, onerror=self._refuse):
            base = Path(parent)
            links = [name for name in folders if _is_link(base / name)]
            folders[:] = [name for name in folders if not _is_skipped(base / name)]
            met += len(folders) + len(files)
            if met > MOST_MODEL_FILES:
                fault = messages.TOO_MANY_FILES.fault("folder", most=MOST_MODEL_FILES)
                raise InputError(fault, str(self.path))
            for name in files + links:
                if not name.startswith("."):
                    path = base / name
                    yield str(PurePosixPath(path.relative_to(self.path))), path

    def _refuse(self, error: OSError) -> None:
        """Raise `InputError` for a folder that cannot be listed: its files would be left out."""
        if isinstance(error, FileNotFoundError | NotADirectoryError):
            return
        name = os.path.relpath(error.filename or self.path, self.path)
        fault = messages.NOT_LISTED.fault(name, error=error.strerror)
        raise InputError(fault, str(self.path)) from error


def is_inside(path: Path, folder: Path) -> bool:
    """Return True if a path, with all links resolved, is in a folder."""
    # Unlike Path.resolve, this accepts circular links.
    return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))


def _is_skipped(folder: Path) -> bool:
    if folder.name.startswith(".") or folder.name in _SKIPPED_FOLDERS:
        return True
    # A calibration that works inside the model's folder must not copy its own runs.
    return is_folder(folder / "runs") and is_file(folder / "runs.sqlite")


def _is_link(path: Path) -> bool:
    try:
        return path.is_symlink()
    except OSError:
        return False


def _size(path: Path) -> int | None:
    """Return the size of a regular file, links resolved; None for anything else."""
    try:
        found = path.stat()
    except (OSError, ValueError):
        return None
    return found.st_size if stat.S_ISREG(found.st_mode) else None
