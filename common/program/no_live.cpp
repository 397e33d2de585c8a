// In place of live.cpp in a build without GLFW.

#include "program/live.hpp"

namespace program {

decltype(live) live = nullptr;

}  // namespace program
