/* python.exe: the wheel that brings the Win32 Python for the test bed has its DLL alone. */

#include <wchar.h>

__declspec(dllimport) int Py_Main(int argc, wchar_t **argv);

int wmain(int argc, wchar_t **argv) { return Py_Main(argc, argv); }
