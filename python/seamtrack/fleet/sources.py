"""Recordings from wherever they lie: paths, URLs that fsspec knows, parts of tar and zip archives."""

from __future__ import annotations

import os
import shutil
import tarfile
import tempfile
import zipfile
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path, PurePosixPath
from types import TracebackType
from typing import Any

#: Between an archive and a part of it: recordings.tar::monday/17.
WITHIN = "::"


class Sources:
    """Fetches recordings into a folder of its own, which goes when it is closed. An archive is fetched and listed once."""

    def __init__(self) -> None:
        self._stack = ExitStack()
        self._folder: Path | None = None
        self._archives: dict[str, Archive] = {}

    def __enter__(self) -> Sources:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._stack.close()

    @contextmanager
    def local(self, name: str) -> Iterator[Path]:
        """A path at which the recording or file can be read, for as long as the context lasts.

        Raises FileNotFoundError when there is no such thing; other errors of a store are worth another try.
        """
        if WITHIN not in name and "://" not in name:
            yield Path(name)
            return
        place = Path(tempfile.mkdtemp(dir=self._own_folder()))
        try:
            archive, _, member = name.partition(WITHIN)
            yield self._archive(archive).extract(member, place) if member else fetch(name, place)
        finally:
            shutil.rmtree(place, ignore_errors=True)

    def _own_folder(self) -> Path:
        if self._folder is None:
            self._folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix="seamtrack-")))
        return self._folder

    def _archive(self, name: str) -> Archive:
        if name not in self._archives:
            # A shard's recordings come from one archive after the other.
            for other in self._archives.values():
                other.close()
            self._archives.clear()
            file = fetch(name, Path(tempfile.mkdtemp(dir=self._own_folder()))) if "://" in name else Path(name)
            self._archives[name] = self._stack.enter_context(Archive(file, name))
        return self._archives[name]


def fetch(url: str, into: Path) -> Path:
    """Copies a file, or the files of a folder, from a store into a folder."""
    import fsspec

    store, path = fsspec.core.url_to_fs(url)
    path = path.rstrip("/")
    if store.isfile(path):
        target = into / PurePosixPath(path).name
        store.get_file(path, str(target))
        return target
    found: list[str] = store.find(path)
    if not found:
        raise FileNotFoundError(f"cannot open {url}: there is nothing there")
    target = into / (PurePosixPath(path).name or "recording")
    pairs = [(file, target / safe(PurePosixPath(file).relative_to(path), url)) for file in found]
    for folder in {local.parent for _, local in pairs}:
        folder.mkdir(parents=True, exist_ok=True)
    store.get([file for file, _ in pairs], [str(local) for _, local in pairs])
    return target


class Archive:
    """A tar or zip archive, listed once."""

    def __init__(self, file: Path, name: str) -> None:
        self._name = name
        self._file = file
        self._open: Any
        if zipfile.is_zipfile(file):
            self._open = zipfile.ZipFile(file)
            members: Iterable[tuple[str, Any]] = ((info.filename, info) for info in self._open.infolist() if not info.is_dir())
        elif tarfile.is_tarfile(file):
            self._open = tarfile.open(file)
            members = ((info.name, info) for info in self._open.getmembers() if info.isfile())
        else:
            raise ValueError(f"{name} is neither a tar nor a zip archive")
        self._members = {str(PurePosixPath(path)): info for path, info in members}
        self._folders: dict[str, list[str]] = {}
        for path in self._members:
            for parent in PurePosixPath(path).parents:
                self._folders.setdefault(str(parent), []).append(path)

    def __enter__(self) -> Archive:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._open.close()

    def extract(self, member: str, into: Path) -> Path:
        """Writes a file, or all files of a folder, of the archive into a folder."""
        wanted = PurePosixPath(member.rstrip("/"))
        if str(wanted) in self._members:
            target = into / wanted.name
            self._write(str(wanted), target)
            return target
        found = self._folders.get(str(wanted), [])
        if not found:
            raise FileNotFoundError(f"cannot open {self._name}{WITHIN}{member}: there is nothing of that name in it")
        target = into / (wanted.name or "recording")
        for path in found:
            self._write(path, target / safe(PurePosixPath(path).relative_to(wanted), self._name))
        return target

    def _write(self, path: str, target: Path) -> None:
        target.parent.mkdir(parents=True, exist_ok=True)
        info = self._members[path]
        source = self._open.open(info) if isinstance(self._open, zipfile.ZipFile) else self._open.extractfile(info)
        with source, open(target, "wb") as file:
            shutil.copyfileobj(source, file)


def safe(path: PurePosixPath, source: str) -> Path:
    """A path that stays in its folder. Raises ValueError for one that does not."""
    if path.is_absolute() or ".." in path.parts:
        raise ValueError(f"{source} holds a file outside of its own folder: {os.fspath(path)!r}")
    return Path(*path.parts)
