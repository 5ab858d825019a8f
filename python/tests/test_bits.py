"""Pictures have the bits of ld_denoise, however the arrays lie in memory."""
import tempfile
import unittest
from pathlib import Path

import numpy as np

import layered_denoiser as ld
import support

RECIPE = """seed: 5
resolution: [33, 21]
spp: 3
reference_spp: {train: 4, validation: 4, test: 4}
frames: {train: 1, validation: 0, test: 0}
scenes: {variety: simple, objects: [2, 3]}
"""


class Bits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.held = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.held.name)
        (cls.folder / "recipe.yaml").write_text(RECIPE)
        support.run("ld_render", "--recipe", cls.folder / "recipe.yaml", "--out", cls.folder / "data")
        cls.rendered = cls.folder / "data/frame_000000.exr"

    @classmethod
    def tearDownClass(cls):
        cls.held.cleanup()

    def of_program(self, frame, weights, *options):
        output = self.folder / "denoised.exr"
        support.run("ld_denoise", frame, "--model", weights, "--output", output, "--float", *options)
        return ld.read_image(output)

    def test_are_those_of_the_program(self):
        for frame in (support.FRAME, self.rendered):
            for weights in ("common", "common_fast", "means", support.SAMPLE_WEIGHTS):
                for threads in (1, 2):
                    with self.subTest(frame=frame.name, weights=str(weights), threads=threads):
                        picture = ld.Denoiser(weights).denoise(ld.read_frame(frame), threads=threads)
                        np.testing.assert_array_equal(picture, self.of_program(frame, weights, "--threads", threads))

    def test_are_those_of_the_program_for_the_first_samples(self):
        for count in (1, 2):
            picture = ld.Denoiser().denoise(ld.read_frame(self.rendered, samples=count), threads=1)
            np.testing.assert_array_equal(picture, self.of_program(self.rendered, "common", "--samples", count, "--threads", 1))

    def test_do_not_depend_on_strides(self):
        samples = support.noisy_samples()
        denoiser = ld.Denoiser()
        expected = denoiser.denoise(samples, threads=1)

        def unaligned(array):
            moved = np.empty(array.nbytes + 1, np.uint8)[1:].view(np.float32).reshape(array.shape)
            moved[...] = array
            return moved

        def field(array):
            """Of records of 6 bytes: no whole number of floats apart."""
            records = np.zeros(array.shape, np.dtype([("value", np.float32), ("other", np.int16)]))
            records["value"] = array
            return records["value"]

        layouts = {
            "planar": lambda array: np.ascontiguousarray(np.moveaxis(array, -1, 1)).transpose(0, 2, 3, 1),
            "Fortran": np.asfortranarray,
            "backwards": lambda array: np.ascontiguousarray(array[::-1, ::-1, ::-1, ::-1])[::-1, ::-1, ::-1, ::-1],
            "every second": lambda array: np.repeat(np.repeat(array, 2, 2), 2, 3)[:, :, ::2, ::2],
            "unaligned": unaligned,
            "records": field,
            "big-endian": lambda array: array.astype(">f4"),
            "float64": lambda array: array.astype(np.float64),
            "lists": lambda array: array.tolist(),
            "one channel without an axis": lambda array: array[..., 0] if array.shape[-1] == 1 else array,
        }
        for name, layout in layouts.items():
            with self.subTest(layout=name):
                moved = {feature: layout(array) for feature, array in samples.items()}
                np.testing.assert_array_equal(denoiser.denoise(moved, threads=1), expected)
        frozen = {feature: array.copy() for feature, array in samples.items()}
        for array in frozen.values():
            array.flags.writeable = False
        np.testing.assert_array_equal(denoiser.denoise(frozen, threads=1), expected)

    def test_take_arrays_that_repeat_one_value(self):
        samples = support.noisy_samples()
        samples["albedo"] = np.broadcast_to(np.float32([0.2, 0.4, 0.6]), samples["radiance"].shape)
        copied = {name: np.array(array) for name, array in samples.items()}
        denoiser = ld.Denoiser()
        np.testing.assert_array_equal(denoiser.denoise(samples), denoiser.denoise(copied))

    def test_do_not_depend_on_the_memory_bound(self):
        samples = support.noisy_samples()
        expected = ld.Denoiser().denoise(samples, threads=1)
        np.testing.assert_array_equal(ld.Denoiser().denoise(samples, threads=1, max_memory_mb=20000), expected)

    def test_keep_a_bound_where_work_may_be_left_out(self):
        samples = support.noisy_samples(53, 167, 3, ("radiance",))
        samples["radiance"][:, :, :125] = 0.3  # a background of one colour
        denoiser = ld.Denoiser("common_fast")
        exact = denoiser.denoise(samples, threads=1)
        self.assertEqual(denoiser.skipped.pixels, 0)
        left_out = denoiser.denoise(samples, threads=1, skip_within=1e-3)
        self.assertGreater(denoiser.skipped.pixels, 0.5)
        self.assertTrue((left_out != exact).any())
        self.assertLessEqual((np.abs(left_out - exact) / (1 + np.abs(exact))).max(), 1e-3)

    def test_inputs_stay_as_they_are(self):
        samples = support.noisy_samples()
        samples["radiance"][0, 0, 0] = [np.nan, -1, np.inf]
        copies = {name: array.copy() for name, array in samples.items()}
        ld.Denoiser().denoise(samples)
        for name, array in samples.items():
            np.testing.assert_array_equal(array, copies[name])


