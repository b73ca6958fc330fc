import av
import numpy as np
import pytest
from PIL import Image

from vrcomfort.gpu import gl
from vrcomfort.render import output


@pytest.fixture
def frames():
    rng = np.random.default_rng(5)
    base = rng.integers(0, 255, (41, 63, 3), dtype=np.uint8)
    return [np.roll(base, shift, axis=1) for shift in range(6)]


def test_textures_are_read_with_the_top_row_first(ctx):
    texture = gl.color_texture(ctx, (2, 2), dtype="f1")
    rows_from_the_bottom = np.array([[10, 20], [30, 40]], np.uint8)
    texture.write(np.repeat(rows_from_the_bottom, 4).tobytes())
    np.testing.assert_array_equal(output.read_rgb8(texture)[..., 0], [[30, 40], [10, 20]])


def test_stereo_images_are_exact(tmp_path, frames):
    paths = output.write_stereo(tmp_path, frames[0], frames[1])
    assert [path.name for path in paths] == ["left.png", "right.png", "side_by_side.png"]
    both = np.asarray(Image.open(paths[2]))
    np.testing.assert_array_equal(both[:, :63], frames[0])
    np.testing.assert_array_equal(both[:, 63:], frames[1])


def test_numbers_come_back_and_files_repeat(tmp_path):
    depth = np.array([[0.0, 0.01]], np.float32)
    for name in ("a.npz", "b.npz"):
        output.write_numbers(tmp_path / name, left_distance_m=output.distance_m(depth, 0.02))
    with np.load(tmp_path / "a.npz") as numbers:
        np.testing.assert_allclose(numbers["left_distance_m"], [[np.inf, 2.0]])
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_the_same_frames_make_the_same_video(tmp_path, frames):
    frames = [np.tile(frame, (3, 3, 1)) for frame in frames]  # x264 does not repeat tiny images
    for name in ("a.mp4", "b.mp4"):
        with output.VideoWriter(tmp_path / name, frames_per_s=72) as video:
            for frame in frames:
                video.write(frame)
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()
    with av.open(str(tmp_path / "a.mp4")) as container:
        decoded = list(container.decode(video=0))
        assert len(decoded) == len(frames)
        assert (decoded[0].width, decoded[0].height) == (188, 122)
        assert container.streams.video[0].average_rate == 72
