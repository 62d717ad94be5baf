"""What numbers must satisfy together: a bore inside its cylinder, a carrier with a hole."""

from ..mechanism import Mechanism, Stage
from ._messages import Misplaced


def _millimetres(value: float) -> str:
    return f"{value * 1e3:.6g} mm"


def _below(part: object, body: str, key: str, limit: float, meaning: str):
    value = getattr(part, key, None)
    if value is not None and not float(value) < limit:
        message = f"must be less than {meaning}, {_millimetres(limit)}"
        raise Misplaced((body, key), message)


def _check_stage(stage: Stage):
    # Python floats: the thread's own properties would start JAX's compiler for two products.
    roller_radius = float(stage.thread.roller_radius)
    screw_radius = (float(stage.thread.starts) - 2) * roller_radius
    centre_distance = screw_radius + roller_radius
    _below(stage.screw, "screw", "bore_radius", screw_radius, "the screw's nominal radius")
    _below(stage.roller, "roller", "bore_radius", roller_radius, "the roller's nominal radius")
    _below(
        stage.carrier,
        "carrier",
        "radial_width",
        2 * centre_distance,
        "twice the radius of the circle of the roller axes",
    )
    shaft = None if stage.strength is None else stage.strength.shaft
    if shaft is not None and shaft.root_radius is not None:
        root, bore = float(shaft.root_radius), stage.screw.bore_radius
        if not root > (0.0 if bore is None else float(bore)):
            message = f"must be more than the screw's bore_radius, {_millimetres(float(bore or 0))}"
            raise Misplaced(("strength", "shaft", "root_radius"), message)
    line = stage.line_contact
    if line is not None:
        for body in ("screw", "roller"):
            major = float(getattr(line, f"{body}_major_radius"))
            meaning = f"{body}_major_radius"
            _below(line, "line_contact", f"{body}_minor_radius", major, meaning)


def check_together(mechanism: Mechanism) -> None:
    """Refuse dimensions that contradict each other.

    **Raises:** `Misplaced` at the first key that does not fit the others.
    """
    for index, stage in enumerate(mechanism.stages):
        try:
            _check_stage(stage)
        except Misplaced as error:
            raise Misplaced(("stage", index, *error.place), error.message) from None
