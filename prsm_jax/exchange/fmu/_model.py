"""The script of the unit: a copy of this file lies in it, and its Python runs it.

It is no part of the package when it runs, so it names what it imports in full; beside it lie the
mechanism and the library that connects it to FMI.
"""

from pathlib import Path
from typing import Any

from pythonfmu3 import (
    Boolean,
    DefaultExperiment,
    Float64,
    Fmi3Causality,
    Fmi3Initial,
    Fmi3Slave,
    Fmi3Variability,
    Unit,
)
from pythonfmu3.fmi3slave import Fmi3StepResult
from pythonfmu3.variable_types import Float64Type

from prsm_jax.exchange.fmu import (
    OUTPUTS,
    UNITS,
    DrivenState,
    advance,
    described,
    values_at_start,
)
from prsm_jax.file import load


class RollerScrew(Fmi3Slave):
    """A planetary roller screw under a torque and an axial load."""

    def __init__(self, **kwargs: Any):
        super().__init__(**kwargs)
        self._mechanism = load(Path(str(self.resources)) / "mechanism.toml")
        self.description = f"Planetary roller screw: {self._mechanism.title or 'without title'}"
        self.author = self._mechanism.author or None
        self.default_experiment = DefaultExperiment(start_time=0.0, stop_time=0.1, step_size=1e-3)
        self.register_units([Unit(name, **powers) for name, powers in UNITS.items()])
        self._types = {name: Float64Type(name, unit=name) for name in UNITS}
        self._numbers: dict[str, float] = {
            "torque": 0.0,
            "load": 0.0,
            "initial_speed": 0.0,
            "initial_position": 0.0,
        }
        self._state = DrivenState()
        time = Float64(
            "time",
            causality=Fmi3Causality.independent,
            variability=Fmi3Variability.continuous,
            getter=lambda: self.time,
        )
        self.time = 0.0
        self.register_variable(time)
        self._register("torque", "N.m", "torque at the {driven}", Fmi3Causality.input)
        words = "axial load on the {moved}, against its motion at positive speed"
        self._register("load", "N", words, Fmi3Causality.input)
        words = "speed of the {driven} at the start"
        self._register("initial_speed", "rad/s", words, Fmi3Causality.parameter)
        words = "position of the {moved} at the start"
        self._register("initial_position", "m", words, Fmi3Causality.parameter)
        for output in OUTPUTS:
            for name in output.names(len(self._mechanism.stages)):
                self._numbers[name] = 0.0
                self._register(name, output.unit, output.description, Fmi3Causality.output)
        self._numbers["sticking"] = 1.0
        sticking = Boolean(
            "sticking",
            causality=Fmi3Causality.output,
            description="whether friction holds the mechanism at rest",
            getter=lambda: bool(self._numbers["sticking"]),
        )
        self.register_variable(sticking, nested=False)

    def _register(self, name: str, unit: str, words: str, causality: Fmi3Causality) -> None:
        fixed = causality == Fmi3Causality.parameter

        def set_number(value: float) -> None:
            self._numbers[name] = value

        variable = Float64(
            name,
            causality=causality,
            description=described(words, self._mechanism),
            variability=Fmi3Variability.fixed if fixed else Fmi3Variability.continuous,
            initial=Fmi3Initial.calculated if causality == Fmi3Causality.output else None,
            getter=lambda: self._numbers[name],
            setter=None if causality == Fmi3Causality.output else set_number,
        )
        self.register_variable(variable, nested=False, var_type=self._types[unit])

    def exit_initialization_mode(self) -> None:
        """Begin in the state of the parameters, with the outputs of the first inputs."""
        numbers = self._numbers
        self._state = DrivenState(0.0, numbers["initial_speed"], numbers["initial_position"])
        numbers |= values_at_start(self._mechanism, self._state, numbers["torque"], numbers["load"])

    def do_step(self, current_time: float, step_size: float) -> Fmi3StepResult:
        """Advance under the inputs, which stay constant during the step."""
        self._state, values = advance(
            self._mechanism,
            self._state,
            self._numbers["torque"],
            self._numbers["load"],
            step_size,
        )
        self._numbers |= values
        self.time = current_time + step_size
        return Fmi3StepResult()
