"""Open VTU files with VTK's own reader and compare cells, faces, volumes and arrays with what was meant.

usage: check_vtu.py EXPECTED.json    a list written by test_vtu
       check_vtu.py FILE.vtu VOLUME  any file: closed cells, positive volumes that add up to VOLUME
       check_vtu.py FILE.vtu         the same without a sum (deformed bodies)
"""
import json
import os
import sys

import vtk
from vtk.util.numpy_support import vtk_to_numpy


def read(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    errors = []
    reader.AddObserver("ErrorEvent", lambda *event: errors.append(event))
    reader.Update()
    assert not errors and reader.GetErrorCode() == 0, "%s: VTK cannot read it" % path
    return reader.GetOutput()


def face_triangles(face):
    """Point ids of a face's triangles, by VTK's own triangulation of polygons."""
    n = face.GetNumberOfPoints()
    if n == 3:
        return [tuple(face.GetPointId(i) for i in range(3))]
    polygon = vtk.vtkPolygon()
    polygon.Initialize(n, face.GetPoints())
    ids = vtk.vtkIdList()
    assert polygon.Triangulate(ids) == 1, "VTK cannot triangulate a face of %d points" % n
    local = [ids.GetId(i) for i in range(ids.GetNumberOfIds())]
    # VTK leaves triangles without area out; what is missing otherwise shows in the volume
    assert len(local) <= 3 * (n - 2), "a face of %d points gave %d triangles" % (n, len(local) // 3)
    return [tuple(face.GetPointId(k) for k in local[i:i + 3]) for i in range(0, len(local), 3)]


def check_closed(cell):
    """Every directed edge of the cell's faces has exactly one opposite."""
    edges = set()
    for f in range(cell.GetNumberOfFaces()):
        face = cell.GetFace(f)
        n = face.GetNumberOfPoints()
        for i in range(n):
            edge = (face.GetPointId(i), face.GetPointId((i + 1) % n))
            assert edge not in edges, "an edge is named twice in the same sense"
            edges.add(edge)
    assert all((b, a) in edges for a, b in edges), "a cell is open"


def mass_properties(cell):
    """Volume by vtkMassProperties over the cell's triangulated faces; its sign by the divergence theorem."""
    points = vtk.vtkPoints()
    points.SetDataTypeToDouble()
    index, triangles, signed = {}, vtk.vtkCellArray(), 0.0
    for i in range(cell.GetNumberOfPoints()):
        index[cell.GetPointId(i)] = points.InsertNextPoint(cell.GetPoints().GetPoint(i))
    origin = points.GetPoint(0)
    for f in range(cell.GetNumberOfFaces()):
        for triangle in face_triangles(cell.GetFace(f)):
            triangles.InsertNextCell(3, [index[p] for p in triangle])
            a, b, c = ([x - o for x, o in zip(points.GetPoint(index[p]), origin)] for p in triangle)
            signed += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                       a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
    surface = vtk.vtkPolyData()
    surface.SetPoints(points)
    surface.SetPolys(triangles)
    properties = vtk.vtkMassProperties()
    properties.SetInputData(surface)
    properties.Update()
    return properties.GetVolume(), signed


def check_cells(grid, volumes):
    total = 0.0
    for c in range(grid.GetNumberOfCells()):
        cell = grid.GetCell(c)
        assert cell.GetCellType() == vtk.VTK_POLYHEDRON, cell.GetClassName()
        check_closed(cell)
        volume, signed = mass_properties(cell)
        total += signed
        if volumes is not None:
            # points are floats: 6e-8 of coordinates some ten times the cell's size
            assert abs(signed - volumes[c]) < 1e-5 * volumes[c], (c, signed, volumes[c])
            assert abs(volume - volumes[c]) < 1e-5 * volumes[c], (c, volume, volumes[c])
    return total


VTK_SYMMETRIC = [0, 1, 2, 5, 3, 4]  # where ours (xx yy zz yz zx xy) stand in VTK's order


def check_arrays(data, arrays, tuples):
    assert data.GetNumberOfArrays() == len(arrays), data.GetNumberOfArrays()
    for name, first in arrays.items():
        array = data.GetArray(name)
        assert array is not None, "no array called %s" % name
        assert array.GetNumberOfTuples() == tuples
        assert array.GetNumberOfComponents() == len(first)
        want = [first[k] for k in VTK_SYMMETRIC] if len(first) == 6 else first
        got = vtk_to_numpy(array).reshape(tuples, -1)[0]
        assert all(abs(g - w) <= 1e-6 * max(1, abs(w)) for g, w in zip(got, want)), (name, got, want)


def check_expected(path):
    for case in json.load(open(path)):
        grid = read(os.path.join(os.path.dirname(path), case["file"]))
        assert grid.GetNumberOfPoints() == case["points"]
        assert grid.GetNumberOfCells() == len(case["volumes"])
        assert grid.GetFieldData().GetArray("TimeValue").GetValue(0) == case["time"]
        check_arrays(grid.GetPointData(), case["point_arrays"], case["points"])
        check_arrays(grid.GetCellData(), case["cell_arrays"], len(case["volumes"]))
        check_cells(grid, case["volumes"])
        print("%s: %d polyhedra as meant" % (case["file"], len(case["volumes"])))


def check_file(path, volume=None):
    grid = read(path)
    total = check_cells(grid, None)
    print("%s: %d polyhedra, volume %.9g" % (path, grid.GetNumberOfCells(), total))
    assert total > 0
    if volume is not None:
        assert abs(total - float(volume)) < 1e-5 * float(volume), (total, volume)


if sys.argv[1].endswith(".json"):
    check_expected(sys.argv[1])
else:
    check_file(*sys.argv[1:])
