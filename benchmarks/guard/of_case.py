"""The numbers of a case that the guard compares, from the case's own JSON."""

import math
from collections.abc import Mapping
from typing import Any

from ..harness._markdown import setting_text
from .compared import Numbers


def numbers_of_case(document: Mapping[str, Any]) -> Numbers:
    """Errors of this package's methods and approximations, and their speeds over the baseline.

    A speed is the best time of the baseline, at the same setting if it has that, else at its first,
    over the best time of the method. Best times vary least where other programs share the machine.
    Rivals are not judged: their versions are not ours.

    **Arguments:**

    - `document`: as `benchmarks.harness.document` writes it.
    """
    errors, not_finite, ratios = {}, {}, {}
    for problem in document["problems"]:
        theirs = [row for row in problem["results"] if row["method"] == problem["baseline"]]
        for row in problem["results"]:
            if row["kind"] == "rival":
                continue
            name = f"{problem['name']}: {row['method']}{_setting(row['setting'])}"
            for quantity, error in row["errors"].items():
                label = f"{name}: error in {quantity}"
                errors[label] = math.inf if error["max"] is None else error["max"]
                if error["not_finite"]:
                    not_finite[label] = error["not_finite"]
            if row["method"] != problem["baseline"]:
                label = f"{name}: speed over {problem['baseline']}"
                same = [one for one in theirs if one["setting"] == row["setting"]] or theirs
                ratios[label] = same[0]["best_s"] / row["best_s"]
    return Numbers(errors=errors, not_finite=not_finite, ratios=ratios)


def _setting(setting: Mapping[str, Any] | None) -> str:
    return "" if setting is None else f", {setting_text(**setting)}"
