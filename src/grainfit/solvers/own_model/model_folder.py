"""Read the folder of a custom model, and copy it for runs."""

from __future__ import annotations

import hashlib
import os
import shutil
import stat
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path, PurePosixPath

from grainfit.errors import Fault, InputError

#: Limits of the folder, which is copied for every run.
LARGEST_FOLDER_BYTES = 200_000_000
MOST_FILES = 20_000
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
        if not self.path.is_dir():
            raise InputError(
                Fault("folder", "does not exist.", "Give the folder of your model."), str(self.path)
            )
        if sum(1 for _ in islice(self._walk(), MOST_FILES + 1)) > MOST_FILES:
            raise InputError(
                Fault(
                    "folder",
                    f"holds more than {MOST_FILES} files and is copied for every run.",
                    "Is it the folder of your model? Leave only what a run reads.",
                ),
                str(self.path),
            )
        faults = [
            Fault(name, problem, "Put a copy of the files there instead.")
            for name, problem in self._unusable()
        ]
        sizes = {name: (self.path / name).stat().st_size for name in self.files()}
        total = sum(sizes.values())
        if total > LARGEST_FOLDER_BYTES:
            largest = max(sizes, key=lambda name: sizes[name])
            faults.append(
                Fault(
                    "folder",
                    f"holds {total / 1e6:.0f} MB (most of all {largest}, "
                    f"{sizes[largest] / 1e6:.0f} MB) and is copied for every run.",
                    f"Leave only what a run reads, at most {LARGEST_FOLDER_BYTES / 1e6:.0f} MB.",
                )
            )
        if faults:
            raise InputError(faults, str(self.path))

    def files(self) -> list[str]:
        """Return the names of the model's files, relative to the folder, sorted."""
        return sorted(
            name
            for name, path in self._walk()
            if not self._ignored(name) and path.is_file() and not path.is_dir()
        )

    def hashes(self) -> dict[str, str]:
        """Return the SHA-256 of the contents of each file, by name.

        Raises
        ------
        InputError
            A file cannot be read.
        """
        return {name: hashlib.sha256(self.read(name)).hexdigest() for name in self.files()}

    def read(self, name: str) -> bytes:
        """Return the contents of a file of the model.

        Raises
        ------
        InputError
            The file cannot be read, or is outside the folder.
        """
        path = self.path / name
        if not self._is_inside(path):
            raise InputError(Fault(name, "is outside the folder."), str(self.path))
        try:
            return path.read_bytes()
        except OSError as error:
            raise InputError(
                Fault(name, f"cannot be read: {error.strerror}."), str(self.path)
            ) from error

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
        """Yield everything except folders; links to folders are not followed."""
        for parent, folders, files in os.walk(self.path):
            base = Path(parent)
            links = [name for name in folders if (base / name).is_symlink()]
            folders[:] = [name for name in folders if not _is_skipped(base / name)]
            for name in files + links:
                if not name.startswith("."):
                    path = base / name
                    yield str(PurePosixPath(path.relative_to(self.path))), path


def is_inside(path: Path, folder: Path) -> bool:
    """Return True if a path, with all links resolved, is in a folder."""
    # Unlike Path.resolve, this accepts circular links.
    return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))


def _is_skipped(folder: Path) -> bool:
    if folder.name.startswith(".") or folder.name in _SKIPPED_FOLDERS:
        return True
    # A calibration that works inside the model's folder must not copy its own runs.
    return (folder / "runs").is_dir() and (folder / "runs.sqlite").exists()
