from volcaustic._core import *
from volcaustic._core import __version__ as __version__
from volcaustic._openvdb import Grids as Grids
from volcaustic._openvdb import medium_from_pyopenvdb as medium_from_pyopenvdb
from volcaustic._openvdb import to_pyopenvdb as to_pyopenvdb
from volcaustic._sampling import sample_medium as sample_medium
