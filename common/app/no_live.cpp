// In place of live.cpp in a build without GLFW.

#include "app/live.hpp"

namespace app {

decltype(live) live = nullptr;

}  // namespace app
