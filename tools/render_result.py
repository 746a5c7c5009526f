#!/usr/bin/python3
"""Renders frames of a result side by side into one picture, off-screen, with VTK (python3-vtk9).

usage: render_result.py RESULT_DIR PICTURE.png [--frames 0,4,20] [--what surface|elements|cut|grid] ...
Needs a display: without one, put `xvfb-run -a` in front.

surface: the embedded surface (surface.obj + surface.pc2, or numbered surface_*.obj); elements: the polyhedra of fields_*.vtu;
cut: the polyhedra in front of the middle left away; shrunk elements show that they are separate.
grid: cells of fields_*.vti that are more than half full, moved by their displacement (times --warp), in space or in the plane.
"""
import argparse
import glob
import os
import struct

import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
import numpy as np


def read_surfaces(folder, frame):
    """The embedded surfaces of all bodies."""
    all_bodies = vtk.vtkAppendPolyData()
    for obj in sorted(glob.glob(os.path.join(folder, "*surface_%04d.obj" % frame))):
        reader = vtk.vtkOBJReader()
        reader.SetFileName(obj)
        reader.Update()
        all_bodies.AddInputData(reader.GetOutput())
    for obj in sorted(glob.glob(os.path.join(folder, "*surface.obj"))) if not all_bodies.GetNumberOfInputConnections(0) else []:
        all_bodies.AddInputData(read_surface(obj[:-len(".obj")], frame))
    all_bodies.Update()
    return all_bodies.GetOutput()


def read_surface(stem, frame):
    """An embedded surface with the points of one frame of its cache."""
    reader = vtk.vtkOBJReader()
    reader.SetFileName(stem + ".obj")
    reader.Update()
    surface = reader.GetOutput()
    with open(stem + ".pc2", "rb") as file:
        _, _, n, _, _, samples = struct.unpack("<12siiffi", file.read(32))
        file.seek(32 + 12 * n * (frame % samples))
        points = np.frombuffer(file.read(12 * n), "<f4").reshape(n, 3)
    if surface.GetNumberOfPoints() == n:
        moved = np.linalg.norm(points - vtk_to_numpy(surface.GetPoints().GetData()), axis=1)
        surface.GetPoints().SetData(numpy_to_vtk(points, deep=True))
        array = numpy_to_vtk(moved, deep=True)
        array.SetName("displacement")
        surface.GetPointData().AddArray(array)
        to_cells = vtk.vtkPointDataToCellData()
        to_cells.SetInputData(surface)
        to_cells.Update()
        surface = to_cells.GetOutput()
    else:
        raise SystemExit("%s.obj was read with %d points, the cache has %d"
                         % (stem, surface.GetNumberOfPoints(), n))
    return surface


def read_elements(folder, frame, shrink, cut):
    files = sorted(glob.glob(os.path.join(folder, "fields_*.vtu")))
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(files[frame % len(files)])
    reader.Update()
    grid = reader.GetOutput()
    n = grid.GetNumberOfCells()
    centers = np.array([np.mean([grid.GetCell(c).GetBounds()[2 * a:2 * a + 2] for a in range(3)], axis=1)
                        for c in range(n)])
    keep = np.ones(n, bool)
    if cut:
        # by the place at rest, so that all frames show the same elements
        moved = grid.GetPointData().GetArray("displacement")
        rest = [centers[c][2] - (moved.GetTuple(grid.GetCell(c).GetPointId(0))[2] if moved else 0)
                for c in range(n)]
        keep = np.array(rest) <= np.median(rest)
    return faces_of(grid, centers, keep, shrink)


