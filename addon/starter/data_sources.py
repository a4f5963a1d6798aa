"""Where measured reflectance can be had: the databases whose files are read, as their owners describe them."""

from typing import NamedTuple

NOT_STATED = "not stated"


class DataSource(NamedTuple):
    """A database: its owner's page, the licence as the owner states it or `NOT_STATED`, the size of what is downloaded,
    and what the files are called.
    """

    name: str
    owner: str
    url: str
    licence: str
    size: str
    good_for: str
    files: str

    @property
    def facts(self) -> tuple[str, ...]:
        """What users should know, a line each."""
        return (f"By {self.owner}", f"Licence: {self.licence}", f"Size: {self.size}", f"Files: {self.files}",
                f"Good for {self.good_for}")


SOURCES = (
    DataSource("RGL", "EPFL, Realistic Graphics Lab", "https://rgl.epfl.ch/materials", "CC0 1.0",
               "0.7 MB a material as RGB, about 7 MB with spectra; anisotropic ones more",
               "the closest measurements: car paints, fabrics, metals, papers; isotropic and anisotropic", ".bsdf"),
    DataSource("MERL", "Mitsubishi Electric Research Laboratories", "https://www.merl.com/research/downloads/BRDF",
               "free for research or academic use; the copy on Zenodo (record 8101681): CC BY-SA 4.0",
               "35 MB a material, 1.25 GB for all 100",
               "the classic: 100 metals, paints, plastics, fabrics, woods and stones, densely sampled", ".binary"),
    DataSource("UTIA", "Czech Academy of Sciences, UTIA", "http://btf.utia.cas.cz/?brdf_dat_dwn",
               "on request; may not be passed on without consent", "2 MB a material",
               "150 anisotropic materials: fabrics, leather, carpets, wood; coarse in angle, without sharp highlights",
               ".bin"),
    DataSource("CURET", "Columbia and Utrecht universities", "https://www.cs.columbia.edu/CAVE/software/curet/",
               NOT_STATED, "0.1 MB for all 61 samples, grey; three times that in colour",
               "rough everyday surfaces: felt, plaster, straw, brick, velvet", "abrdf.dat"),
    DataSource("Cornell", "Cornell University, Program of Computer Graphics",
               "http://www.graphics.cornell.edu/online/measurements/reflectance/", NOT_STATED,
               "0.1 to 0.5 MB a material",
               "spectra of car paints, spray paints and house paints by a gonioreflectometer", ".astm, .mat"),
)
