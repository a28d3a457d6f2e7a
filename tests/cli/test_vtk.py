"""Bezier triangles of .vtu files as VTK itself sees them: where python3-vtk9 is installed."""

import unittest

import numpy as np

from harness import main
from test_points import Points, scattered, wavy

try:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import reference
    from vtkmodules.vtkCommonDataModel import VTK_BEZIER_TRIANGLE, vtkBezierTriangle
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
    MISSING = ""
except ImportError as error:
    MISSING = f"needs VTK 9, package python3-vtk9: {error}"


@unittest.skipIf(MISSING, MISSING)
class BezierTriangles(Points):
    def setUp(self):
        super().setUp()
        self.file, _ = self.fitted(self.points(scattered(200, wavy)))
        self.triangles = self.json("decode", self.file, self.path("out.vtu"))["triangles"]
        self.reader = vtkXMLUnstructuredGridReader()
        self.reader.SetFileName(self.path("out.vtu"))
        self.reader.Update()
        self.grid = self.reader.GetOutput()

    def field(self, data, name):
        return vtk_to_numpy(data.GetPointData().GetArray(name))

    def test_cells_are_quadratic_bezier_triangles(self):
        self.assertEqual(self.grid.GetNumberOfCells(), 6 * self.triangles)
        for k in range(self.grid.GetNumberOfCells()):
            self.assertEqual(self.grid.GetCellType(k), VTK_BEZIER_TRIANGLE)
            self.assertEqual(self.grid.GetCell(k).GetNumberOfPoints(), 6)
        self.assertIsInstance(self.grid.GetCell(0), vtkBezierTriangle)

    def test_points_of_cells_lie_on_the_surface(self):
        value, gradient = self.field(self.grid, "value"), self.field(self.grid, "gradient")
        found = []
        for k in range(self.grid.GetNumberOfCells()):
            cell = self.grid.GetCell(k)
            net = [cell.GetPointId(corner) for corner in range(6)]
            for place in ((0.2, 0.3, 0), (1 / 3, 1 / 3, 0), (0.1, 0.8, 0)):
                point, weights = [0.0] * 3, [0.0] * 6
                cell.EvaluateLocation(reference(0), list(place), point, weights)
                found.append([*point, np.dot(weights, value[net]), *np.dot(weights, gradient[net])])
        found = np.array(found)
        own = self.evaluated(self.file, found[:, :2], 1)
        # Heights up to 12 and slopes up to 10, at places with a rounding of 1e-15; second derivatives reach 1e3,
        # in slivers at the hull 1e5.
        np.testing.assert_allclose(found[:, 2], own[:, 0], rtol=0, atol=1e-12)
        np.testing.assert_allclose(found[:, 3], own[:, 0], rtol=0, atol=1e-12)
        np.testing.assert_allclose(found[:, 4:], own[:, 1:], rtol=0, atol=1e-9)

    def test_tessellation(self):
        """The triangles that VTK draws: two levels of subdivision, points in float."""
        surface = vtkDataSetSurfaceFilter()
        surface.SetNonlinearSubdivisionLevel(2)
        surface.SetInputConnection(self.reader.GetOutputPort())
        surface.Update()
        drawn = surface.GetOutput()
        self.assertEqual(drawn.GetNumberOfCells(), 16 * 6 * self.triangles)
        points = vtk_to_numpy(drawn.GetPoints().GetData()).astype(float)
        own = self.evaluated(self.file, points[:, :2], 1)
        inside = ~np.isnan(own[:, 0])
        # Points of the hull may lie outside after rounding.
        self.assertLess(np.count_nonzero(~inside), 0.01 * len(own))
        # Float coordinates up to 6 times the slopes, which are steep in slivers, and heights up to 12, rounded twice.
        rounding = 2 * 2.0**-24 * (6 * np.abs(own[inside, 1:]).sum(axis=1) + 12)
        self.assertLess(np.max(np.abs(points[inside, 2] - own[inside, 0]) / rounding), 1)
        np.testing.assert_allclose(self.field(drawn, "value"), points[:, 2], rtol=0, atol=2.0**-23 * 12)


if __name__ == "__main__":
    main()