class Samples(unittest.TestCase):
    def test_nan_and_not_valid_count_alike(self):
        samples = support.noisy_samples()
        valid = np.ones(samples["radiance"].shape[:3], bool)
        valid[1, 3, 4:9] = False
        denoiser = ld.Denoiser()
        plain = denoiser.denoise(samples, threads=1)
        expected = denoiser.denoise(samples, valid, threads=1)
        self.assertFalse(np.array_equal(expected, plain))
        np.testing.assert_array_equal(denoiser.denoise(samples, valid[:, ::-1][:, ::-1].astype(int) * 256, threads=1), expected)
        for value in (np.nan, np.inf, -np.inf):
            samples["radiance"][1, 3, 4:9, 1] = value
            np.testing.assert_array_equal(denoiser.denoise(samples, threads=1), expected)
        self.assertTrue(np.isfinite(expected).all())

    def test_any_size_from_one_pixel(self):
        for name in ("common", "common_fast", "means"):
            for size in ((1, 1, 1), (1, 1, 5), (3, 1, 2), (1, 150, 1)):
                with self.subTest(weights=name, size=size):
                    picture = ld.Denoiser(name).denoise(support.noisy_samples(*size))
                    self.assertEqual(picture.shape, (*size[:2], 3))
                    self.assertEqual(picture.dtype, np.float32)
                    self.assertTrue(picture.flags.c_contiguous and picture.flags.writeable)
                    self.assertTrue(np.isfinite(picture).all())

    def test_one_denoiser_takes_frames_of_several_sizes_in_turn(self):
        denoiser = ld.Denoiser("common_fast")
        for size in ((8, 8, 2), (5, 9, 3), (8, 8, 2)):
            samples = support.noisy_samples(*size)
            np.testing.assert_array_equal(denoiser.denoise(samples), ld.Denoiser("common_fast").denoise(samples))

    def test_optional_features_may_be_left_out_and_others_are_left_alone(self):
        samples = support.noisy_samples()
        denoiser = ld.Denoiser()
        radiance = denoiser.denoise({"radiance": samples["radiance"]}, threads=1)
        self.assertFalse(np.array_equal(radiance, denoiser.denoise(samples, threads=1)))
        other = {"radiance": samples["radiance"], "time": "not looked at"}
        np.testing.assert_array_equal(denoiser.denoise(other, threads=1), radiance)

    def test_the_scale_of_depth_is_that_of_the_frame_unless_told_otherwise(self):
        frame = ld.read_frame(support.FRAME)
        denoiser = ld.Denoiser(support.SAMPLE_WEIGHTS)
        expected = denoiser.denoise(frame, threads=1)
        given = denoiser.denoise(frame.samples, frame.valid, depth_scale=frame.depth_scale, threads=1)
        np.testing.assert_array_equal(given, expected)
        self.assertFalse(np.array_equal(denoiser.denoise(frame, depth_scale=100 * frame.depth_scale, threads=1), expected))


if __name__ == "__main__":
    unittest.main()