def faces_of(grid, centers, keep, shrink):
    """The faces of the cells kept, each cell drawn towards its middle."""
    points, polys = vtk.vtkPoints(), vtk.vtkCellArray()
    arrays = {name: vtk_to_numpy(grid.GetCellData().GetArray(name)) for name in ("von_mises",)
              if grid.GetCellData().HasArray(name)}
    moved = grid.GetPointData().GetArray("displacement")
    values = {name: [] for name in arrays}
    if moved:
        values["displacement"] = []
    for c in np.nonzero(keep)[0]:
        cell, index = grid.GetCell(int(c)), {}
        for i in range(cell.GetNumberOfPoints()):
            p = np.array(cell.GetPoints().GetPoint(i))
            index[cell.GetPointId(i)] = points.InsertNextPoint(centers[c] + shrink * (p - centers[c]))
        for f in range(cell.GetNumberOfFaces()):
            face = cell.GetFace(f)
            ids = [index[face.GetPointId(i)] for i in range(face.GetNumberOfPoints())]
            polys.InsertNextCell(len(ids), ids)
            for name in arrays:
                values[name].append(arrays[name][c])
            if moved:
                values["displacement"].append(np.linalg.norm(moved.GetTuple(cell.GetPointId(0))))
    data = vtk.vtkPolyData()
    data.SetPoints(points)
    data.SetPolys(polys)
    for name, list_ in values.items():
        array = numpy_to_vtk(np.array(list_, float), deep=True)
        array.SetName(name)
        data.GetCellData().AddArray(array)
    return data


def behind(port, clip):
    """The whole cells on the side of a plane that its normal points away from; clip: point and normal."""
    plane = vtk.vtkPlane()
    plane.SetOrigin(clip[:3])
    plane.SetNormal(clip[3:])
    kept = vtk.vtkExtractGeometry()
    kept.SetInputConnection(port)
    kept.SetImplicitFunction(plane)
    kept.ExtractBoundaryCellsOff()
    return kept


def read_grid(folder, frame, warp, clip):
    """Cells more than half full of an image, warped; their outer faces, or in the plane the cells themselves."""
    files = sorted(glob.glob(os.path.join(folder, "*fields_*.vti")))
    all_bodies = vtk.vtkAppendPolyData()
    n_frames = len([f for f in files if f.rsplit("_", 1)[0] == files[0].rsplit("_", 1)[0]])
    for file in [f for f in files if f.endswith("_%04d.vti" % (frame % n_frames))]:
        reader = vtk.vtkXMLImageDataReader()
        reader.SetFileName(file)
        full = vtk.vtkThreshold()
        full.SetInputConnection(reader.GetOutputPort())
        full.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_CELLS, "fraction")
        full.SetThresholdFunction(vtk.vtkThreshold.THRESHOLD_UPPER)
        full.SetUpperThreshold(0.5)
        points = vtk.vtkCellDataToPointData()
        kept = behind(full.GetOutputPort(), clip) if clip else full
        points.SetInputConnection(kept.GetOutputPort())
        points.PassCellDataOn()
        moved = vtk.vtkWarpVector()
        moved.SetInputConnection(points.GetOutputPort())
        moved.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_POINTS, "displacement")
        moved.SetScaleFactor(warp)
        faces = vtk.vtkGeometryFilter()
        faces.SetInputConnection(moved.GetOutputPort())
        faces.Update()
        data = faces.GetOutput()
        length = np.linalg.norm(vtk_to_numpy(data.GetCellData().GetArray("displacement")), axis=1)
        data.GetPointData().Initialize()
        data.GetCellData().RemoveArray("displacement")
        array = numpy_to_vtk(length, deep=True)
        array.SetName("displacement")
        data.GetCellData().AddArray(array)
        all_bodies.AddInputData(data)
    all_bodies.Update()
    return all_bodies.GetOutput()


def colour_table():
    table = vtk.vtkColorTransferFunction()
    table.SetColorSpaceToLab()
    stops = [(0, .23, .30, .75), (.25, .35, .65, .85), (.5, .9, .9, .85), (.75, .95, .65, .35), (1, .70, .02, .15)]
    for x, r, g, b in stops:
        table.AddRGBPoint(x, r, g, b)
    lut = vtk.vtkLookupTable()
    lut.SetNumberOfTableValues(256)
    for i in range(256):
        lut.SetTableValue(i, *table.GetColor(i / 255), 1)
    return lut


