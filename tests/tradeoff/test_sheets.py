"""Contact sheets: what counts in no error is pale."""

import numpy as np
import pytest

from vrcomfort.tradeoff import files
from vrcomfort.tradeoff.cases import Case
from vrcomfort.tradeoff.measure import MeasuredCase


def sheet_of(height, width):
    """Return the sheet of a black picture, and of a grey one whose first rows are white."""
    reference = np.zeros((height, width, 3), np.float32)
    sharp = np.full_like(reference, 0.2)
    sharp[: height // 8] = 1
    case = Case("temple", 0, "still", "depth_of_field")
    counted = np.zeros((height, width, 1), dtype=bool)
    counted[height // 10 : height - height // 10, width // 8 : width - width // 8] = True
    found = MeasuredCase(case, [], {"reference": reference, "no blur": sharp}, counted, 0)
    return np.asarray(files.contact_sheet(found, 1.0))


def test_the_margin_is_pale_and_framed():
    image = sheet_of(200, 160)
    assert image.shape[1] == 2 * 160 + 3 * files.GAP_PX  # of two pictures
    x, y = files.GAP_PX, files.GAP_PX + files.LABEL_PX
    picture = image[y : y + 200, x : x + 160]
    pale = round(255 * (1 - files.FADED))
    assert np.all(picture[:19] == pale)
    assert np.all(picture[:, 141:] == pale)
    assert np.all(picture[19, 19:141] == 0)
    assert np.all(picture[20:180, 20:140] == 0)
    y += 200 + files.GAP_PX // 2
    difference = image[y : y + 200, x : x + 160]
    assert np.all(difference[20:180, 20:140] == 128)
    assert np.all(difference[:19] > 200)


def test_what_is_shown_of_a_large_image_is_what_counts():
    """Change in the margin does not draw the window there: 240 of 320 pixels are inside."""
    image = sheet_of(400, 320)
    x, y = files.GAP_PX, files.GAP_PX + files.LABEL_PX
    assert np.all(image[y : y + 240, x : x + 240] == 0)


@pytest.mark.parametrize("size", [(16, 20), (3, 3)])
def test_small_sheets_are_whole(size):
    assert sheet_of(*size).ndim == 3
