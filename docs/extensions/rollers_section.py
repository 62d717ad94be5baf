"""A section of the report: the rollers of each stage."""

from prsm_jax.report import Section, Table, report_section


@report_section("rollers", "Rollers")
def rollers(data):
    rows = []
    for number, stage in enumerate(data.mechanism.stages, start=1):
        radius = float(stage.thread.roller_radius)
        rows.append((str(number), str(stage.roller_count), f"{radius * 1e3:.4g}"))
    table = Table("Rollers by stage", ("stage", "number", "nominal radius [mm]"), tuple(rows))
    return Section("rollers", "Rollers", tables=(table,))
