"""The chosen folder: the only place that the studio writes to and reads pages from."""

import os
import re
from pathlib import Path

from .._errors import PrsmError
from ..process import make_folder, whole_file

#: Letters, digits and a few signs: a name that means the same to every system and shell.
_PLAIN = re.compile(r"\w[\w .+-]{0,99}", re.ASCII)


class ChosenFolder:
    """A folder, and the plain names in it.

    **Arguments:**

    - `path`: the folder; made when the first file is written.

    **Raises:** `PrsmError` if the path is a file.
    """

    def __init__(self, path: Path | str):
        self.path: Path = Path(os.path.abspath(path))
        if self.path.exists() and not self.path.is_dir():
            raise PrsmError(f"{path}: is a file; choose a folder")

    def place(self, name: str) -> Path:
        """Where a file or folder of a plain name lies.

        **Raises:** `PrsmError` for a name with a folder, and for a link that is there already.
        """
        if not _PLAIN.fullmatch(name) or name.endswith((".", " ")):
            raise PrsmError(
                f"{name!r} is not a plain file name; give letters, digits, '-', '_', '.' or "
                "spaces, without a folder"
            )
        place = self.path / name
        if place.is_symlink():
            raise PrsmError(f"{name}: is a link in the chosen folder; give another name")
        return place

    def write(self, name: str, text: str, *, replace: bool = False) -> Path:
        """Write a file, completely or not at all.

        **Raises:** `PrsmError` as `place`, and for a file that is there already unless `replace`.
        """
        place = self.place(name)
        if place.is_dir() or (place.exists() and not replace):
            remedy = "give another name" if place.is_dir() else "give another name, or replace it"
            raise PrsmError(f"{name}: exists already in the chosen folder; {remedy}")
        make_folder(self.path)
        with whole_file(place) as partial:
            partial.write_text(text, encoding="utf-8")
        return place

    def free_of_links(self, name: str) -> Path:
        """A folder of a plain name to write several files into.

        **Raises:** `PrsmError` as `place`, for a file of that name, and for a folder that contains
        links, which could lead elsewhere.
        """
        place = self.place(name)
        if place.exists() and not place.is_dir():
            raise PrsmError(f"{name}: is a file in the chosen folder; move it away")
        for one in place.rglob("*"):
            if one.is_symlink():
                shown = one.relative_to(self.path)
                raise PrsmError(f"{shown}: is a link in the chosen folder; remove it")
        return place

    def readable(self, relative: str) -> Path:
        """An existing file below the folder, by a path with `/`.

        **Raises:** `PrsmError` for any path that leads elsewhere, also by a link or by `..`, and
        for one without a file.
        """
        parts = relative.split("/")
        wrong = any(part in ("", ".", "..") or "\\" in part or "\0" in part for part in parts)
        place = self.path.joinpath(*parts) if not wrong else self.path
        if wrong or (place.is_absolute() and not place.is_relative_to(self.path)):
            raise PrsmError(f"{relative!r} is not a file below the chosen folder")
        real, inside = Path(os.path.realpath(place)), Path(os.path.realpath(self.path))
        if not real.is_relative_to(inside) or not real.is_file():
            raise PrsmError(f"{relative!r} is not a file below the chosen folder")
        return real
