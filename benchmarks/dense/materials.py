"""The dense measurements: RGL's files, and materials of MERL made of the nets that stand for the real ones.

RGL's truth is the file's own function between its nodes. The files are not quite reciprocal, and the neural fits
published with them take the difference vector of one of the two directions: the authors' plugin gives the net the
direction to the light where Mitsuba gives RGL's table that to the viewer. So is "Neural", which is better at the nodes
of all eight files up to 85 degrees; "Neural, turned" is the other way, better at the extrapolation to 90 degrees for
some.

MERL's samples are the cells of a file written from a net, which is the truth. The net cannot be judged by itself: the
published rival is the microfacet model of Low and others, which was fitted to the real files.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from fitter.formats import rgl
from fitter.formats.merl import read
from fitter.model import Reflectance, published
from fitter.samples import Samples
from support import merl_files
from support.checkout import measurements

from ..harness.running import named
from ..report.baselines import neural
from ..report.methods import Model

FAMILIES = ("RGL", "MERL")
NEURAL, TURNED, MICROFACET, TABLE = "Neural", "Neural, turned", "Microfacet", "RGL table"
RGL = ("aurora_white_rgb", "cc_green_malachite_rgb", "cc_ibiza_sunset_rgb", "chm_mint_rgb", "cm_military_green_rgb",
       "ilm_solo_m_68_rgb", "irid_flake_paint1_rgb", "vch_silk_blue_rgb")
# from mirror-like to dull: metals, paints, plastics, rubber, fabrics, woods and stones
MERL = ("chrome", "brass", "nickel", "alum-bronze", "black-oxidized-steel", "red-metallic-paint", "blue-metallic-paint",
        "color-changing-paint1", "white-paint", "dark-red-paint", "specular-black-phenolic", "gray-plastic", "pvc",
        "violet-rubber", "red-fabric", "dark-specular-fabric", "fruitwood-241", "cherry-235", "white-marble",
        "black-obsidian")


@dataclass(frozen=True)
class Opened:
    """What is known of a material."""

    samples: Samples
    truth: Reflectance
    rivals: dict[str, Model]                                # published models, by name
    stored: dict[str, int] = field(default_factory=dict)    # bytes of those that the samples are made of


@dataclass(frozen=True)
class Material:
    """A dense measurement, which another process can open."""

    name: str
    family: str                 # one of FAMILIES
    open: Callable[[], Opened]


@dataclass(frozen=True)
class Turned:
    """A model with the two directions exchanged."""

    model: Model

    @property
    def nbytes(self):
        """Those of the model."""
        return self.model.nbytes

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        """The model from o to i."""
        return self.model.evaluate(theta_o, phi_o, theta_i, phi_i)


def at_hand(names=()):
    """The materials whose names contain one of the names, all without names; and why others are left out."""
    found, left_out = [], []
    folder = measurements()
    for family, wanted, opened in (("RGL", RGL, of_rgl), ("MERL", MERL, of_merl)):
        nets = folder / family.lower() / "nbrdf_nets.npz"
        for name in wanted:
            needed = [nets, *([nets.parent / f"{name}.bsdf"] if family == "RGL" else [])]
            missing = [path for path in needed if not path.is_file()]
            if missing:
                left_out.append(f"{family} {name}: {missing[0]} is not there")
            else:
                found.append(Material(name, family, partial(opened, name)))
    return named(found, names), left_out


def of_rgl(name):
    path = measurements() / "rgl" / f"{name}.bsdf"
    content = Path(path).read_bytes()
    net = neural.published(path.parent / "nbrdf_nets.npz", name)
    return Opened(rgl.read(content), rgl.read_table(content), {NEURAL: Turned(net), TURNED: net},
                  {TABLE: len(content)})


def of_merl(name):
    """A material of MERL, as a file that is made of its net."""
    folder = measurements() / "merl"
    net = neural.published(folder / "nbrdf_nets.npz", name)
    return Opened(read(merl_files.of_model(net)), net, {MICROFACET: published.find(name).model})
