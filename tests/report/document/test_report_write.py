"""The report: right numbers, parts left out when absent, all or nothing on disk."""

import dataclasses
import errno
import re

import numpy as np
import pytest
from report_scenes import make_optimum, make_sensitivity, make_transient

from prsm_jax import set_parameter
from prsm_jax.report import ReportData, summarise_optimisation, write_report
from prsm_jax.report.document._sections import report_sections


@pytest.fixture(scope="module")
def whole(data, optimisation, wu2022):
    improved = dataclasses.replace(data, mechanism=set_parameter(wu2022, "lead", 0.012))
    return dataclasses.replace(
        data,
        title="A <small> & fast actuator",
        transient=make_transient(1),
        sensitivity=make_sensitivity(),
        optimisation=optimisation,
        improved=improved,
    )


@pytest.fixture(scope="module")
def report(whole, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report") / "out"
    return write_report(folder, whole, attachments={"optimised.toml": "title = 'x'\n"}, dpi=60)


def _plain(text: str) -> str:
    return re.sub(r"<[^>]+>", " ", text).replace("\u202f", " ").replace("&amp;", "&")


def test_the_report_holds_the_numbers_of_the_analysis(report, data):
    html, markdown = report.read_text(), (report.parent / "report.md").read_text()
    steady = data.steady
    expected = [
        f"{100 * float(steady.efficiency):.2f} %",
        f"{100 * float(data.backward.efficiency):.2f} %",
        f"{float(steady.drive_torque):.2f} N·m",
        f"{1e-6 * float(data.contacts[0].screw.hertz.max_pressure):.0f}",
        f"{float(steady.carrier_ratio[0]):.5f}",
        f"{float(steady.losses['thread_sliding']):.1f}",
        "12.06",
        "7.55°",
    ]
    for frequency in np.unique(np.asarray(data.modes[0].frequencies)):
        expected.append(f"{frequency:.{4 - int(np.log10(frequency))}f}")
    # The stable model of Wu et al. 2022 with 7 rollers.
    assert "22839" in expected
    for text in (_plain(html), markdown.replace("\u202f", " ")):
        for value in expected:
            assert value in text
    assert "80 ring gear teeth are not divisible by 7 rollers" in markdown


def test_every_picture_is_inside_and_beside_the_report(report):
    html = report.read_text()
    names = {p.stem for p in (report.parent / "figures").iterdir()}
    assert names == {
        "before_after",
        "contact_ellipses",
        "cross_section",
        "energy_flow",
        "frequencies",
        "histories",
        "losses",
        "mode_shapes",
        "optimisation",
        "power_flow",
        "powers",
        "sensitivities",
        "transient",
    }
    assert html.count("data:image/svg+xml;base64,") == len(names)
    # Nothing is fetched from elsewhere: the file can be sent alone.
    assert not re.search(r'(src|href)="(?!data:|#|optimised\.toml)', html)
    for name in names:
        assert (report.parent / "figures" / f"{name}.png").exists()
        assert f"figures/{name}.png" in (report.parent / "report.md").read_text()


def test_text_is_escaped_and_attachments_are_linked(report):
    html = report.read_text()
    assert "A &lt;small&gt; &amp; fast actuator" in html
    assert "<small>" not in html
    assert 'href="optimised.toml"' in html
    assert (report.parent / "optimised.toml").read_text() == "title = 'x'\n"


def test_the_optimisation_is_told_in_engineering_units(report):
    text = _plain(report.read_text())
    for part in (
        "Efficiency rises from 85.00 % to 87.00 %",
        "max pressure at 3000 MPa",
        "lead at its upper bound of 20.00 mm",
        "10.000 mm",
        "5.000 mm to 20.00 mm",
        "at most 3000 MPa",
        "at least 1.000 kHz",
        "+2.00 points",
        # 1e-12 per Pa, one per cent of 3 GPa.
        "+0.00300 points",
        "KKT residual): 1.0·10⁻⁹",
    ):
        assert part in text


def test_sensitivities_are_per_millimetre_and_per_degree(report):
    text = _plain(report.read_text())
    assert "per mm of lead" in text
    assert "per deg of contact angle" in text
    # 3 per m of lead is 0.3 percentage points per mm; 0.1 per rad is 0.175 points per degree.
    row = re.search(r"efficiency in %\s+85\.00\s+(\S+)\s+(\S+)", text)
    assert row
    assert float(row[1]) == pytest.approx(0.3)
    assert float(row[2]) == pytest.approx(0.1 * 100 * np.pi / 180, rel=3e-3)
    assert "not defined" in text


def test_findings_on_masses_and_stiffnesses_are_shown(report):
    text = _plain(report.read_text())
    assert "found 5 warnings: inertia (4), torsional support." in text
    assert "the moment of inertia of the screw, 0.0001822 kg·m², is m r²" in text


def test_absent_parts_are_left_out(wu2022, tmp_path):
    bare = ReportData(mechanism=wu2022, title="Bare")
    anchors = [section.anchor for section in report_sections(bare)]
    assert anchors == [
        *("status", "summary", "findings", "inputs", "mechanism", "left_out", "provenance"),
    ]
    path = write_report(tmp_path / "bare", bare, dpi=60)
    assert sorted(p.name for p in (path.parent / "figures").glob("*.png")) == ["cross_section.png"]
    for word in ("None", "nan", "Sensitivities"):
        assert not re.search(rf"\b{word}\b", _plain(path.read_text().split("</style>")[1]))


def test_a_search_that_did_not_converge_is_not_praised(wu2022):
    summary = summarise_optimisation(make_optimum(wu2022, converged=False))
    assert "stopped before it converged" in summary.in_a_sentence()


def _everything(folder):
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*"))


def test_a_failure_writes_nothing(data, tmp_path, monkeypatch):
    from prsm_jax.report.document import _analysis_sections

    out = tmp_path / "out"
    write_report(out, dataclasses.replace(data, contacts=None, modes=None, steady=None), dpi=60)
    (out / "mine.txt").write_text("keep")
    before = {p: p.read_bytes() for p in out.rglob("*") if p.is_file()}

    def full(*_):
        raise OSError(errno.ENOSPC, "the disk is full")

    monkeypatch.setattr(_analysis_sections, "loss_chart", full)
    with pytest.raises(OSError, match="disk is full"):
        write_report(out, data, dpi=60)
    with pytest.raises(OSError, match="disk is full"):
        write_report(tmp_path / "new", data, dpi=60)
    assert {p: p.read_bytes() for p in out.rglob("*") if p.is_file()} == before
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("name", ["../escape.toml", "report.html", "", "figures", "a/b"])
def test_attachments_cannot_leave_the_directory(data, tmp_path, name):
    with pytest.raises(ValueError, match="plain file name"):
        write_report(tmp_path / "out", data, attachments={name: ""})
    assert _everything(tmp_path) == []


def test_a_file_in_the_way_is_named(data, tmp_path):
    (tmp_path / "out").write_text("")
    with pytest.raises(ValueError, match="is a file"):
        write_report(tmp_path / "out", data)
