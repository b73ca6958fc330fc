"""A scene without OpenGL: loading, data, side-car, animation, floors, glTF."""
