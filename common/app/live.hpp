#pragma once

#include "app/chapter.hpp"

namespace app {

/// The scene in a window, until it is closed. Says on standard output what was done when; with
/// `controls`, first of all, where each control stands.
/// Throws std::runtime_error where there is no display. Null in a build without GLFW.
extern void (*const live)(const Chapter& chapter, const measure::RunOptions& run, bool step_given,
                          bool controls);

}  // namespace app
