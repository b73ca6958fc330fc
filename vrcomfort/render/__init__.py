"""Renderer: from the poses of a frame to two images, by the passes that a condition needs.

To read from the outside in:

========================= ==========================================================================
`pipeline`                a frame of both eyes; what a session, a replay and the tests call
`graph`                   the list of passes in their order, with reasons; the registered effects
`condition_passes`        the passes of a condition, wired by their textures
`scene_pass`              an eye's scene: colour, depth and velocity, multisampled, then resolved
`focus`                   one focus distance for both eyes
`effects`                 depth of field, motion blur, vignette and others, each a step of the image
`display`                 tone map, photodiode patch, hash of images
`camera`                  where an eye is and was, how the head moved: no OpenGL
`gpu_scene`               a scene on the GPU: `draw_list`, `culling`, `scene_buffers`, `materials`
`lighting`, `shadow`      the sun, lamps, sky and shadow map
`output`                  files of images, numbers and video
`stimulus_check`          how large blur is in a protocol's conditions, before a study
========================= ==========================================================================
"""
