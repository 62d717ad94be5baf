"""The command line, without its verbs yet: each verb's module adds itself to it."""

from cyclopts import App

from .._version import __version__

app = App(
    name="prsm",
    help="Planetary roller screw mechanisms: analyse, differentiate, improve.",
    help_epilogue=(
        "Every verb takes --plugin MODULE (a Python file, a module or an entry point), which adds "
        "friction laws, quantities, sections of the report or verbs of your own."
    ),
    version=__version__,
)

#: One complete command for each verb, at the end of its help; names without a verb are ignored.
EXAMPLES = {
    "bench": "prsm bench hertz --quick --out out",
    "calibrate": "prsm calibrate my_screw.toml --data measured.csv --parameters lead",
    "campbell": "prsm campbell actuator --max-rpm 3000 --out out",
    "check": "prsm check actuator --set 'lead=12 mm'",
    "contact": "prsm contact actuator --out out",
    "demo": "prsm demo --out out/demo",
    "doctor": "prsm doctor --json doctor.json",
    "example": "prsm example actuator --out .",
    "explain": "prsm explain actuator --programs steady_state",
    "export": "prsm export actuator --as dxf,tables --out out",
    "modal": "prsm modal wu2022 --against contact_angle --from '20 deg' --to '70 deg'",
    "new": "prsm new screw.toml --load '10 kN' --stroke '300 mm' --speed '100 mm/s'",
    "optimise": "prsm optimise actuator --out out",
    "pareto": "prsm pareto actuator --maximise efficiency --minimise mass --out out",
    "quantities": "prsm quantities --json quantities.json",
    "report": "prsm report actuator --out out",
    "response": "prsm response wu2022 --from 'screw u' --to 'nut u' --fmax 40000 --out out",
    "sensitivity": "prsm sensitivity actuator --quantities efficiency --parameters lead",
    "simulate": "prsm simulate actuator_mission --samples 2000 --out out",
    "steady": "prsm steady actuator --set 'lead=12 mm' --json steady.json",
    "strength": "prsm strength actuator --out out",
    "studio": "prsm studio actuator --out my_designs",
    "study": "prsm study actuator --driver lead --maximise efficiency --out out",
    "sweep": "prsm sweep wu2022 --axis 'lead=8 mm:12 mm:5' --quantities mass --out out",
    "tolerance": "prsm tolerance actuator_tolerances --method first_order --out out",
    "validate": "prsm validate wu2022 --out out",
}
