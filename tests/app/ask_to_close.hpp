#pragma once

#include <string>

/// Sends every window of a display that can be asked (WM_DELETE_WINDOW) what a window manager sends
/// when the button in its frame is pressed. False: there is none.
bool ask_to_close(const std::string& display);
