"""The rooms of the package in their order: written here, and nowhere else.

The layer tests hold the imports, the README and the docstring of the package to it.
"""

#: Rooms at the ground, which know nothing of screws, and that all others may use.
GROUND: dict[str, set[str]] = {
    "numerics": set(),
    "programs": {"process"},
    "text": set(),
    "process": set(),
    "fields": {"numerics"},
    "results": {"programs", "text", "process", "fields"},
}
#: Each room and the rooms that it may use, directly; errors and the version serve all.
LAYERS = {
    "friction": set(),
    "scenario": set(),
    "mechanism": {"friction", "scenario"},
    "catalogue_sizes": {"friction", "mechanism"},
    "file": {"friction", "scenario", "mechanism"},
    "geometry": {"mechanism"},
    "contact": {"mechanism", "geometry"},
    "halfspace": {"mechanism", "geometry", "contact"},
    "load_sharing": {"mechanism", "geometry", "contact"},
    "strength": {"mechanism", "geometry", "contact", "load_sharing"},
    "stiffness": {"mechanism", "geometry", "contact", "load_sharing"},
    "vibration": {"mechanism", "geometry", "contact", "load_sharing", "stiffness"},
    "dynamics": {"friction", "scenario", "mechanism", "geometry", "contact", "stiffness"},
    "response": {
        "friction",
        "mechanism",
        "geometry",
        "contact",
        "load_sharing",
        "stiffness",
        "vibration",
        "dynamics",
    },
}
LAYERS["quantities"] = set(LAYERS) - {"file", "catalogue_sizes"}
LAYERS["findings"] = LAYERS["quantities"] | {"quantities"}
_PHYSICS = LAYERS["findings"] | {"findings"}
LAYERS["sensitivities"] = LAYERS["optimisation"] = LAYERS["sweeps"] = _PHYSICS
LAYERS["uncertainty"] = _PHYSICS
LAYERS["calibration"] = LAYERS["explanation"] = _PHYSICS | {"file"}
LAYERS["dimensioning"] = _PHYSICS | {"catalogue_sizes"}
LAYERS["validation"] = _PHYSICS | {"file", "catalogue_sizes"}
LAYERS["studies"] = _PHYSICS | {"sensitivities", "optimisation", "sweeps", "explanation", "file"}
LAYERS["report"] = _PHYSICS | {
    "file",
    "sensitivities",
    "optimisation",
    "calibration",
    "sweeps",
    "uncertainty",
    "validation",
    "explanation",
    "studies",
}
LAYERS["exchange"] = LAYERS["report"] | {"report"}
LAYERS["studio"] = _PHYSICS | {"file", "sensitivities", "optimisation", "report"}
LAYERS["cli"] = set(LAYERS)
LAYERS = GROUND | {room: below | set(GROUND) for room, below in LAYERS.items()}

#: The way of the data; rooms between two arrows do not need each other, but for later ones.
WAY = (
    ("file",),
    ("mechanism",),
    ("geometry",),
    ("contact",),
    ("halfspace", "load_sharing"),
    ("strength", "stiffness"),
    ("vibration", "dynamics"),
    ("response",),
    ("quantities",),
    ("findings", "sensitivities", "optimisation", "calibration", "sweeps", "uncertainty"),
    ("studies",),
    ("report",),
)


def order() -> str:
    """The way of the data in words."""
    return " → ".join(", ".join(rooms) for rooms in WAY)
