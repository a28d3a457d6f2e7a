"""What coordinates and values of points are: kept in the file, given to rasters, minded in pictures."""

import numpy as np
from osgeo import osr

from harness import contents_of, main, read_raster
from test_points import Points, quadratic, scattered


class Coordinates(Points):
    def setUp(self):
        super().setUp()
        self.rows = scattered(300, quadratic)

    def test_coordinates_and_units(self):
        rows = self.rows + [500_000, 5_200_000, 0]
        source = self.points(rows)
        plain = self.json("info", self.fitted(source)[0])
        self.assertEqual((plain["crs"], plain["unit"]), ("", ""))
        for options in ((), ("--max-error", 0.1), ("--vertices", 50)):
            file, _ = self.fitted(source, *options, "--crs", "EPSG:32633", "--unit", "m")
            info = self.json("info", file)
            self.assertEqual((info["crs"], info["unit"]), ("EPSG:32633", "m"))
            self.json("decode", file, self.path("out.tif"), "--cell", 0.5)
            raster = read_raster(self.path("out.tif"))
            self.assertEqual(osr.SpatialReference(raster.wkt).GetAuthorityCode(None), "32633")
            self.assertEqual(raster.unit, "m")
        edited = self.path("edited.relief")
        self.json("edit", file, edited, "--level", 0, "--move", "7:1")
        self.assertEqual(self.json("info", edited)["crs"], "EPSG:32633")
        self.assertIn("EPSG:32633", self.text("info", file))
        self.assertRegex(self.text("fit", source, file, "--unit", "ft"), r"max error \S+ ft, rms error \S+ ft")
        self.refuse(2, "fit", source, self.path("no.relief"), "--crs", "EPSG:99999999", says=("EPSG:99999999", ".prj"))

    def test_degrees_are_drawn_in_metres(self):
        # A hill of 1 km on 60 km at 60 degrees north, where a degree is half as wide as long.
        rows = scattered(200, lambda x, y: 1000 * np.sin(3 * x) * np.sin(6 * y), (1.0, 0.5))
        source = self.points(rows + [10, 60, 0])
        heights = {}
        for name, options in (("degrees", ("--crs", "EPSG:4326")), ("metres", ())):
            if name == "metres":
                source = self.points(rows * [55_660, 111_420, 1])
            file, _ = self.fitted(source, *options, name=f"{name}.relief")
            picture = self.json("render", file, self.path(f"{name}.png"), "--style", "wire", "--width", 300)
            heights[name] = picture["height"]
        self.assertAlmostEqual(heights["degrees"], heights["metres"], delta=3)

    def test_coordinates_of_encoded_points_and_triangles(self):
        source = self.points(self.rows)
        file, _ = self.encoded(source, "--crs", "EPSG:32633", "--unit", "m")
        self.assertEqual(contents_of(file),
                         contents_of(self.fitted(source, "--lossless", "--crs", "EPSG:32633", "--unit", "m")[0]))
        self.json("decode", file, self.path("tin.obj"))
        tin, _ = self.encoded(self.path("tin.obj"), "--scheme", "powell-sabin", "--crs",
                              "+proj=laea +lat_0=52 +lon_0=10 +ellps=GRS80", name="tin.relief")
        self.assertTrue(self.json("info", tin)["crs"].startswith("PROJCRS["))
        raster = self.raster("dem.tif", np.arange(12.0).reshape(3, 4))
        self.refuse(2, "encode", raster, self.path("no.relief"), "--crs", "EPSG:32633", says="rasters bring their own")


if __name__ == "__main__":
    main()
