"""Volumes made by others as objects of a scene: through the program, with the volumes that are shipped."""

import unittest

from program import DATA, SHARED, ProgramCase


class Volumes(ProgramCase):
    def scene(self, **change):
        volume = {"name": "hot air", "volume": str(DATA / "volumes" / "hot_ground.vdb"),
                  "grids": [{"name": "temperature", "property": "index", "scale": [-1e-4, 0, 0], "offset": [1.029315, 0, 0]}]}
        return self.write("scene.json", {"volcaustic": 1, "volume": {"margin": 0, "resolution": 128}, "voxelise": {"blur": 1},
                                 "objects": [{**volume, **change}], "lights": [{}], "photons": {"grid": [16, 16]}})

    def test_the_box_is_that_of_the_volume(self):
        report = self.report("mesh2vdb", self.scene(), "-o", self.path("medium.vdb"))
        index = self.report("info", self.path("medium.vdb"))["files"][0]["grids"]
        index = next(g for g in index if g["name"] == "index")
        self.assertEqual(report["counts"][0]["dims"][:2], [128, 128])
        self.assertAlmostEqual(index["maximum"], 1, places=3)
        self.assertLess(index["minimum"], 0.998, "the ground is hot")
        self.assertGreater(index["minimum"], 0.992)

    def test_the_report_and_the_words_name_the_volume(self):
        scene = self.scene()
        self.succeed("scene", "check", scene)
        self.assertIn("index: temperature", self.succeed("info", scene).stdout)
        again = self.report("info", scene)["files"][0]["scene"]
        self.assertEqual(self.report("info", self.write("scene.json", again))["files"][0]["scene"], again)

    def test_mistakes_are_one_line_at_their_place(self):
        grid = {"name": "temperature", "property": "index"}
        for change, place, words in [
                ({"volume": "none.vdb"}, "/objects/0/volume: ", "no such file"),
                ({"mesh": "ball.ply"}, "/objects/0/volume: ", "mesh"),
                ({"grids": []}, "/objects/0/grids: ", "density"),
                ({"grids": [grid, grid]}, "/objects/0/grids/1/property: ", "another"),
                ({"grids": [{**grid, "property": "asymmetry"}]}, "/objects/0/grids: ", "scatter"),
                ({"grids": [{**grid, "property": "indx"}]}, "/objects/0/grids/0/property: ", '"index"'),
                ({"grids": [{"property": "index"}]}, "/objects/0/grids/0/name: ", "missing"),
                ({"groups": [{"name": "a", "material": "glass"}]}, "/objects/0/groups: ", "mesh")]:
            with self.subTest(change=change):
                scene = self.scene(**change)
                line = self.fail_with(3, "scene", "check", scene)
                self.assertTrue(line.startswith(scene + ":" + place), line)
                self.assertIn(words, line)

    def test_a_grid_that_is_not_there_names_those_that_are(self):
        scene = self.scene(grids=[{"name": "heat", "property": "attenuation"}])
        line = self.fail_with(3, "mesh2vdb", scene, "-o", self.path("medium.vdb"))
        self.assertIn("hot_ground.vdb: holds no grid 'heat'; it holds temperature (", line)
        scene = self.scene(grids=[{"name": "temperature", "property": "index"}])
        line = self.fail_with(3, "mesh2vdb", scene, "-o", self.path("medium.vdb"))
        self.assertIn("objects (hot air): grid 'temperature' becomes an index beyond 0.1 to 10", line)

    @unittest.skipUnless((SHARED / "data" / "vdb").is_dir(), "the shared files are not there")
    def test_somebody_elses_smoke_dims_what_shines_through_it(self):
        smoke = {"name": "smoke", "volume": str(SHARED / "data" / "vdb" / "smoke_000002.vdb"),
                 "grids": [{"name": "density", "property": "attenuation", "scale": [2, 2, 2]},
                           {"name": "density", "property": "scattering", "scale": [1, 1, 1]}]}
        scene = self.write("scene.json", {"volcaustic": 1, "volume": {"margin": 0.1, "resolution": 40}, "objects": [smoke],
                                  "lights": [{}], "photons": {"grid": [64, 64]}})
        balance = self.report("trace", scene, "-o", self.path("light.vdb"))["energyBalance"]
        self.assertGreater(balance["absorbed"][0], 0.01 * balance["emitted"][0])
        self.assertAlmostEqual(balance["absorbed"][0] / balance["scattered"][0], 1, delta=0.01)


if __name__ == "__main__":
    unittest.main()
