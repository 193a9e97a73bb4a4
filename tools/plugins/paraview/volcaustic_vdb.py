"""A reader of OpenVDB volumes for ParaView builds that have none, as Debian's: Tools > Manage Plugins > Load New.

Opens .vdb files, one or a time series (name.0001.vdb, ...; a file's number is its time), as image data whose points are the
voxels' centres in world space, with an array for each grid. Reads with pyopenvdb, which must be of ParaView's own Python.
"""

import os
import re
import sys

import numpy as np
from paraview.util.vtkAlgorithm import smproperty, smproxy
from vtkmodules.numpy_interface import dataset_adapter
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import vtkDataArraySelection
from vtkmodules.vtkCommonDataModel import vtkImageData

MOST_VALUES = 1 << 31  # 8 GiB of numbers: a sparse volume may be a huge box


class Refused(Exception):
    """What a person is told."""


def openvdb():
    try:
        import pyopenvdb
    except ImportError:
        raise Refused("OpenVDB volumes: needs pyopenvdb in ParaView's Python; install python3-openvdb") from None
    return pyopenvdb


def read(file, name):
    """The grid, or nothing where pyopenvdb has no such type."""
    try:
        return openvdb().read(file, name)
    except Exception as error:  # of Boost.Python, whatever it is
        print(f"{file}: {name}: left out: {str(error).splitlines()[0]}", file=sys.stderr)
        return None


def lattice(grid):
    """World position of voxel (0, 0, 0) and the voxel's edges; nothing where the axes are not the world's."""
    origin = np.array(grid.transform.indexToWorld((0, 0, 0)))
    edges = np.array([grid.transform.indexToWorld(tuple(int(i == a) for i in range(3))) for a in range(3)]) - origin
    size = np.diagonal(edges).copy()
    return (origin, size) if np.all(size > 0) and np.allclose(edges, np.diag(size)) else None


def times_of(files):
    """The numbers of a series; where files have none, or the same, their places in the list."""
    numbers = [re.search(r"(\d+)\.vdb$", os.path.basename(file)) for file in files]
    if not all(numbers) or len({int(number.group(1)) for number in numbers}) < len(files):
        return [float(i) for i in range(len(files))]
    return [float(number.group(1)) for number in numbers]


class Volume:
    """The wanted grids of a file on one lattice, that of the first."""

    def __init__(self, file, wanted):
        self.file = file
        self.grids = {}
        for name in wanted:
            grid = read(file, name)
            placed = lattice(grid) if grid else None
            if grid and not placed:
                print(f"{file}: {name}: left out: its axes are not the world's", file=sys.stderr)
            if not placed:
                continue
            if not self.grids:
                self.origin, self.size = placed
            elif not np.allclose(placed, (self.origin, self.size)):
                print(f"{file}: {name}: left out: lies on other voxels than {next(iter(self.grids))}", file=sys.stderr)
                continue
            self.grids[name] = grid
        if not self.grids:
            raise Refused(f"{file}: has no grid that can be shown; choose others, or convert it with volcaustic")
        boxes = [g.evalActiveVoxelBoundingBox() for g in self.grids.values() if g.activeVoxelCount()]
        self.low = np.min([b[0] for b in boxes], axis=0) if boxes else np.zeros(3, int)
        self.high = np.max([b[1] for b in boxes], axis=0) if boxes else np.zeros(3, int)

    def extent(self):
        return [int(v) for pair in zip(self.low, self.high) for v in pair]

    def arrays(self):
        dims = tuple(int(n) for n in self.high - self.low + 1)
        values = float(np.prod(dims, dtype=float)) * sum(3 if self.is_vector(g) else 1 for g in self.grids.values())
        if values > MOST_VALUES:
            raise Refused(f"{self.file}: a box of {dims[0]} x {dims[1]} x {dims[2]} voxels is too large; choose fewer grids")
        for name, grid in self.grids.items():
            array = np.empty(dims + (3,) if self.is_vector(grid) else dims, np.float32)
            grid.copyToArray(array, ijk=tuple(int(v) for v in self.low))
            flat = array.transpose(2, 1, 0, *range(3, array.ndim)).reshape(-1, *array.shape[3:])
            yield name, np.ascontiguousarray(flat)

    @staticmethod
    def is_vector(grid):
        return isinstance(grid.background, tuple)


