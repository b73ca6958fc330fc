"""How focus follows what is looked at: the laws of accommodation, one file each.

Each law moves focus by the time since the frame before, whatever that was. All but
`low_pass_backward_euler` are exact: two steps are the same as one of their summed length, so
neither frame rate nor dropped frames change how fast focus moves.
"""