def add_floor(renderer, y, bounds):
    size = 3 * max(bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4])
    plane = vtk.vtkPlaneSource()
    x, z = (bounds[0] + bounds[1]) / 2, (bounds[4] + bounds[5]) / 2
    plane.SetOrigin(x - size, y, z - size)
    plane.SetPoint1(x + size, y, z - size)
    plane.SetPoint2(x - size, y, z + size)
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(plane.GetOutputPort())
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(.93, .93, .91)
    actor.GetProperty().LightingOff()
    renderer.AddActor(actor)


def cross(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def flatten(corners):
    """Corners of a nearly plane polygon in its plane, anticlockwise."""
    after = np.roll(corners, -1, axis=0)
    normal = np.cross(corners - corners[0], after - corners[0]).sum(axis=0)
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    u = np.cross(axis, normal)
    return np.stack([corners @ u, corners @ np.cross(normal, u)], axis=1).tolist()


def cut_ears(corners):
    """Triangles of a polygon that may be concave and have corners inside its edges: the ear of the largest area goes first."""
    at, left, triangles = flatten(corners), list(range(len(corners))), []
    while len(left) > 3:
        best, largest = 0, -np.inf
        for i in range(len(left)):
            a, b, c = left[i - 1], left[i], left[(i + 1) % len(left)]
            area = cross(at[a], at[b], at[c])
            if area <= largest:
                continue
            ear = ((a, b), (b, c), (c, a))
            if not any(all(cross(at[p], at[q], at[k]) > 0 for p, q in ear) for k in left if k not in (a, b, c)):
                best, largest = i, area
        triangles.append((left[best - 1], left[best], left[(best + 1) % len(left)]))
        del left[best]
    return triangles + [tuple(left)]


def corner_normals(places, vertex, face, area, angle):
    """Normal of every corner: the mean by area of the faces around its vertex that turn by less than an angle [degrees] from its own."""
    size = np.linalg.norm(area, axis=1)
    by_vertex = np.argsort(vertex, kind="stable")
    count = np.bincount(vertex, minlength=len(places))
    first = np.cumsum(count) - count
    own, normals = area[face], np.zeros((len(face), 3))
    for i in range(count.max()):
        there = count[vertex] > i
        other = face[by_vertex[first[vertex[there]] + i]]
        near = (own[there] * area[other]).sum(axis=1) >= np.cos(np.radians(angle)) * size[face[there]] * size[other]
        normals[there] += np.where(near[:, None], area[other], 0)
    return normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]


def shade(data, angle):
    """Triangles with corners and normals of their own, split at edges sharper than an angle. VTK draws concave faces as fans, its
    triangulation drops some that have corners inside their edges, and thin triangles count as much as wide ones in its normals."""
    places = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    offset = vtk_to_numpy(data.GetPolys().GetOffsetsArray())
    vertex = vtk_to_numpy(data.GetPolys().GetConnectivityArray())
    face = np.repeat(np.arange(len(offset) - 1), np.diff(offset))
    after = np.arange(1, len(vertex) + 1)
    after[offset[1:] - 1] = offset[:-1]
    corner, origin = places[vertex], places[vertex[offset[:-1]]][face]
    area = np.zeros((len(offset) - 1, 3))
    np.add.at(area, face, np.cross(corner - origin, corner[after] - origin))
    triangles, source = [], []
    for f, (low, high) in enumerate(zip(offset[:-1], offset[1:])):
        ears = [(0, 1, 2)] if high == low + 3 else cut_ears(corner[low:high])
        triangles += [(low + i, low + j, low + k) for i, j, k in ears]
        source += [f] * len(ears)
    cells = vtk.vtkCellArray()
    cells.SetData(3, numpy_to_vtkIdTypeArray(np.array(triangles, dtype=np.int64).ravel(), deep=True))
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(corner, deep=True))
    out = vtk.vtkPolyData()
    out.SetPoints(points)
    out.SetPolys(cells)
    out.GetPointData().SetNormals(numpy_to_vtk(corner_normals(places, vertex, face, area, angle), deep=True))
    for i in range(data.GetCellData().GetNumberOfArrays()):
        values = data.GetCellData().GetArray(i)
        if values is None:
            continue
        taken = numpy_to_vtk(vtk_to_numpy(values)[source], deep=True)
        taken.SetName(values.GetName())
        out.GetCellData().AddArray(taken)
    return out


