"""relief.Pyramid: views, norms, thresholds, synthesis, moves, in both precisions."""

import numpy as np
import pytest
from conftest import hills

import relief

SCHEMES = [("cubic", 2), ("box", 1), ("box", 2), ("barycentric", 2)]


@pytest.mark.parametrize("scheme, order", SCHEMES)
@pytest.mark.parametrize("dtype, tolerance", [(np.float64, 1e-11), (np.float32, 2e-3)])  # 400 x the type's rounding
def test_synthesis_gives_the_samples_back(scheme, order, dtype, tolerance):
    z = hills(61, 83).astype(dtype)
    pyramid = relief.analyse(z, scheme, order=order)
    assert pyramid.dtype == dtype and pyramid.shape == z.shape
    again = pyramid.synthesise()
    assert again.dtype == dtype and np.abs(again - z).max() < tolerance
    assert pyramid.synthesise(2).shape == (16, 21)


@pytest.mark.parametrize("scheme, order", SCHEMES[1:])  # cubic cuts its taps at the border
def test_planes_have_no_details(scheme, order):
    pyramid = relief.analyse(np.add.outer(np.arange(33.0), 3 * np.arange(49.0)), scheme, order=order, levels=3)
    assert all(np.abs(band).max() < 1e-10 for band in pyramid.bands[1:])


def test_norm_is_what_a_coefficient_does_to_the_samples():
    pyramid = relief.analyse(np.zeros((65, 65)), "cubic", levels=3)
    for k, band in enumerate(pyramid.bands):
        band[band.shape[0] // 2, band.shape[1] // 2] = 1
        # Atoms in the middle of 65 samples: levels up to 2 end before the border.
        if pyramid.layout[k]["level"] <= 2:
            assert np.linalg.norm(pyramid.synthesise()) == pytest.approx(pyramid.norms[k], rel=1e-3)
        band[...] = 0
    assert pyramid.norms[3] == pyramid.layout[3]["norm_samples"]


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_threshold_keeps_the_largest(dtype):
    z = hills(80, 90).astype(dtype)
    pyramid = relief.analyse(z, "cubic")
    scaling = pyramid.bands[0].copy()
    weighted = np.concatenate([np.abs(b.astype(float)).ravel() * n for b, n in zip(pyramid.bands, pyramid.norms)][1:])
    keep = 500
    assert pyramid.threshold(keep=keep) == keep
    assert np.array_equal(pyramid.bands[0], scaling)
    left = np.concatenate([np.abs(b.astype(float)).ravel() * n for b, n in zip(pyramid.bands, pyramid.norms)][1:])
    kept = np.sort(left[left > 0])[::-1]
    assert np.array_equal(kept, np.sort(weighted)[::-1][:keep - scaling.size])
    pyramid = relief.analyse(z, "cubic")
    assert pyramid.threshold(above=10) == scaling.size + np.count_nonzero(weighted >= 10)
    for wrong in ({}, {"keep": 1, "above": 1}, {"keep": -1}, {"above": float("nan")}, {"keep": 1, "metric": "x"}):
        with pytest.raises(ValueError):
            pyramid.threshold(**wrong)


def test_bands_are_views_that_keep_the_pyramid():
    z = hills(33, 33)
    pyramid = relief.analyse(z)
    bands = pyramid.bands
    bands[-1][...] = 0
    assert np.abs(pyramid.synthesise() - z).max() > 1
    assert pyramid.bands[-1].ctypes.data == bands[-1].ctypes.data
    before = bands[0].copy()
    del pyramid
    assert np.array_equal(bands[0], before)


def test_components_are_planes():
    stack = np.stack([hills(40, 30, s) for s in (1, 2, 3)])
    pyramid = relief.analyse(stack, "box")
    assert pyramid.shape == stack.shape and all(len(band) == 3 for band in pyramid.bands)
    assert np.abs(np.stack(pyramid.synthesise()) - stack).max() < 1e-11
    alone = relief.analyse(stack[1], "box")
    assert all(np.array_equal(a[1], b) for a, b in zip(pyramid.bands, alone.bands))


def test_arrays_are_read_where_they_lie():
    z = np.zeros((300, 500))
    z[::2, :400] = hills(150, 400)
    part = z[::2, :400]  # rows apart, columns together: a view
    assert np.array_equal(relief.analyse(part).bands[0], relief.analyse(part.copy()).bands[0])
    assert np.array_equal(relief.analyse(z[::2, ::5]).bands[0], relief.analyse(z[::2, ::5].copy()).bands[0])
    whole = relief.analyse((10 * z).astype(np.int32))
    assert np.array_equal(whole.bands[0], relief.analyse((10 * z).astype(np.int32).astype(float)).bands[0])


def test_a_move_moves_the_surface_by_its_spline():
    z = hills(65, 65)
    pyramid = relief.analyse(z, "cubic", levels=4)
    pyramid.move(3, 4, 5, 10.0)
    difference = pyramid.synthesise() - z
    # The cardinal spline of level 3: 10 at (32, 40), 0 at all other multiples of 8.
    expected = np.zeros((9, 9))
    expected[4, 5] = 10
    assert np.abs(difference[::8, ::8] - expected).max() < 1e-9
    with pytest.raises(relief.Error):
        pyramid.move(3, 99, 0, 1)


def test_wrong_samples_are_errors_with_their_place():
    z = np.zeros((5, 6))
    z[2, 3] = np.inf
    with pytest.raises(relief.Error, match="row 2, column 3"):
        relief.analyse(z)
    for wrong in (np.zeros(3), np.zeros((0, 3)), np.zeros((5, 2, 2)), np.array([["a"]])):
        with pytest.raises(ValueError):
            relief.analyse(wrong)
    with pytest.raises(relief.Error, match="level"):
        relief.analyse(np.zeros((9, 9))).synthesise(77)
