"""`python -m benchmarks devices`: designs per second on each device that JAX finds."""

import argparse
import json
import sys
import time
from typing import Any

import jax

from ..harness import of_this_run, parser_of, read_json, refuse_unknown, write_json
from .tasks import TASKS


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("devices", __doc__)
    parser.add_argument("tasks", nargs="*", metavar="task", help="which tasks; default all")
    parser.add_argument("--quick", action="store_true", help="the smallest size of each task")
    parser.add_argument("--smoke", action="store_true", help="a thousand designs")
    parser.add_argument(
        "--limit", type=float, default=500.0, help="start no new row after this [s]"
    )
    given = parser.parse_args(argv)
    refuse_unknown(parser, "task", given.tasks, TASKS)
    return given


def _devices() -> tuple[list[Any], str]:
    """The processor and, if there is one, the first accelerator; else why there is none."""
    processor = jax.devices("cpu")[0]
    default = jax.devices()[0]
    if default.platform == "cpu":
        return [processor], "JAX sees no accelerator, so its rows are left out"
    return [default, processor], ""


def _rows(arguments: argparse.Namespace, devices: list[Any], document: dict[str, Any]) -> None:
    from .measured import ceilings, measured, reference

    begin, expected = time.perf_counter(), {}
    plan = [
        (place, name, device, dtype, size)
        for name in arguments.tasks or TASKS
        for device in devices
        for dtype in (("float64", "float32") if TASKS[name].single else ("float64",))
        for place, size in enumerate(TASKS[name].sizes)
    ]
    # Small sizes of all tasks first.
    for place, name, device, dtype, size in sorted(plan, key=lambda row: row[0]):
        if arguments.smoke and place == 0:
            size = 1000
        if place > 0 and (arguments.quick or arguments.smoke):
            continue
        if place > 1 and device.platform == "cpu":
            continue
        row = {"task": name, "designs": size, "device": device.device_kind, "precision": dtype}
        if time.perf_counter() - begin > arguments.limit:
            document["rows"].append({**row, "failure": "left out: the time limit was reached"})
            continue
        try:
            if name not in expected:
                expected[name] = reference(TASKS[name])
            known = document["ceilings"].setdefault(device.device_kind, {})
            if dtype not in known:
                known[dtype] = ceilings(device, dtype)
            row = measured(name, size, device, dtype, expected[name], known[dtype])
        except Exception as error:
            # A device that runs out of memory is a row with its reason.
            row["failure"] = f"{type(error).__name__}: {str(error).splitlines()[0][:160]}"
        document["rows"].append(row)
        print(json.dumps(row), flush=True)


def main(argv: list[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    arguments = _arguments(argv)
    if arguments.page is not None:
        document = read_json(arguments.page)
    else:
        devices, reason = _devices()
        document = of_this_run(1) | {"no_accelerator": reason, "ceilings": {}, "rows": []}
        if reason:
            print(reason)
        _rows(arguments, devices, document)
        write_json(arguments.out / "devices.json", document)
    if arguments.docs is not None:
        from .page import write_page

        write_page(document, arguments.docs)
    return 0


if __name__ == "__main__":
    sys.exit(main())