def make_actor(data, what, colour, top):
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(shade(data, 60 if what == "surface" else 1))
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(.80, .62, .45)
    actor.GetProperty().SetSpecular(.15)
    if colour != "none" and data.GetCellData().HasArray(colour):
        mapper.SetScalarModeToUseCellFieldData()
        mapper.SelectColorArray(colour)
        mapper.SetLookupTable(colour_table())
        mapper.SetScalarRange(0, top)
    else:
        mapper.ScalarVisibilityOff()
    return actor


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", help="one, or several with commas: side by side")
    parser.add_argument("picture")
    parser.add_argument("--frames", default="-1")
    parser.add_argument("--what", default="surface", choices=("surface", "elements", "cut", "grid"))
    parser.add_argument("--warp", type=float, default=1, help="of grid: factor of the displacement")
    parser.add_argument("--clip", help="of grid: x,y,z,nx,ny,nz: only what lies behind this plane at rest")
    parser.add_argument("--colour", default="von_mises", help="a field or none; several with commas: a picture of each")
    parser.add_argument("--azimuth", type=float, default=25)
    parser.add_argument("--elevation", type=float, default=12)
    parser.add_argument("--size", default="420x420")
    parser.add_argument("--shrink", type=float, default=1)
    parser.add_argument("--up", default="y", choices=("y", "z"))
    parser.add_argument("--zoom", type=float, default=1.2)
    parser.add_argument("--floor", type=float, default=None)
    args = parser.parse_args()
    frames = [int(f) for f in args.frames.split(",")]
    clip = [float(x) for x in args.clip.split(",")] if args.clip else None
    width, height = (int(x) for x in args.size.split("x"))

    colours = args.colour.split(",")
    parts = [read_surfaces(folder, f) if args.what == "surface" else
             read_grid(folder, f, args.warp, clip) if args.what == "grid" else
             read_elements(folder, f, args.shrink, args.what == "cut")
             for folder in args.folder.split(",") for f in frames] * len(colours)
    colours = [c for c in colours for _ in range(len(parts) // len(colours))]
    all_bounds = np.array([p.GetBounds() for p in parts])
    bounds = [g(all_bounds[:, i]) for i, g in zip(range(6), (min, max) * 3)]
    top = {c: max([np.percentile(vtk_to_numpy(p.GetCellData().GetArray(c)), 99) for p in parts
                   if p.GetCellData().HasArray(c)] + [1e-300]) for c in colours}

    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    window.SetSize(width * len(parts), height)
    camera = None
    for i, data in enumerate(parts):
        renderer = vtk.vtkRenderer()
        renderer.SetViewport(i / len(parts), 0, (i + 1) / len(parts), 1)
        renderer.SetBackground(1, 1, 1)
        renderer.AddActor(make_actor(data, args.what, colours[i], top[colours[i]]))
        window.AddRenderer(renderer)
        if camera is None:
            renderer.ResetCamera(bounds)
            camera = renderer.GetActiveCamera()
            if args.up == "z":
                focus = camera.GetFocalPoint()
                camera.SetPosition(focus[0], focus[1] - camera.GetDistance(), focus[2])
                camera.SetViewUp(0, 0, 1)
            camera.Azimuth(args.azimuth)
            camera.Elevation(args.elevation)
            renderer.ResetCamera(bounds)
            camera.Zoom(args.zoom)
        renderer.SetActiveCamera(camera)
        if args.floor is not None:
            add_floor(renderer, args.floor, bounds)
        renderer.ResetCameraClippingRange()
    window.Render()
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(args.picture)
    writer.SetInputConnection(grab.GetOutputPort())
    writer.Write()


main()
