"""What the scene scripts share: meshes, textures, baked light, and a deterministic GLB writer."""
