"""Where a mechanism came from, and who made the report."""

import dataclasses
import hashlib
from collections.abc import Sequence

from ...file import source_bytes


@dataclasses.dataclass(frozen=True)
class Origin:
    """The file of a mechanism, and the fields of a report for signature.

    - `text`: the text of the file; empty for a mechanism that came from no file.
    - `sha256`: hash of the bytes of the file, as `sha256sum` gives it.
    - `settings`: numbers that were changed after reading, such as `lead=12 mm`.
    - `author`, `revision`: in place of those of the file.
    - `date`: as it is shown. What is empty is a blank to be filled in.
    """

    text: str = ""
    sha256: str = ""
    settings: tuple[str, ...] = ()
    author: str = ""
    revision: str = ""
    date: str = ""


def origin_of_file(
    source: str,
    *,
    settings: Sequence[str] = (),
    author: str = "",
    revision: str = "",
    date: str = "",
) -> Origin:
    """The origin of a mechanism that was read from a file or an example.

    **Arguments:**

    - `source`: what was given to `prsm_jax.load`.
    - `settings`: numbers that were changed after reading, such as `lead=12 mm`.
    - `author`, `revision`, `date`: for the report.

    **Raises:** `FileError` if it cannot be read.
    """
    data = source_bytes(source)
    digest = hashlib.sha256(data).hexdigest()
    text = data.decode("utf-8", errors="replace")
    return Origin(text, digest, tuple(settings), author, revision, date)
