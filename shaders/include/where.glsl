// A branch that few pixels take.
//
// A software rasteriser runs both sides of every branch, but no loop that no pixel wants: with
// SOFTWARE_RASTERISER, which vrcomfort/gpu/shaders.py defines there, it is a loop that runs once.
#ifdef SOFTWARE_RASTERISER
#define WHERE(wanted) for (bool once = (wanted); once; once = false)
#else
#define WHERE(wanted) if (wanted)
#endif
