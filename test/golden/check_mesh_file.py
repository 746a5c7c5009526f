"""Write one mesh in every form of every mesh file that is read, read it back, compare.

usage: check_mesh_file.py PRINT_MESH_FILE FOLDER

VTK's own writer makes the .vtu files, test/support/mesh_files.py the others.
"""
import json
import os
import subprocess
import sys

import vtk

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from mesh_files import KINDS, mixed_mesh, order_sum, second_order_mesh, write_inp, write_msh2, write_msh4  # noqa: E402


def faces_of(kind, p):
    if kind == "tet4":
        f = [(0, 1, 3), (1, 2, 3), (2, 0, 3), (0, 2, 1)]
    elif kind == "hex8":
        f = [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)]
    elif kind == "wedge6":
        f = [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)]
    else:
        f = [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    return [[p[v] for v in face] for face in f]


def vtk_grid(points, cells, as_polyhedra=False):
    grid, place, label = vtk.vtkUnstructuredGrid(), vtk.vtkPoints(), vtk.vtkIntArray()
    place.SetDataTypeToDouble()
    label.SetName("label")
    for x in points:
        place.InsertNextPoint(x)
    grid.SetPoints(place)
    for kind, cell, mark in cells:
        label.InsertNextValue(mark)
        ids = vtk.vtkIdList()
        if as_polyhedra:
            faces = faces_of(kind, cell)
            # every second one inside out and with one face turned the other way: both are mended
            if len(faces) % 2:
                faces = [list(reversed(f)) for f in faces[:-1]] + faces[-1:]
            ids.InsertNextId(len(faces))
            for f in faces:
                ids.InsertNextId(len(f))
                for p in f:
                    ids.InsertNextId(p)
            grid.InsertNextCell(42, ids)
        else:
            for p in cell:
                ids.InsertNextId(p)
            grid.InsertNextCell(KINDS[kind][0], ids)
    grid.GetCellData().AddArray(label)
    return grid


def write_vtu(path, grid, mode, compressed, wide, big):
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(path)
    writer.SetInputData(grid)
    {"ascii": writer.SetDataModeToAscii, "binary": writer.SetDataModeToBinary}.get(
        mode, writer.SetDataModeToAppended)()
    writer.SetEncodeAppendedData(mode == "base64")
    writer.SetCompressorTypeToZLib() if compressed else writer.SetCompressorTypeToNone()
    writer.SetHeaderTypeToUInt64() if wide else writer.SetHeaderTypeToUInt32()
    writer.SetByteOrderToBigEndian() if big else writer.SetByteOrderToLittleEndian()
    writer.SetBlockSize(1024)
    assert writer.Write() == 1


def main(program, folder):
    os.makedirs(folder, exist_ok=True)
    points, cells, floor = mixed_mesh()
    mixed = {"elements": len(cells), "volume": 1, "area": 6, "parts": 1, "order": order_sum(points, cells),
             "nodes": len(points)}
    second = [k for k in KINDS if k[-1] not in "4568"]
    points2, cells2, volume2 = second_order_mesh(second)
    two = {"elements": len(cells2), "volume": volume2, "parts": len(cells2), "order": order_sum(points2, cells2),
           "nodes": len(points2)}
    in_deck = [k for k in second if KINDS[k][2]]
    points3, cells3, volume3 = second_order_mesh(in_deck)
    three = {"elements": len(cells3), "volume": volume3, "order": order_sum(points3, cells3)}
    n_right = sum(mark == 2 for _, _, mark in cells)
    work = []

    for mode in ("ascii", "binary", "base64", "raw"):
        for compressed in (False, True):
            for wide, big in ((False, False), (True, False), (False, True)):
                name = os.path.join(folder, "%s_%d%d%d.vtu" % (mode, compressed, wide, big))
                write_vtu(name, vtk_grid(points, cells), mode, compressed, wide, big)
                work.append((name, mixed, {"elements 2": n_right}, {}))
    name = os.path.join(folder, "polyhedra.vtu")
    write_vtu(name, vtk_grid(points, cells, True), "raw", True, True, False)
    work.append((name, dict(mixed, order=0), {"elements 2": n_right}, {}))
    name = os.path.join(folder, "second.vtu")
    write_vtu(name, vtk_grid(points2, cells2), "ascii", False, False, False)
    work.append((name, two, {}, {}))

    for version, write in ((2, write_msh2), (4, write_msh4)):
        for binary, big in ((0, False), (1, False), (1, True)):
            name = os.path.join(folder, "mixed_%d_%d%d.msh" % (version, binary, big))
            write(name, points, cells, floor, binary, big)
            groups = {"elements left part": len(cells) - n_right, "elements right part": n_right,
                      "elements 5": n_right, "faces floor": len(floor), "nodes corner": 1}
            work.append((name, mixed, groups, {"floor": 1}))
            name = os.path.join(folder, "second_%d_%d%d.msh" % (version, binary, big))
            write(name, points2, cells2, [], binary, big)
            work.append((name, two, {}, {}))

    name = os.path.join(folder, "mixed.inp")
    write_inp(name, points, cells, floor)
    groups = {"elements left": len(cells) - n_right, "elements Right": n_right, "elements ALL": len(cells),
              "elements both": len(cells), "nodes Nall": len(points)}
    work.append((name, mixed, groups, {"FLOOR": 1, "Nall": 6}))
    name = os.path.join(folder, "second.inp")
    write_inp(name, points3, cells3, [])
    work.append((name, three, {}, {}))

    run = subprocess.run([program] + [w[0] for w in work], capture_output=True, text=True)
    assert not run.stderr, run.stderr
    lines = run.stdout.splitlines()
    assert len(lines) == len(work), run.stdout[-2000:]
    for line, (name, want, groups, areas) in zip(lines, work):
        got = json.loads(line)
        assert "error" not in got, got
        for key, value in want.items():
            # sums of a few thousand terms below ten
            assert abs(got[key] - value) <= 1e-11 * max(1, abs(value)), (name, key, got[key], value)
        for key, value in groups.items():
            assert got["groups"].get(key) == value, (name, key, value, got["groups"])
        for key, value in areas.items():
            assert abs(got["areas"][key] - value) <= 1e-12, (name, key, value, got["areas"])
    print("%d files" % len(work))


main(sys.argv[1], sys.argv[2])
