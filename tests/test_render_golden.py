import golden_images
import numpy as np
from render_parts import eye, still_life

from vrcomfort.geometry import Pose, yaw_pitch_roll
from vrcomfort.render.camera import PreviousCamera
from vrcomfort.render.output import read_rgb8, read_texture
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.render.tone_map import ToneMapPass

SIZE = (160, 120)


def test_still_life(ctx, request, tmp_path):
    """Sun, shadow, lamp, fog, clouds, metal, normal map, mask, blend and velocity in one view."""
    scene_pass = ScenePass(ctx, still_life(), SIZE, velocity=True)
    tone_map = ToneMapPass(ctx, radiance=scene_pass.colour, size_px=SIZE, exposure=0.9)
    camera = eye((0.1, 1.1, 0.2), yaw_pitch_roll(0.05, -0.1, 0.02))
    before = Pose((0.0, 1.1, 0.25), yaw_pitch_roll(0.0, -0.1, 0.0))
    scene_pass.render(camera, 0.0, PreviousCamera(before, 0.0))
    tone_map.render()
    golden_images.compare(request, ctx, tmp_path, "still_life", read_rgb8(tone_map.target))
    velocity = read_texture(scene_pass.velocity).astype(float)
    coded = np.clip(128 + 8 * velocity, 0, 255).astype(np.uint8)
    coded = np.concatenate([coded, np.zeros((*coded.shape[:2], 1), np.uint8)], axis=-1)
    golden_images.compare(request, ctx, tmp_path, "still_life_velocity", coded)
