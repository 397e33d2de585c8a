#include "ask_to_close.hpp"

#include <X11/Xlib.h>

bool ask_to_close(const std::string& name) {
  Display* display = XOpenDisplay(name.c_str());
  if (display == nullptr) return false;
  const Atom wm_delete_window = XInternAtom(display, "WM_DELETE_WINDOW", False);
  bool asked = false;
  Window root = 0, parent = 0, *windows = nullptr;
  unsigned count = 0;
  XQueryTree(display, DefaultRootWindow(display), &root, &parent, &windows, &count);
  for (unsigned i = 0; i < count; ++i) {
    Atom* protocols = nullptr;
    int number = 0;
    if (XGetWMProtocols(display, windows[i], &protocols, &number) == 0) continue;
    for (int k = 0; k < number; ++k)
      if (protocols[k] == wm_delete_window) {
        XEvent event{};
        event.xclient.type = ClientMessage;
        event.xclient.window = windows[i];
        event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
        event.xclient.format = 32;
        event.xclient.data.l[0] = static_cast<long>(wm_delete_window);
        asked = XSendEvent(display, windows[i], False, NoEventMask, &event) != 0 || asked;
      }
    XFree(protocols);
  }
  if (windows != nullptr) XFree(windows);
  XCloseDisplay(display);
  return asked;
}