@smproxy.reader(name="OpenVDBVolumes", label="OpenVDB Volumes", extensions="vdb", file_description="OpenVDB volumes")
class OpenVDBVolumes(VTKPythonAlgorithmBase):
    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkImageData")
        self._files = []
        self._selection = vtkDataArraySelection()
        self._selection.AddObserver("ModifiedEvent", lambda *_: self.Modified())
        self._volume = None  # of _key
        self._key = None

    @smproperty.xml("""<StringVectorProperty name="FileNames" command="AddFileName" clean_command="ClearFileNames"
        number_of_elements="0" repeat_command="1" panel_visibility="never"><FileListDomain name="files"/>
        <Documentation>One .vdb, or the files of a time series.</Documentation></StringVectorProperty>""")
    def AddFileName(self, name):
        if name and name != "None":
            self._files.append(name)
            self.Modified()

    def ClearFileNames(self):
        self._files = []
        self.Modified()

    @smproperty.dataarrayselection(name="Grids")
    def GetGrids(self):
        return self._selection

    @smproperty.doublevector(name="TimestepValues", information_only="1", si_class="vtkSITimeStepsProperty")
    def GetTimestepValues(self):
        return self._times() if len(self._files) > 1 else None

    def _times(self):
        return times_of(self._files)

    def _guarded(self, body):
        """A sentence and an empty image where it cannot be: a status of failure would add pages of the pipeline's own."""
        try:
            body()
        except Refused as refused:
            print(refused, file=sys.stderr)
        return 1

    def _volume_at(self, info):
        """Of the time that is asked for; kept, because pipelines ask twice."""
        index = 0
        if len(self._files) > 1 and info.Has(self.GetExecutive().UPDATE_TIME_STEP()):
            times = np.array(self._times())
            index = int(np.argmin(np.abs(times - info.Get(self.GetExecutive().UPDATE_TIME_STEP()))))
        file = self._files[index]
        if not os.path.isfile(file):
            raise Refused(f"{file}: there is no such file")
        names = self._selection
        wanted = [names.GetArrayName(i) for i in range(names.GetNumberOfArrays()) if names.GetArraySetting(i)]
        key = (file, tuple(wanted), os.stat(file).st_mtime_ns)
        if key != self._key:
            self._volume, self._key = Volume(file, wanted), key
        return self._volume

    def RequestInformation(self, request, inputs, outputs):
        return self._guarded(lambda: self._inform(outputs.GetInformationObject(0)))

    def _inform(self, info):
        if not self._files:
            raise Refused("OpenVDB volumes: no file; open one")
        try:
            names = [grid.name for grid in openvdb().readAllGridMetadata(self._files[0])]
        except (RuntimeError, OSError) as error:
            why = "there is no such file" if not os.path.isfile(self._files[0]) else str(error).splitlines()[0]
            raise Refused(f"{self._files[0]}: cannot be read: {why}") from None
        for name in names:
            self._selection.AddArray(name)
        executive = self.GetExecutive()
        info.Set(executive.WHOLE_EXTENT(), self._volume_at(info).extent(), 6)
        info.Remove(executive.TIME_STEPS())
        if len(self._files) > 1:
            times = self._times()
            info.Set(executive.TIME_STEPS(), times, len(times))
            info.Set(executive.TIME_RANGE(), [min(times), max(times)], 2)

    def RequestData(self, request, inputs, outputs):
        return self._guarded(lambda: self._fill(outputs.GetInformationObject(0), vtkImageData.GetData(outputs, 0)))

    def _fill(self, info, output):
        volume = self._volume_at(info)
        output.SetExtent(volume.extent())
        output.SetOrigin(volume.origin)
        output.SetSpacing(volume.size)
        points = dataset_adapter.WrapDataObject(output).PointData
        for name, values in volume.arrays():
            points.append(values, name)
