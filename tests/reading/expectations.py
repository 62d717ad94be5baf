"""Which test reads which chart, table or verb; `test_reading_is_complete` finds the others."""

from collections import defaultdict
from collections.abc import Callable

#: Names of tests by what they read: "chart", "section" or "verb", and its name.
READ: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))


def reads(kind: str, *names: str) -> Callable:
    """Mark a test as the reader of a chart (its function), a section or a verb."""

    def mark(test):
        for name in names:
            READ[kind][name].append(test.__name__)
        return test

    return mark
