"""Whether other users of the machine could have written a file, such as a program that is run."""

import os
import stat
from pathlib import Path

#: Write permission of the group or of all.
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def others_can_write(place: int | Path) -> str | None:
    """Why users other than this one and the administrator can change a file or folder.

    Symbolic links are followed. Windows, where a folder of the user is closed to others, is not
    examined.

    **Arguments:**

    - `place`: its path, or the descriptor of an open file.

    **Returns:** the reason in words; `None` if they cannot.

    **Raises:** `OSError` if it does not exist or cannot be examined.
    """
    found = os.stat(place)
    if os.name != "posix":
        return None
    if found.st_uid not in (os.geteuid(), 0):
        return "it belongs to another user"
    return "others can write to it" if found.st_mode & _OTHERS_WRITE else None
