"""Poses between OpenXR's float32 structures and ours."""

from __future__ import annotations

import xr

from vrcomfort.geometry import Fov, Pose, View


def pose_from_xr(pose: xr.Posef) -> Pose:
    """Return the same pose in float64."""
    p, q = pose.position, pose.orientation
    return Pose.of((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


def pose_to_xr(pose: Pose) -> xr.Posef:
    """Return the same pose, rounded to float32."""
    return xr.Posef(
        orientation=xr.Quaternionf(*map(float, pose.orientation)),
        position=xr.Vector3f(*map(float, pose.position)),
    )


def view_from_xr(view: xr.View) -> View:
    """Return an eye's pose and frustum."""
    fov = view.fov
    angles = Fov(fov.angle_left, fov.angle_right, fov.angle_up, fov.angle_down)
    return View(pose_from_xr(view.pose), angles)
