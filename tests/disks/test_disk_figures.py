"""Figures and report of a disk, from a coarse meshed one and from a whole lumped one."""

import numpy as np
import pytest

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.nodal_diameters import nodal_diameters
from stickslip.model.contact.stiffness import static_normal_load
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import Force
from stickslip.model.rigs import lumped_blisk
from stickslip.model.rigs.octopus_blisk import BliskSector, octopus_blisk
from stickslip.model.structure.cyclic import sector_chain
from stickslip.model.structure.matrices import ModalDamping, Structure
from stickslip.results.files import open_results, save
from stickslip.show.plots.chart import Chart
from stickslip.show.plots.disk import damper_ring, disk_mode, mean_normal_load, nodal_diameter_diagram, placed_sectors
from stickslip.show.report.markup import Charts
from stickslip.show.report.page import disk as disk_section
from stickslip.show.report.responses import figures_of


@pytest.fixture(scope="module")
def dataset():
    disk = octopus_blisk(sector=BliskSector(sectors=6, cells=(1, 1, 1)), engine_order=4, modes=8)
    frequency = float(disk.frequencies(stuck=True)[0])
    return forced_response(disk, [frequency - 1.0, frequency], [0.5, 2.0], harmonics=1, samples=24).dataset


def test_the_disk_is_kept_with_the_results(dataset, tmp_path):
    again = open_results(save(dataset, tmp_path / "results.nc"))
    assert (again.attrs["sectors"], again.attrs["engine_order"]) == (6, 4)
    assert again["disk_shape"].equals(dataset["disk_shape"])
    assert set(figures_of(again)) >= {"disk_mode", "dampers", "mean_normal_load", "nodal_diameters"}


def test_the_picture_closes_round_the_disk(dataset):
    """Undeformed edges of neighbouring sectors coincide, and so does the wave: nodal diameter 2 repeats after half a turn."""
    corners, sizes = placed_sectors(dataset)
    faces = dataset.sizes["disk_quad"]
    assert corners.shape == (6 * faces, 4, 3)
    assert sizes[:faces] == pytest.approx(sizes[3 * faces : 4 * faces], rel=1e-9)
    points = np.round(corners.reshape(6, -1, 3), 6)
    first, second = ({tuple(p) for p in points[j]} for j in (0, 1))
    assert len(first & second) >= 4


@pytest.mark.parametrize("draw", [disk_mode, damper_ring, mean_normal_load, nodal_diameter_diagram])
def test_figures_are_drawn(dataset, draw, tmp_path):
    found = draw(dataset)
    (found.plot() if isinstance(found, Chart) else found).savefig(tmp_path / "figure.png", dpi=50)
    assert (tmp_path / "figure.png").stat().st_size > 5000


def test_the_section_of_the_report(dataset):
    page = disk_section({"disk": dataset}, charts := Charts(["disk"]))
    assert page.count("<img") == 2
    assert list(charts.places) == ["chart-load-0", "chart-diameters-0"]


def test_a_whole_disk_shows_each_damper(tmp_path):
    disk = lumped_blisk(sectors=4, engine_order=1)
    frequency = float(disk.frequencies(stuck=True)[0])
    dataset = forced_response(disk.full([1]), [frequency - 1.0], [2.0], harmonics=1, samples=24).dataset
    assert "disk_frequency" not in dataset
    damper_ring(dataset).savefig(tmp_path / "ring.png", dpi=50)


def test_nodal_diameters_of_the_lumped_disk():
    """The ring of the disk's masses alone: f_n of the sector matrices in closed form, here by a ring of real matrices."""
    disk = lumped_blisk(sectors=6, engine_order=2)
    found = np.sort(nodal_diameters(disk, modes=3).dataset["disk_frequency"].sel(disk_state="free").values[:4].ravel())
    whole = disk.full().frequencies(stuck=False)
    whole = whole[whole > 1.0]
    assert np.unique(np.round(whole, 6)) == pytest.approx(np.unique(np.round(found, 6)), abs=2e-6)


def test_figures_say_what_they_show(dataset):
    """The static normal load of a line by the equilibrium of the damper; what rings and colours mean; the unit of the level."""
    assert dataset.attrs["static_normal_load"] == pytest.approx(static_normal_load(147.0, 20.0), rel=1e-12)
    load = mean_normal_load(dataset)
    assert "F_C/(2 cos α)" in load.entries
    assert load.panels[0].x.label == "force level in N"
    assert "shares of the period" in damper_ring(dataset).get_suptitle()


def test_a_disk_without_contacts_has_no_picture_of_its_dampers(dataset):
    ring = sector_chain(Structure([[1.0]], [[1e6]], ("tip.x",), damping=ModalDamping(0.01)), 6, [[-1e5]])
    bare = TunedDisk(ring, (), (Force("tip.x", 1.0),), ("tip.x",), engine_order=2)
    alone = forced_response(bare, [100.0, 200.0], [1.0], harmonics=1, samples=24).dataset
    assert figures_of(dataset).keys() - figures_of(alone).keys() >= {"dampers", "mean_normal_load"}
    page = disk_section({"alone": alone}, Charts(["alone"]))
    assert "States of the dampers" not in page
    assert "Nodal diameters" in page
