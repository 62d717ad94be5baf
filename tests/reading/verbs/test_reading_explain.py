"""Every key and cell of `prsm explain`, against differences taken by hand."""

from expectations import reads
from reading_tables import assert_json

from prsm_jax.explanation import Account, Cost, Explanation, Part, Program
from prsm_jax.explanation._places import Place

_MEASURES = ("equations", "flops", "bytes", "memory_bytes", "compile_s", "run_s")


def _place(name, kind, present, law, meaning, misses, write):
    laws = ("coulomb", "viscous") if law else ()
    return Place(("stages", 0, name), name, kind, present, law, laws, meaning, misses, write)


def _made():
    whole = Account(900, 5000.0, 7000.0, 4100, 2.5, 0.75)
    without = Account(640, 4200.0, 6100.0, 4033, 2.25, 0.5)
    spin = _place("stage.1.friction.spin", "table", True, "coulomb", "spin", "no spin loss", "[a]")
    point = _place("operating_point", "table", True, None, "a point", "no speed", "[b]")
    drag = _place("stage.1.friction.drag", "table", False, None, "drag", "no drag", "[c] (torque)")
    return Explanation(
        "made up",
        (Program("steady_state", whole), Program("transient", None, "no scenario is given")),
        (
            Part(spin, {"steady_state": Cost(whole, without)}, ("nothing spins",), ("spin_loss",)),
            Part(point, {"steady_state": Cost(whole, None, "no speed: give one")}),
            Part(drag, {}),
        ),
    )


def _costs(added, without, needed):
    return {
        "steady_state": dict(zip(_MEASURES, added, strict=True))
        | {"needed": needed}
        | dict(zip([f"{m}_without" for m in _MEASURES], without, strict=True))
    }


def _part(place, reason, costs, assumed=(), lost=()):
    return {
        "name": place.name,
        "kind": place.kind,
        "present": place.present,
        "law": place.law,
        "laws": list(place.laws),
        "meaning": place.meaning,
        "without": place.without,
        "reason": reason,
        "write": place.write,
        "assumed_without": list(assumed),
        "quantities_lost_without": list(lost),
        "costs": costs,
    }


@reads("verb", "explain")
def test_explain(run, monkeypatch):
    """260 = 900 − 640 equations, and so on for each measure."""
    made = _made()
    monkeypatch.setattr("prsm_jax.explanation.explain", lambda *_, **__: made)
    found, printed = run("explain", "wu2022")
    spin, point, drag = (part.place for part in made.parts)
    none = [None] * 6
    whole = dict(zip(_MEASURES, (900, 5000.0, 7000.0, 4100, 2.5, 0.75), strict=True))
    without = (640, 4200.0, 6100.0, 4033, 2.25, 0.5)
    costs = _costs((260, 800.0, 900.0, 67, 0.25, 0.25), without, None)
    needed = _costs(none, none, "no speed: give one")
    assert_json(
        found,
        {
            "title": "made up",
            "programs": [
                {"name": "steady_state", **whole, "error": None},
                {
                    "name": "transient",
                    **dict.fromkeys(_MEASURES),
                    "error": "no scenario is given",
                },
            ],
            "parts": [
                _part(spin, "given as coulomb", costs, ["nothing spins"], ["spin_loss"]),
                _part(point, "given", needed),
                _part(drag, "not given; write [c] (torque)", {}),
            ],
        },
    )
    assert printed.row("steady_state")[:6] == ["900", "5000", "7000", "4100", "2.5", "0.75"]
    added = printed.row("stage.1.friction.spin (coulomb)")
    assert added[:6] == ["260", "800", "900", "67", "0.25", "0.25"]
    assert printed.row("operating_point")[:6] == ["needed"] * 6
    assert printed.row("stage.friction.drag") == ["[c] (torque)", "no drag"]
    printed.row("transient")
    for heading in ("Programs", "Parts carried", "Parts left out, since they are not given"):
        printed.row(heading)
